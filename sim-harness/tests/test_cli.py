"""The command line: exit codes, messages, imports."""

from __future__ import annotations

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
from harness_command import run

from nsrm_harness.common.errors import EpisodeFileError
from nsrm_harness.data.calibration import Calibration

ROOT = Path(__file__).parent.parent


def test_help_lists_the_commands_without_importing_them() -> None:
    code = (
        "import sys\n"
        "from nsrm_harness.cli.main import main\n"
        "try:\n    main(['--help'])\nexcept SystemExit:\n    pass\n"
        "heavy = {'pybullet', 'h5py', 'jax', 'pydantic', 'nsrm_harness.domain'}\n"
        "assert not heavy & set(sys.modules)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "episodes" in done.stdout
    assert "look" in done.stdout


def test_bad_input_ends_with_2_and_one_message(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    missing = tmp_path / "none.h5"
    assert run("look", missing, "0") == 2
    message = capsys.readouterr().err
    assert (
        message == f"harness: {missing}: no such episode file: create it with 'harness episodes'\n"
    )
    assert run("episodes", "--split", "train", "--domain", tmp_path / "none.toml") == 2
    assert "cannot read the domain file" in capsys.readouterr().err
    assert run("episodes", "--split", "train", "--steps", "two") == 2
    assert run("episodes", "--split", "train", "--stacks", "1.5") == 2
    assert "1.5 is not in the range 0.0<=x<=1.0" in capsys.readouterr().err
    assert run("sing") == 2


@pytest.mark.slow
def test_episodes_then_look(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, picture = tmp_path / "few.h5", tmp_path / "look.png"
    make = ["episodes", "--split", "test", "--count", "2", "--out", path, "--jobs", "1"]
    make += ["--renderer", "pybullet"]
    assert run(*make) == 0
    printed = capsys.readouterr().out
    assert "2 episodes, " in printed and "; 2 made in " in printed
    assert run(*make) == 0
    assert "already exists" in capsys.readouterr().out
    assert run(*make, "--seed", "1") == 2
    assert "made with other settings" in capsys.readouterr().err

    assert run("look", path, "1", "--out", picture) == 0
    printed = capsys.readouterr().out.splitlines()
    assert printed[1].startswith("1. Move")
    assert printed[2].startswith("2. Move")
    assert printed[-1] == str(picture)
    from PIL import Image

    with Image.open(picture) as image:
        assert (both := image.width) > 2 * 640
        assert len(image.convert("RGB").getcolors(1 << 24) or []) > 100
    assert run("look", path, "2", "--out", picture) == 2
    assert "no episode 2: it has 2, numbered from 0" in capsys.readouterr().err

    lean = tmp_path / "lean.h5"
    assert run(*make, "--out", lean, "--no-final-images") == 0
    assert run("look", lean, "1", "--out", picture) == 0
    with Image.open(picture) as image:
        assert image.width < 0.6 * both


def test_calibration(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "calibration.h5"
    assert run("calibration", "--count", "3", "--renderer", "pybullet", "--out", path) == 0
    calibration = Calibration.load(path)
    count = len(calibration.locations)
    assert count == len(calibration.positions) == len(calibration.cameras) >= 12
    for location, position, camera in zip(
        calibration.locations, calibration.positions, calibration.cameras, strict=True
    ):
        column, row, depth = camera.project(position)
        assert location[0] < column / camera.width < location[2]
        assert location[1] < row / camera.height < location[3]
        assert location[4] == pytest.approx(depth, abs=0.04)
    assert (calibration.positions[:, 2] > 0.05).any(), "some stand on others"
    assert run("calibration", "--out", path) == 2
    assert "already exists: remove it" in capsys.readouterr().err
    path.write_text("no", encoding="utf-8")
    with pytest.raises(EpisodeFileError, match="not a calibration file"):
        Calibration.load(path)


@pytest.mark.slow
def test_ctrl_c_keeps_what_is_finished(tmp_path: Path) -> None:
    path = tmp_path / "many.h5"
    arguments = ["episodes", "--split", "test", "--count", "5000", "--jobs", "1"]
    arguments += ["--renderer", "pybullet", "--out", str(path)]
    # What runs in the background of a script is born deaf to Ctrl-C.
    hearing = "signal.signal(signal.SIGINT, signal.default_int_handler)"
    program = f"import signal; {hearing}; from nsrm_harness.cli.main import main; main({arguments})"
    with subprocess.Popen(
        [sys.executable, "-c", program], cwd=ROOT, stderr=subprocess.PIPE, text=True
    ) as process:
        work = tmp_path / "many.h5.part"
        while process.poll() is None and not any(work.glob("*.h5")):
            time.sleep(0.1)
        process.send_signal(signal.SIGINT)
        try:
            _, message = process.communicate(timeout=600)
        except subprocess.TimeoutExpired:
            process.kill()
            raise
    assert process.returncode == 130, message
    assert "of 5000 episodes finished; run the same command to resume" in message
    assert any(work.glob("*.h5"))
    assert not path.exists()

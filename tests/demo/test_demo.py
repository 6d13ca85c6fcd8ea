"""The demonstration as a newcomer runs it: `cargo demo`, from the root of the checkout."""

from __future__ import annotations

import itertools
import json
import math
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
SEED = "3"
PICTURES = ["initial.png", "predicted.png", "result.png", "overview.png"]
#: What shows the arm at work.
FILMS = ["film.gif", "strip.png"]
#: What has no room for the fingers until another block is moved aside, and where.
CROWDED = ("put the white block to the left of the magenta block", "221")
#: What cannot be done, and where: its second step would have the arm move a block that bears one.
BEARING = (
    "put the white block on the red block and put the red block to the left of the cyan block",
    "207",
)
#: A word that no model of this domain knows.
UNKNOWN = "put the crimson block on the blue block"


def cargo(*arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Runs cargo in the root of the checkout."""
    return subprocess.run(
        ["cargo", *arguments],
        cwd=ROOT,
        env=os.environ | variables,
        capture_output=True,
        text=True,
        timeout=1200,
        check=False,
    )


def demo(out: Path, *arguments: str, **variables: str) -> subprocess.CompletedProcess[str]:
    """Runs the demonstration with its pictures in `out`."""
    return cargo("demo", "--seed", SEED, "--out", str(out), *arguments, **variables)


def picture(path: Path) -> np.ndarray:
    """The picture, which must not be blank: it has many colours, over all of its height."""
    pixels = np.asarray(Image.open(path).convert("RGB"))
    assert pixels.shape[0] >= 240 and pixels.shape[1] >= 320, path
    colors = np.unique(pixels.reshape(-1, 3), axis=0)
    assert len(colors) > 100, f"{path} has {len(colors)} colours"
    for band in np.array_split(pixels, 4):
        assert band.std() > 1, f"a quarter of {path} is blank"
    return pixels


@pytest.fixture(scope="module")
def planned(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, dict[str, Any], str]:
    """Folder, JSON document and text of a demonstration without a sentence."""
    out = tmp_path_factory.mktemp("planned")
    as_json = demo(out, "--json")
    assert as_json.returncode == 0, as_json.stderr
    as_text = demo(out)
    assert as_text.returncode == 0, as_text.stderr
    return out, json.loads(as_json.stdout), as_text.stdout


def test_it_draws_the_scene_the_prediction_and_the_result(
    planned: tuple[Path, dict[str, Any], str],
) -> None:
    out, document, text = planned
    paths = [out / name for name in PICTURES]
    drawn = [picture(path) for path in paths]
    initial, predicted, result, _ = drawn
    assert not np.array_equal(initial, predicted) and not np.array_equal(predicted, result)
    paths += [out / name for name in FILMS]
    assert document["pictures"] == [str(path) for path in paths]
    last = text.rstrip().splitlines()[-1]
    assert all(str(path) in last for path in paths)


def test_the_arm_carries_the_plan_out_and_is_filmed(
    planned: tuple[Path, dict[str, Any], str],
) -> None:
    out, document, text = planned
    for step in document["steps"]:
        outcome = step["outcome"]
        assert outcome["tries"] == 1 and outcome["shifted_m"] == {}
        assert outcome["miss_m"] < 0.002 and outcome["corrected_m"] < 0.005
    assert text.count("from where it was to go") == len(document["steps"])
    picture(out / "strip.png")
    # Some 5 s a step, 8 frames a second; it moves all the time.
    frames = []
    with Image.open(out / "film.gif") as film:
        count = getattr(film, "n_frames", 1)
        assert count > 25 * len(document["steps"])
        for number in range(0, count, 5):
            film.seek(number)
            frames.append(np.asarray(film.convert("RGB")))
    for before, after in itertools.pairwise(frames):
        assert (before != after).any()


def test_without_the_arm_blocks_are_set_down(tmp_path: Path) -> None:
    for name in FILMS:
        (tmp_path / name).write_text("of an earlier run")
    ran = demo(tmp_path, "--no-arm", "--json")
    assert ran.returncode == 0, ran.stderr
    document = json.loads(ran.stdout)
    assert all(step["outcome"]["at_rest"] for step in document["steps"])
    assert all(step["outcome"]["miss_m"] < 0.005 for step in document["steps"])
    assert document["pictures"] == [str(tmp_path / name) for name in PICTURES]
    assert not any((tmp_path / name).exists() for name in FILMS)


def test_a_sub_goal_that_the_arm_cannot_reach_is_refused(tmp_path: Path) -> None:
    sentence, seed = BEARING
    ran = cargo("demo", sentence, "--seed", seed, "--out", str(tmp_path), "--json")
    assert ran.returncode == 2
    first, second = (step["outcome"] for step in json.loads(ran.stdout)["steps"])
    assert first["miss_m"] < 0.005
    reason = second["refused"]
    assert reason.endswith("move it first") and f"refused: {reason}" in ran.stderr
    picture(tmp_path / "result.png")


def test_what_stands_too_near_is_moved_aside_and_told(tmp_path: Path) -> None:
    sentence, seed = CROWDED
    ran = cargo("demo", sentence, "--seed", seed, "--out", str(tmp_path))
    assert ran.returncode == 0, ran.stderr
    assert "was moved aside first" in ran.stdout
    picture(tmp_path / "strip.png")


def test_it_says_what_it_understood_chose_and_plans(
    planned: tuple[Path, dict[str, Any], str],
) -> None:
    _, document, text = planned
    assert document["steps"]
    assert document["corrections"] == []
    for line in document["program"].splitlines():
        assert line.startswith("Action(") and line in text
    for step in document["steps"]:
        assert step["object_id"] != step["reference_id"]
        assert 0 < step["confidence"] <= 1
        assert len(step["sub_goal"]["position"]) == 3
        assert math.isclose(math.hypot(*step["sub_goal"]["orientation"]), 1, abs_tol=1e-3)
        assert step["explanation"] in text
        assert f"{step['sub_goal']['position'][0]:.4f}" in text


def test_the_command_in_rust_plans_the_same_from_the_picture_it_saw(
    planned: tuple[Path, dict[str, Any], str],
) -> None:
    out, document, _ = planned
    scene = str(out / "scene.json")
    arguments = ["plan", "--scene", scene, "--json", document["sentence"]]
    ran = cargo("run", "--quiet", "--release", "--package", "nsrm", "--", *arguments)
    assert ran.returncode == 0, ran.stderr
    steps = json.loads(ran.stdout)["steps"]
    assert len(steps) == len(document["steps"])
    for ours, theirs in zip(steps, document["steps"], strict=True):
        for key in ("action", "object", "reference", "object_id", "reference_id"):
            assert ours[key] == theirs[key]
        np.testing.assert_allclose(
            ours["sub_goal"]["position"], theirs["sub_goal"]["position"], rtol=0, atol=1e-6
        )


def test_the_renderer_that_needs_no_system_library_will_do(tmp_path: Path) -> None:
    ran = demo(tmp_path, NSRM_RENDERER="pybullet")
    assert ran.returncode == 0, ran.stderr
    for name in PICTURES:
        picture(tmp_path / name)


def test_a_sentence_that_cannot_be_obeyed_is_refused_and_the_scene_shown(tmp_path: Path) -> None:
    ran = demo(tmp_path, UNKNOWN)
    assert ran.returncode == 2
    assert "crimson" in ran.stderr
    picture(tmp_path / "initial.png")
    assert not (tmp_path / "result.png").exists()


def test_a_refusal_is_json_too(tmp_path: Path) -> None:
    ran = demo(tmp_path, "--json", UNKNOWN)
    assert ran.returncode == 2
    document = json.loads(ran.stdout)
    assert document["refused"]["kind"] == "unknown_word"
    assert document["pictures"] == [str(tmp_path / "initial.png")]


def test_an_option_that_does_not_exist_is_bad_input(tmp_path: Path) -> None:
    ran = demo(tmp_path, "--no-such-option")
    assert ran.returncode == 2
    assert "no-such-option" in ran.stderr

"""Episode files: the same bytes however they were made, and no ground truth for learning."""

from __future__ import annotations

import ast
import json
import shutil
from dataclasses import asdict, replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from nsrm_harness import domain as domains
from nsrm_harness.common.errors import EpisodeFileError, EpisodeSettingsError
from nsrm_harness.common.workers import LocalProcesses
from nsrm_harness.data import generate as module
from nsrm_harness.data.file import (
    DEPTH_UNIT_M,
    FINAL_IMAGE,
    OBSERVED,
    Demonstrations,
    depth_from_units,
    depth_units,
)
from nsrm_harness.data.generate import SPLITS, Settings, ShardProgress, generate
from nsrm_harness.data.ground_truth import GroundTruth
from nsrm_harness.data.moves import Move, target
from nsrm_harness.data.programs import SHARES_OF, share

DOMAIN = domains.load()
WORKSHOP = domains.load(Path(__file__).parent / "domains" / "workshop.toml")
SETTINGS = replace(SPLITS["train"], count=11, seed=5, renderer="pybullet")
PACKAGE = Path(module.__file__).parent.parent


@pytest.fixture(scope="module")
def episodes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Eleven episodes, made by two processes."""
    path = tmp_path_factory.mktemp("episodes") / "train.h5"
    assert generate(SETTINGS, DOMAIN, path, LocalProcesses(2))
    return path


@pytest.fixture(scope="module")
def stacked(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Forty episodes of one step, half of them with a stack."""
    path = tmp_path_factory.mktemp("stacked") / "train.h5"
    settings = replace(SETTINGS, count=40, steps=(1, 1), stacks=0.5, final_image=False)
    assert generate(settings, DOMAIN, path, LocalProcesses(2))
    return path


@pytest.fixture
def copied(episodes: Path, tmp_path: Path) -> Path:
    return Path(shutil.copy(episodes, tmp_path / "copied.h5"))


@pytest.mark.slow
def test_the_file_is_the_same_after_an_interruption_and_with_one_process(
    episodes: Path, tmp_path: Path
) -> None:
    class StopError(Exception):
        pass

    def interrupt(progress: ShardProgress) -> None:
        if progress.done:
            raise StopError

    path = tmp_path / "train.h5"
    with pytest.raises(StopError):
        generate(SETTINGS, DOMAIN, path, report=interrupt)
    assert not path.exists()
    kept = [shard.name for shard in (tmp_path / "train.h5.part").glob("*.h5")]
    assert kept

    seen: list[int] = []
    assert generate(SETTINGS, DOMAIN, path, report=lambda progress: seen.append(progress.done))
    assert seen[0] > 0, "what was finished is not made again"
    assert seen[-1] == SETTINGS.count
    assert path.read_bytes() == episodes.read_bytes()
    assert list(tmp_path.iterdir()) == [path]


def test_files_without_stacks_keep_their_draws_and_settings(episodes: Path) -> None:
    assert "stacks" not in json.loads(SETTINGS.as_json())
    assert replace(SETTINGS, stacks=0.0).as_json() == SETTINGS.as_json()
    assert json.loads(replace(SETTINGS, stacks=0.5).as_json())["stacks"] == 0.5
    # Episode 10 as it was before there were stacks.
    with GroundTruth(episodes) as judge:
        truth = judge.truth(10)
    assert [(each["color"], each["size"]) for each in truth.attributes] == [
        ("blue", "small"),
        ("magenta", "lego"),
        ("green", "lego"),
        ("blue", "small"),
    ]
    np.testing.assert_allclose(
        [pose.position for pose in truth.initial_poses],
        [
            (0.4843, 0.0547, 0.0200),
            (0.6088, -0.1823, 0.0250),
            (0.5211, -0.0712, 0.0250),
            (0.5572, 0.0369, 0.0200),
        ],
        atol=2e-4,
    )
    (step,) = truth.steps
    assert (step.step.action, step.object_id, step.reference_id) == ("MoveRight", 3, 2)


@pytest.mark.slow
def test_the_share_of_episodes_with_a_stack_is_the_wanted_one(
    stacked: Path, episodes: Path
) -> None:
    raised: list[int] = []
    for path in (stacked, episodes):
        with GroundTruth(path) as judge:
            truths = [judge.truth(index) for index in range(len(judge))]
        raised.append(0)
        for truth in truths:
            bottoms_m = [
                pose.position[2] - edges_m[2] / 2
                for pose, edges_m in zip(truth.initial_poses, truth.edges_m, strict=True)
            ]
            above = [height_m for height_m in bottoms_m if height_m > 0.001]
            assert not above or above == [pytest.approx(0.045, abs=0.006)], "on one other block"
            raised[-1] += len(above)
            if len(truth.steps) == 1:
                assert share(truth.program) in SHARES_OF["train"]
    # Forty draws with probability a half: outside of 10..30 once in a thousand seeds.
    assert 10 <= raised[0] <= 30
    assert raised[1] == 0


def test_a_finished_file_is_left_alone(episodes: Path) -> None:
    before = episodes.stat().st_mtime_ns
    assert not generate(SETTINGS, DOMAIN, episodes)
    assert episodes.stat().st_mtime_ns == before


@pytest.mark.parametrize("change", [{"seed": 6}, {"count": 12}, {"objects": (4, 5)}])
def test_other_settings_do_not_overwrite(
    episodes: Path, tmp_path: Path, change: dict[str, int]
) -> None:
    other = replace(SETTINGS, **change)
    with pytest.raises(EpisodeFileError, match="made with other settings: remove it"):
        generate(other, DOMAIN, episodes)
    begun = tmp_path / "begun.h5"
    module._prepare(tmp_path / "begun.h5.part", SETTINGS, DOMAIN)
    with pytest.raises(EpisodeFileError, match="started with other settings"):
        generate(other, DOMAIN, begun)


def test_what_can_be_learned_from_is_there(episodes: Path) -> None:
    with Demonstrations(episodes) as demonstrations:
        assert len(demonstrations) == 11
        assert demonstrations.domain == DOMAIN
        assert demonstrations.split == "train"
        assert demonstrations.initial_boxes.shape == (11, 6, 4)
        assert demonstrations.initial_image(10).shape == (480, 640, 3)
        for index, count in enumerate(demonstrations.object_count):
            boxes = demonstrations.initial_boxes[index]
            assert (boxes[:count, 0] < boxes[:count, 2]).all()
            assert (boxes[:count, 1] < boxes[:count, 3]).all()
            assert not boxes[count:].any()
            moved = (demonstrations.final_boxes[index] != boxes).any(axis=1)
            assert moved.any()
        assert demonstrations.camera(0).width == 640
        assert demonstrations.only_camera() == demonstrations.camera(0)
        demonstrations.cameras[-1, 0] += 1.0
        with pytest.raises(EpisodeFileError, match="seen by several cameras"):
            demonstrations.only_camera()


@pytest.mark.slow
def test_without_final_pictures_everything_else_is_the_same(episodes: Path, tmp_path: Path) -> None:
    path = tmp_path / "lean.h5"
    generate(replace(SETTINGS, final_image=False), DOMAIN, path, LocalProcesses(2))
    with Demonstrations(episodes) as whole, Demonstrations(path) as lean:
        assert whole.sentences == lean.sentences
        for name in ("initial_boxes", "initial_depths", "final_boxes", "final_depths", "cameras"):
            np.testing.assert_array_equal(getattr(lean, name), getattr(whole, name), name)
        for index in range(11):
            np.testing.assert_array_equal(lean.initial_image(index), whole.initial_image(index))
            np.testing.assert_array_equal(lean.initial_depth(index), whole.initial_depth(index))
            assert lean.final_image(index) is None
    with GroundTruth(episodes) as whole_truth, GroundTruth(path) as lean_truth:
        for index in range(11):
            lean, whole = (asdict(one.truth(index)) for one in (lean_truth, whole_truth))
            np.testing.assert_equal(lean, whole)


def test_the_depth_image_is_that_of_the_blocks_and_the_table(episodes: Path) -> None:
    with Demonstrations(episodes) as demonstrations:
        for index, count in enumerate(demonstrations.object_count):
            depth = demonstrations.initial_depth(index)
            assert depth.shape == (480, 640)
            assert depth.dtype == np.float32
            for row in range(count):
                x1, y1, x2, y2 = demonstrations.initial_boxes[index, row] * (640, 480, 640, 480)
                center = depth[int((y1 + y2) / 2), int((x1 + x2) / 2)]
                assert abs(center - demonstrations.initial_depths[index, row]) < 0.05
            # Below the camera's aim the table is flat: depth falls evenly down the image.
            column = depth[-40:, 5].astype(np.float64)
            assert (np.diff(column) < 0).all()
            assert np.abs(np.diff(column, 2)).max() < 3e-4


def test_depths_are_stored_to_half_a_unit_and_what_is_none_as_zero() -> None:
    depth = np.array([[0.3, 1.23456, 4.0], [np.nan, -1.0, 1e9]], dtype=np.float32)
    stored = depth_from_units(depth_units(depth))
    np.testing.assert_allclose(stored[0], depth[0], atol=DEPTH_UNIT_M / 2 + 1e-6)
    assert not stored[1].any()


def observed_bytes(path: Path) -> list[bytes]:
    """All that `Demonstrations` gives, as bytes."""
    with Demonstrations(path) as demonstrations:
        return [
            "\n".join(demonstrations.sentences).encode(),
            demonstrations.data_hash().encode(),
            *(
                array.tobytes()
                for array in (
                    demonstrations.object_count,
                    demonstrations.initial_boxes,
                    demonstrations.initial_depths,
                    demonstrations.final_boxes,
                    demonstrations.final_depths,
                    demonstrations.cameras,
                )
            ),
            *(demonstrations.initial_image(index).tobytes() for index in range(11)),
            *(np.asarray(demonstrations.final_image(index)).tobytes() for index in range(11)),
            *(demonstrations.initial_depth(index).tobytes() for index in range(11)),
        ]


def test_shuffled_or_missing_truth_changes_nothing_that_is_learned_from(
    episodes: Path, copied: Path
) -> None:
    before = observed_bytes(episodes)
    with h5py.File(copied, "r+") as file:
        truth = file["evaluation"]
        assert isinstance(truth, h5py.Group)
        for name in list(truth):
            values = truth[name][:]  # type: ignore[index]
            truth[name][:] = np.roll(values, 1, axis=0)  # type: ignore[index]
    assert observed_bytes(copied) == before
    with h5py.File(copied, "r+") as file:
        del file["evaluation"]
    assert observed_bytes(copied) == before
    with pytest.raises(EpisodeFileError, match="no ground truth for evaluation"):
        GroundTruth(copied)


@pytest.mark.parametrize("name", (*OBSERVED, FINAL_IMAGE))
def test_the_data_hash_covers_everything_that_is_learned_from(copied: Path, name: str) -> None:
    with Demonstrations(copied) as demonstrations:
        before = demonstrations.data_hash()
    with h5py.File(copied, "r+") as file:
        values = file[name][7]  # type: ignore[index]
        file[name][7] = "put red on blue" if name == "sentence" else values + 1  # type: ignore[index]
    with Demonstrations(copied) as demonstrations:
        assert demonstrations.data_hash() != before


def test_only_the_judges_tools_import_the_judge_and_few_modules_open_hdf5() -> None:
    importers: dict[str, set[str]] = {"nsrm_harness.data.ground_truth": set(), "h5py": set()}
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names: list[str] = []
            if isinstance(node, ast.Import):
                names = [alias.name for alias in node.names]
            elif isinstance(node, ast.ImportFrom) and node.module:
                names = [node.module, *(f"{node.module}.{alias.name}" for alias in node.names)]
            for name in importers.keys() & set(names):
                importers[name].add(str(path.relative_to(PACKAGE)))
    assert importers["nsrm_harness.data.ground_truth"] <= {
        # The paper tells its baseline where the steps of a command end.
        "learning/baseline/words.py",
        "cli/commands/look.py",
        "visualization/illustrate.py",
        "paper/tables/concepts.py",
        "paper/tables/failures.py",
        "data/between.py",
        "data/extremes.py",
        "data/compounds.py",
        "data/distances.py",
        "data/exceptions.py",
        "data/shifts.py",
        "data/on_table.py",
        "data/ordinals.py",
        "data/relations.py",
        "data/several.py",
        "data/tell.py",
        "evaluation/compounds.py",
        "evaluation/language.py",
        "evaluation/metrics.py",
        "evaluation/on_table.py",
        "evaluation/refusals/measure.py",
        "evaluation/relations.py",
    }
    assert importers["h5py"] == {
        "data/calibration.py",
        "data/file.py",
        "data/generate.py",
        "data/writer.py",
    }


def test_the_judge_knows_what_happened(episodes: Path) -> None:
    with Demonstrations(episodes) as demonstrations, GroundTruth(episodes) as judge:
        assert len(judge) == 11
        for index in range(11):
            truth = judge.truth(index)
            assert len(truth.steps) == 1 + index % 2
            assert len(truth.attributes) == demonstrations.object_count[index]
            if len(truth.steps) == 1:
                assert share(truth.program) in SHARES_OF["train"]
            last = truth.steps[-1]
            seen = demonstrations.final_boxes[index, last.object_id - 1]
            assert last.location[:4] == pytest.approx(seen)
            first = truth.steps[0]
            assert set(first.step.object) <= set(truth.attributes[first.object_id - 1].values())
            assert truth.name(first.object_id).split()[0] in ("small", "lego")
        with pytest.raises(EpisodeFileError, match="no episode 11: it has 11"):
            judge.truth(11)


def test_sub_goals_are_where_the_program_says(episodes: Path) -> None:
    from nsrm_harness.simulation.blocks import block_from_attributes

    with GroundTruth(episodes) as judge:
        truth = judge.truth(0)
    blocks = [block_from_attributes(DOMAIN, values) for values in truth.attributes]
    assert truth.edges_m == pytest.approx(np.array([block.edges_m for block in blocks]))
    step = truth.steps[0]
    move = Move(DOMAIN.action(step.step.action), step.object_id - 1, step.reference_id - 1)
    assert step.sub_goal.distance_m(target(move, blocks, truth.initial_poses)) < 0.005


def test_another_domain_needs_another_file_only(tmp_path: Path) -> None:
    path = tmp_path / "workshop.h5"
    settings = Settings("test", 4, renderer="pybullet", attributes=(1, 3))
    generate(settings, WORKSHOP, path)
    with Demonstrations(path) as demonstrations, GroundTruth(path) as judge:
        assert demonstrations.domain == WORKSHOP
        actions = {action.name for action in WORKSHOP.actions}
        assert {step.action for step in judge.truth(0).program} <= actions


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"steps": (0, 1)}, r"steps: expected MIN <= MAX within 1\.\.8, got 0-1"),
        ({"steps": (3, 2)}, "steps: expected"),
        ({"objects": (1, 4)}, r"objects: expected .* 2\.\.16"),
        ({"attributes": (3, 3)}, r"attributes: expected .* 1\.\.2"),
        ({"exclude": (("small", "pink"),)}, "exclude: unknown attribute value 'pink'"),
        ({"count": 0}, "count must be at least 1"),
        ({"stacks": 1.5}, r"stacks: expected a share within 0\.\.1, got 1\.5"),
        ({"stacks": -0.1}, r"stacks: expected a share within 0\.\.1, got -0\.1"),
        ({"stacks": float("nan")}, r"stacks: expected a share within 0\.\.1, got nan"),
        ({"renderer": "crayon"}, "renderer: expected one of"),
    ],
)
def test_impossible_settings_are_refused(change: dict[str, object], message: str) -> None:
    with pytest.raises(EpisodeSettingsError, match=message):
        replace(SETTINGS, **change).checked(DOMAIN)  # type: ignore[arg-type]


def test_stacks_need_an_action_that_makes_them() -> None:
    beside = replace(DOMAIN, actions=tuple(each for each in DOMAIN.actions if each.direction))
    SETTINGS.checked(beside)
    with pytest.raises(EpisodeSettingsError, match="no action that puts a block on another"):
        replace(SETTINGS, stacks=0.5).checked(beside)


@pytest.mark.parametrize("damage", ["missing", "text", "other", "schema", "dataset"])
def test_what_is_no_episode_file_is_refused(copied: Path, damage: str) -> None:
    messages = {
        "missing": "no such episode file",
        "text": "not an episode file",
        "other": "no attribute kind",
        "schema": "schema 99, this version reads 2",
        "dataset": "no dataset 'final/boxes'",
    }
    if damage == "missing":
        copied.unlink()
    elif damage == "text":
        copied.write_text("put red on blue", encoding="utf-8")
    else:
        with h5py.File(copied, "r+") as file:
            if damage == "other":
                del file.attrs["kind"]
            elif damage == "schema":
                file.attrs["schema"] = 99
            else:
                del file["final/boxes"]
    with pytest.raises(EpisodeFileError, match=messages[damage]):
        Demonstrations(copied)


def test_the_file_says_how_it_was_made(episodes: Path) -> None:
    with h5py.File(episodes) as file:
        assert file.attrs["stream"] == 1
        assert str(file.attrs["renderer"]).startswith("pybullet: ")
        assert json.loads(str(file.attrs["settings"]))["seed"] == 5
        assert "pybullet" in json.loads(str(file.attrs["versions"]))
        assert domains.from_json(str(file.attrs["domain"]), "file") == DOMAIN

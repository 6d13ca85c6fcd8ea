"""The module `nsrm`: what goes in, what comes out, and each exception."""

from __future__ import annotations

import json
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.stats import beta

import nsrm

MODEL_FILE = Path(__file__).parents[3] / "weights-codegen/tabletop/tabletop.safetensors"
SENTENCE = "put the red block on the blue block"
WIDTH, HEIGHT = 640, 480
# On the image: red, blue. Corners in pixels.
BLOCKS = {1: ((64, 120, 96, 144), (204, 23, 23)), 2: ((320, 240, 352, 264), (23, 51, 204))}


@pytest.fixture(scope="module")
def model() -> nsrm.Model:
    return nsrm.Model.pretrained()


@pytest.fixture(scope="module")
def image() -> np.ndarray:
    image = np.full((HEIGHT, WIDTH, 3), 120, np.uint8)
    for (x1, y1, x2, y2), color in BLOCKS.values():
        image[y1:y2, x1:x2] = color
    return image


def camera(**changes: Any) -> nsrm.Camera:
    """Looks straight down on the table, where blocks of 4 cm are 1.125 m away."""
    fields: dict[str, Any] = {
        "width": WIDTH,
        "height": HEIGHT,
        "fx": 900.0,
        "fy": 720.0,
        "cx": 320.0,
        "cy": 240.0,
        "position": (0.5, 0.0, 1.1525),
        "orientation": (1.0, 0.0, 0.0, 0.0),
    }
    return nsrm.Camera(**(fields | changes))


def boxes() -> np.ndarray:
    corners = np.array([corners for corners, _ in BLOCKS.values()], np.float32)
    return corners / np.array([WIDTH, HEIGHT, WIDTH, HEIGHT], np.float32)


def depths() -> np.ndarray:
    return np.array([1.125, 1.125], np.float32)


@pytest.fixture(scope="module")
def scene(model: nsrm.Model, image: np.ndarray) -> nsrm.Scene:
    return model.observe(image, list(BLOCKS), boxes(), depths(), camera())


def expected_crop(image: np.ndarray, box: np.ndarray) -> np.ndarray:
    """Two by two bilinear samples a pixel, in float64: [3, 32, 32]."""
    x1, y1, x2, y2 = box.astype(np.float64)
    fractions = (np.arange(64) + 0.5) / 64
    columns = (x1 + fractions * (x2 - x1)) * WIDTH - 0.5
    rows = (y1 + fractions * (y2 - y1)) * HEIGHT - 0.5

    def neighbours(places: np.ndarray, size: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        before = np.floor(places).astype(int)
        ends = np.clip(before, 0, size - 1), np.clip(before + 1, 0, size - 1)
        return *ends, places - before

    left, right, across = neighbours(columns, WIDTH)
    upper, lower, down = neighbours(rows, HEIGHT)
    pixels = image.astype(np.float64)
    across, down = across[None, :, None], down[:, None, None]
    top = pixels[upper][:, left] * (1 - across) + pixels[upper][:, right] * across
    bottom = pixels[lower][:, left] * (1 - across) + pixels[lower][:, right] * across
    samples = top * (1 - down) + bottom * down
    return samples.reshape(32, 2, 32, 2, 3).mean((1, 3)).transpose(2, 0, 1) / 255


def test_crop_is_sampled_as_documented() -> None:
    image = np.random.default_rng(3).integers(0, 256, (HEIGHT, WIDTH, 3), np.uint8)
    for box in ([0.0, 0.0, 1.0, 1.0], [0.25, 0.5, 0.3125, 0.55], [0.9, 0.0, 1.0, 0.02]):
        box = np.array(box, np.float32)
        crop = nsrm.crop(image, box)
        assert crop.dtype == np.float32 and crop.shape == (3, 32, 32)
        np.testing.assert_allclose(crop, expected_crop(image, box), atol=2e-4)


def test_scene_holds_what_was_observed(model: nsrm.Model, scene: nsrm.Scene, image: np.ndarray):
    assert len(scene) == 2
    assert scene.ids.tolist() == [1, 2]
    np.testing.assert_array_equal(scene.locations, np.column_stack([boxes(), depths()]))
    assert scene.embeddings.shape == (2, 64) and scene.embeddings.dtype == np.float32
    for box, embedding in zip(boxes(), scene.embeddings, strict=True):
        np.testing.assert_array_equal(model.encode_crop(nsrm.crop(image, box)), embedding)


def test_scene_from_embeddings_is_the_observed_one(model: nsrm.Model, scene: nsrm.Scene):
    again = model.scene_from_embeddings([1, 2], boxes(), depths(), scene.embeddings, camera())
    np.testing.assert_array_equal(again.locations, scene.locations)
    np.testing.assert_array_equal(again.embeddings, scene.embeddings)


def test_arrays_of_other_number_types_are_taken(model: nsrm.Model, image: np.ndarray) -> None:
    ids = np.array([7, 9])
    corners = boxes().astype(np.float64)
    scene = model.observe(image, ids, corners, [0.5, 1], camera())  # pyright: ignore
    assert scene.ids.tolist() == [7, 9]
    assert len(model.observe(image, [], np.zeros((0, 4)), [], camera())) == 0


def test_similarities_are_cosines_by_name(model: nsrm.Model, scene: nsrm.Scene) -> None:
    similarities = model.similarities(scene.embeddings[0])
    names = [value for attribute in model.info()["attributes"] for value in attribute["values"]]
    assert list(similarities) == names
    assert all(-1.001 <= value <= 1.001 for value in similarities.values())


def test_simulate_and_locate(model: nsrm.Model) -> None:
    here, there = [0.25, 0.25, 0.3, 0.35, 0.9], [0.5, 0.5, 0.6, 0.6, 1.0]
    location = model.simulate("MoveOn", here, there)
    assert location.shape == (5,) and location.dtype == np.float32
    point = model.locate(location, camera())
    assert point.shape == (3,) and np.isfinite(point).all()
    moved = model.locate(location, camera(position=(0.75, -1.0, 2.0)))
    np.testing.assert_allclose(moved - point, [0.25, -1.0, 0.8475], atol=1e-5)
    with pytest.raises(nsrm.NsrmError, match=r'expected one of MoveOn, .* got "Fly"'):
        model.simulate("Fly", here, there)
    with pytest.raises(nsrm.NsrmError, match="reference_location: expected 5 numbers, got 4"):
        model.simulate("MoveOn", here, there[:4])
    with pytest.raises(nsrm.NsrmError, match="location: expected finite"):
        model.locate([float("nan"), 0, 1, 1, 1], camera())


def test_built_in_model_is_the_committed_file(model: nsrm.Model, scene: nsrm.Scene) -> None:
    loaded = nsrm.Model.load(MODEL_FILE)
    assert loaded.info() == model.info()
    assert json.dumps(model.info(), allow_nan=False)  # noqa: TID251
    assert repr(loaded) == repr(model)
    again = loaded.scene_from_embeddings([1, 2], boxes(), depths(), scene.embeddings, camera())
    assert loaded.similarities(again.embeddings[1]) == model.similarities(scene.embeddings[1])


def test_plan_of_a_trained_model(model: nsrm.Model, scene: nsrm.Scene) -> None:
    if not model.info()["training"].get("episodes"):
        pytest.skip("the committed model is not trained")
    program = model.parse(f"{SENTENCE} then move the blue cube to the left of the white one")
    assert program.notation.splitlines()[0] == (
        "Action(MoveOn, Unique(Filter(red, Scene())), Unique(Filter(blue, Scene())))"
    )
    assert [(step.action, step.object, step.reference) for step in program.steps] == [
        ("MoveOn", ["red"], ["blue"]),
        ("MoveLeft", ["blue"], ["white"]),
    ]
    try:
        plan = model.plan(scene, SENTENCE)
    except nsrm.Refused as refusal:
        # Flat patches are no blocks: the model may not know them, or where to put them.
        assert refusal.kind in {"no_such_object", "outside_work_space", "ambiguous"}
        return
    (step,) = plan.steps
    assert plan.program == model.parse(SENTENCE)
    assert (step.object_id, step.reference_id) == (1, 2)
    assert 0 < step.confidence <= 1
    assert plan.confidence == step.confidence
    assert step.location.shape == (5,) and len(step.position) == 3 and len(step.orientation) == 4


def test_refusals_say_why(model: nsrm.Model, scene: nsrm.Scene) -> None:
    with pytest.raises(nsrm.Refused, match='"sofa" is not a word') as caught:
        model.plan(scene, "put the sofa on the blue block")
    assert caught.value.kind == "unknown_word"
    words = {"text": "sofa", "start": 8, "end": 12}
    assert caught.value.details == {"words": words, "suggestion": None}
    assert caught.value.suggestion is None
    assert isinstance(caught.value, nsrm.NsrmError) and isinstance(caught.value, ValueError)
    with pytest.raises(nsrm.Refused) as caught:
        model.parse("put " * 2000)
    assert (caught.value.kind, caught.value.details, caught.value.suggestion) == (
        "sentence_too_long",
        {"limit": 4096, "unit": "bytes"},
        None,
    )
    with pytest.raises(nsrm.Refused) as caught:
        model.parse("red red red small red")
    assert caught.value.kind == "too_many_concepts"
    assert caught.value.details["limit"] == 4
    with pytest.raises(nsrm.Refused) as caught:
        model.parse("put the red blue block on the green block")
    assert caught.value.kind == "conflicting_values"
    assert (caught.value.details["first"], caught.value.details["second"]) == ("red", "blue")


def test_scenes_that_disagree_with_the_calibration_are_refused(
    model: nsrm.Model, scene: nsrm.Scene
) -> None:
    model.check(scene)

    def refused(**changes: Any) -> nsrm.Refused:
        fields = {"depths": depths(), "camera": camera()} | changes
        tampered = model.scene_from_embeddings(
            [1, 2], boxes(), fields["depths"], scene.embeddings, fields["camera"]
        )
        with pytest.raises(nsrm.Refused) as checked:
            model.check(tampered)
        with pytest.raises(nsrm.Refused) as planned:
            model.plan(tampered, SENTENCE)
        assert checked.value.kind == planned.value.kind == "calibration"
        assert checked.value.details == planned.value.details
        assert str(checked.value) == str(planned.value)
        return planned.value

    high = refused(camera=camera(position=(0.5, 0.0, 1.2025)))
    assert "would rest at 0.020 m (2 of 2 objects disagree)" in str(high)
    details = high.details
    assert details["quantity"] == "height" and details["cause"] is None
    assert details["object_id"] in (1, 2) and details["expected_m"] == pytest.approx(0.02)
    assert details["measured_m"] == pytest.approx(0.07, abs=2e-3)
    millimetres = refused(depths=1000 * depths())
    assert "depths look like millimetres; NSRM wants metres" in str(millimetres)
    assert millimetres.details["cause"] == "depths_in_millimetres"


def test_refusals_offer_the_word_that_may_have_been_meant(model: nsrm.Model) -> None:
    with pytest.raises(nsrm.Refused, match='did you mean "green"') as caught:
        model.parse("put the greens block on the red block")
    assert caught.value.suggestion == caught.value.details["suggestion"] == "green"
    with pytest.raises(nsrm.Refused, match="use another one") as caught:
        model.parse("put the red block under the blue block")
    assert caught.value.suggestion is None


def test_misspelt_words_are_told(model: nsrm.Model, scene: nsrm.Scene) -> None:
    program = model.parse("put the gren block on the read block")
    assert [(each.word, each.read_as) for each in program.corrections] == [
        ("gren", "green"),
        ("read", "red"),
    ]
    assert str(program.corrections[0]) == '"gren" was read as "green"'
    assert repr(program.corrections[0]) == 'Correction(word="gren", read_as="green")'
    assert program.steps == model.parse("put the green block on the red block").steps
    plan = model.plan(scene, SENTENCE.replace("block", "blokc", 1))
    assert [each.read_as for each in plan.program.corrections] == ["block"]
    assert model.plan(scene, SENTENCE).program.corrections == []


def test_models_that_are_none(tmp_path: Path) -> None:
    path = tmp_path / "model.safetensors"
    with pytest.raises(nsrm.ModelError, match="cannot read"):
        nsrm.Model.load(path)
    path.write_bytes(b"no model")
    with pytest.raises(nsrm.ModelError, match="not a safetensors file"):
        nsrm.Model.load(str(path))
    damaged = bytearray(MODEL_FILE.read_bytes())
    damaged[-4] ^= 1
    path.write_bytes(damaged)
    with pytest.raises(nsrm.ModelError, match="changed or damaged"):
        nsrm.Model.load(path)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"fx": 0.0}, "fx must be greater than 0"),
        ({"cx": float("nan")}, "cx is not a finite number"),
        ({"orientation": (0.0, 0.0, 0.0, 0.0)}, "orientation"),
        ({"position": (0.0, float("inf"), 0.0)}, "position"),
    ],
)
def test_cameras_that_are_none(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(nsrm.SceneError, match=message):
        camera(**changes)


def test_camera_gives_back_what_it_was_made_of() -> None:
    made = camera(position=np.array([1, 2, 3]))
    assert (made.width, made.height, made.fx, made.fy) == (WIDTH, HEIGHT, 900.0, 720.0)
    assert made.position == (1.0, 2.0, 3.0) and made.orientation == (1.0, 0.0, 0.0, 0.0)
    assert made == camera(position=(1, 2, 3)) and made != camera()
    with pytest.raises(nsrm.NsrmError, match="position: expected 3 numbers, got 2"):
        camera(position=(1, 2))


def test_scenes_that_are_none(model: nsrm.Model, image: np.ndarray) -> None:
    def observe(**changes: Any) -> None:
        fields = {"ids": [1, 2], "boxes": boxes(), "depths": depths(), "camera": camera()}
        model.observe(image, **(fields | changes))

    with pytest.raises(nsrm.SceneError, match="already taken"):
        observe(ids=[1, 1])
    with pytest.raises(nsrm.SceneError, match="depth must be greater than 0"):
        observe(depths=[0.5, -1])
    with pytest.raises(nsrm.SceneError, match="x1 < x2"):
        observe(boxes=boxes()[:, [2, 1, 0, 3]])
    with pytest.raises(nsrm.SceneError, match="finite"):
        observe(boxes=np.full((2, 4), np.nan))
    with pytest.raises(nsrm.SceneError, match="640×480 pixels, but the camera says 320×480"):
        observe(camera=camera(width=320))
    with pytest.raises(nsrm.SceneError, match="17 objects"):
        observe(ids=range(1, 18), boxes=np.tile(boxes()[:1], (17, 1)), depths=np.ones(17))
    with pytest.raises(nsrm.NsrmError, match=r"boxes: expected shape \[2, 4\] for 2 ids"):
        observe(boxes=boxes()[:1])
    with pytest.raises(nsrm.NsrmError, match="depths: expected 2 numbers for 2 ids, got 3"):
        observe(depths=[1, 2, 3])
    with pytest.raises(nsrm.SceneError, match="embedding is not finite"):
        wrong = np.full((2, 64), np.inf)
        model.scene_from_embeddings([1, 2], boxes(), depths(), wrong, camera())
    with pytest.raises(nsrm.NsrmError, match="embeddings: expected shape"):
        model.scene_from_embeddings([1, 2], boxes(), depths(), np.zeros((2, 32)), camera())


def test_arrays_that_are_none(model: nsrm.Model, image: np.ndarray) -> None:
    box = [0.25, 0.25, 0.5, 0.5]
    with pytest.raises(TypeError, match=r"expected a numpy array uint8 .* got float32"):
        nsrm.crop(image.astype(np.float32), box)  # pyright: ignore
    with pytest.raises(TypeError, match="expected a numpy array uint8"):
        nsrm.crop(image.tolist(), box)  # pyright: ignore
    with pytest.raises(TypeError, match="expected a numpy array uint8"):
        nsrm.crop(image[:, :, 0], box)
    with pytest.raises(nsrm.NsrmError, match=r"expected shape \[height, width, 3\]"):
        nsrm.crop(np.zeros((4, 4, 4), np.uint8), box)
    with pytest.raises(nsrm.NsrmError, match="1 to 65535"):
        nsrm.crop(np.zeros((0, 4, 3), np.uint8), box)
    with pytest.raises(nsrm.NsrmError, match="box: expected 4 numbers, got 3"):
        nsrm.crop(image, box[:3])
    with pytest.raises(nsrm.NsrmError, match=r"box: .*x1 < x2"):
        nsrm.crop(image, box[::-1])
    with pytest.raises(TypeError, match="expected a numpy array float32"):
        model.encode_crop(np.zeros((3, 32, 32)))  # pyright: ignore
    with pytest.raises(nsrm.NsrmError, match=r"expected shape \[3, 32, 32\]"):
        model.encode_crop(np.zeros((3, 32, 31), np.float32))
    with pytest.raises(nsrm.NsrmError, match="finite"):
        model.encode_crop(np.full((3, 32, 32), np.nan, np.float32))
    with pytest.raises(nsrm.NsrmError, match="embedding: expected 64 numbers"):
        model.similarities(np.zeros(63))


def test_views_are_read_like_their_copies(model: nsrm.Model, image: np.ndarray) -> None:
    mirrored = image[:, ::-1]
    crop = nsrm.crop(mirrored, [0.25, 0.25, 0.5, 0.5])
    np.testing.assert_array_equal(crop, nsrm.crop(mirrored.copy(), [0.25, 0.25, 0.5, 0.5]))
    flipped = crop[:, ::-1]
    np.testing.assert_array_equal(model.encode_crop(flipped), model.encode_crop(flipped.copy()))
    locations = np.column_stack([boxes(), depths()]).astype(np.float32)
    views = model.observe(mirrored, [1, 2], locations[:, :4], locations[:, 4], camera())
    copies = model.observe(mirrored.copy(), [1, 2], boxes(), depths(), camera())
    np.testing.assert_array_equal(views.embeddings, copies.embeddings)
    np.testing.assert_array_equal(views.locations, copies.locations)


def test_planning_many_is_planning_each(model: nsrm.Model, image: np.ndarray) -> None:
    sentences = ["put the red block on the blue block", "put the sofa on the red block"] * 5
    observed = nsrm.Observed(image, [1, 2], boxes(), depths(), camera())
    assert (len(observed), repr(observed)) == (2, "Observed(ids=[1, 2])")
    scene = model.observe(image, [1, 2], boxes(), depths(), camera())
    results = model.plan_all([observed] * len(sentences), sentences)
    assert len(results) == len(sentences)
    for sentence, result in zip(sentences, results, strict=True):
        try:
            expected = model.plan(scene, sentence)
        except nsrm.Refused as refusal:
            assert isinstance(result, nsrm.Refused)
            assert (result.kind, str(result)) == (refusal.kind, str(refusal))
        else:
            assert isinstance(result, nsrm.Plan)
            assert result.program == expected.program
            assert [s.position for s in result.steps] == [s.position for s in expected.steps]
    assert model.plan_all([], []) == []
    with pytest.raises(nsrm.NsrmError, match="one for each of 1 observations, got 2"):
        model.plan_all([observed], sentences[:2])
    with pytest.raises(nsrm.NsrmError, match="boxes: row 1"):
        nsrm.Observed(image, [1, 2], [boxes()[0], [0.5, 0.5, 0.4, 0.6]], depths(), camera())
    twice = nsrm.Observed(image, [1, 1], boxes(), depths(), camera())
    with pytest.raises(nsrm.SceneError, match=r"observed\[1\]: .*1"):
        model.plan_all([observed, twice], sentences[:2])


def test_threads_share_a_model(model: nsrm.Model, image: np.ndarray) -> None:
    results: list[np.ndarray] = []

    def observe() -> None:
        scene = model.observe(image, [1, 2], boxes(), depths(), camera())
        results.append(scene.embeddings)

    threads = [threading.Thread(target=observe) for _ in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert len(results) == 4
    for embeddings in results[1:]:
        np.testing.assert_array_equal(embeddings, results[0])


@pytest.mark.parametrize(
    ("sentence", "unit", "limit"),
    [
        ("a" * (nsrm.MAX_SENTENCE_BYTES + 1), "bytes", nsrm.MAX_SENTENCE_BYTES),
        ("the " * (nsrm.MAX_TOKENS + 1), "tokens", nsrm.MAX_TOKENS),
    ],
)
def test_capacities_are_those_of_the_core(
    model: nsrm.Model, sentence: str, unit: str, limit: int
) -> None:
    with pytest.raises(nsrm.Refused) as refused:
        model.parse(sentence)
    assert refused.value.kind == "sentence_too_long"
    assert refused.value.details == {"unit": unit, "limit": limit}


def test_the_least_confidence_keeps_the_limit() -> None:
    rng = np.random.default_rng(3)
    confidences = rng.uniform(0.3, 1.0, 4000).astype(np.float32)
    # Wrong below 0.9 as often as not.
    right = (confidences > 0.9) | (rng.uniform(size=4000) < 0.5)
    confidences[::10] = np.nan
    found = nsrm.least_confidence(confidences, right, wrong=0.05)
    assert found.threshold == pytest.approx(0.9)
    taken = confidences >= found.threshold
    assert (found.count, found.wrong) == (taken.sum(), (taken & ~right).sum())
    rows = nsrm.accepted(confidences, right)
    assert rows[0].count == np.isfinite(confidences).sum()
    assert found in rows
    for row in rows:
        if row.wrong < row.count:
            exact = beta.ppf(1 - 0.05 / len(rows), row.wrong + 1, row.count - row.wrong)
            assert row.bound == pytest.approx(exact, abs=1e-9)
    with pytest.raises(nsrm.NsrmError, match="risk: no threshold keeps the limit"):
        nsrm.least_confidence(confidences, np.zeros(4000, bool), wrong=0.05)
    with pytest.raises(nsrm.NsrmError, match="risk: 3600 accepted plans are too few"):
        nsrm.least_confidence(confidences, right)
    with pytest.raises(nsrm.NsrmError, match="right: expected 4000 values"):
        nsrm.least_confidence(confidences, right[1:])
    with pytest.raises(nsrm.NsrmError, match="a level of 1"):
        nsrm.accepted(confidences, right, level=1.0)


def test_a_calibrated_model_refuses_what_is_less_confident(
    model: nsrm.Model, scene: nsrm.Scene, image: np.ndarray, tmp_path: Path
) -> None:
    content = MODEL_FILE.read_bytes()
    path = tmp_path / "calibrated.safetensors"
    path.write_bytes(nsrm.with_confidence(content, 1.0))
    calibrated = nsrm.Model.load(path)
    assert calibrated.info()["thresholds"]["confidence"] == 1.0
    sure = model.plan(scene, SENTENCE).confidence
    scene = calibrated.observe(image, list(BLOCKS), boxes(), depths(), camera())
    with pytest.raises(nsrm.Refused, match="not sure enough of the plan") as refused:
        calibrated.plan(scene, SENTENCE)
    assert refused.value.kind == "low_confidence"
    assert refused.value.details["confidence"] == pytest.approx(sure)
    assert refused.value.details["threshold"] == 1.0
    with pytest.raises(nsrm.ModelError, match="confidence"):
        nsrm.with_confidence(content, 1.5)


def test_a_refusal_asks_back_and_an_answer_completes_the_sentence(
    model: nsrm.Model, scene: nsrm.Scene
) -> None:
    with pytest.raises(nsrm.Refused) as caught:
        model.parse("put the reds block on the blue block")
    question = caught.value.question
    assert question is not None and str(question) == 'do you mean "red"?'
    (choice,) = question.options
    assert choice.answer == '"red"'
    assert choice.sentence == question.complete("yes") == "put the red block on the blue block"
    assert question.complete("no") is None
    with pytest.raises(nsrm.Refused) as caught:
        model.parse("put the red block")
    question = caught.value.question
    assert question is not None and question.options == []
    assert question.complete("on the blue one") == "put the red block on the blue one"
    with pytest.raises(nsrm.Refused) as caught:
        model.parse("put the sofa on the blue block")
    assert caught.value.question is None
    # What is there is offered for what is not.
    with pytest.raises(nsrm.Refused) as caught:
        model.plan(scene, "put the green block on the blue block")
    question = caught.value.question
    assert question is not None and str(question).endswith("red one?")
    completed = question.complete("the red one")
    assert completed is not None
    assert model.plan(scene, completed).steps[0].object_id == 1

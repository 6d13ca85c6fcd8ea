"""The trainer's golden vectors through the Python module: built-in and loaded model."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from safetensors.numpy import load_file

import nsrm

ROOT = Path(__file__).resolve().parents[3]
FOLDER = ROOT / "tests" / "golden"
MODEL = ROOT / "weights-codegen/tabletop/tabletop.safetensors"


class Golden:
    """Arrays by name, and the cases that refer to them."""

    def __init__(self) -> None:
        self.arrays = load_file(FOLDER / "golden.safetensors")
        self.cases: dict[str, Any] = json.loads((FOLDER / "cases.json").read_text("utf-8"))

    def close(self, tolerance: str, got: Any, expected: Any) -> None:
        """Asserts that `got` is `expected` within the tolerance of this name."""
        named = self.cases["tolerances"][tolerance]
        np.testing.assert_allclose(got, expected, rtol=named["relative"], atol=named["absolute"])

    def camera(self, scene: int) -> nsrm.Camera:
        """The camera of a scene."""
        return nsrm.Camera(**self.cases["scenes"][scene]["camera"])

    def scene(self, model: nsrm.Model, number: int) -> nsrm.Scene:
        """A scene, its crops encoded by the module."""
        locations = self.arrays[f"scene.{number}.locations"]
        crops = self.arrays[f"scene.{number}.crops"]
        embeddings = np.array([model.encode_crop(crop) for crop in crops], np.float32)
        return model.scene_from_embeddings(
            self.cases["scenes"][number]["ids"],
            locations[:, :4],
            locations[:, 4],
            embeddings.reshape(len(crops), 64),
            self.camera(number),
        )


@pytest.fixture(scope="module")
def golden() -> Golden:
    return Golden()


@pytest.fixture(scope="module", params=["built in", "loaded"])
def model(request: pytest.FixtureRequest, golden: Golden) -> nsrm.Model:
    model = nsrm.Model.pretrained() if request.param == "built in" else nsrm.Model.load(MODEL)
    assert golden.cases["model_identity"] == model.info()["identity"], (
        "the vectors are of another model; write them again with cargo harness golden"
    )
    return model


def test_crops(golden: Golden) -> None:
    image = golden.arrays["crop.image"]
    boxes, outputs = golden.arrays["crop.boxes"], golden.arrays["crop.output"]
    assert len(boxes) > 0
    for box, expected in zip(boxes, outputs, strict=True):
        golden.close("crop", nsrm.crop(image, box), expected)


def test_vision(golden: Golden, model: nsrm.Model) -> None:
    crops = golden.arrays["vision.crops"]
    embeddings = golden.arrays["vision.embeddings"]
    cosines = golden.arrays["vision.similarities"]
    assert len(crops) > 0
    for crop, embedding, expected in zip(crops, embeddings, cosines, strict=True):
        golden.close("embedding", model.encode_crop(crop), embedding)
        golden.close("cosine", list(model.similarities(embedding).values()), expected)


def test_simulator_and_camera(golden: Golden, model: nsrm.Model) -> None:
    names = model.info()["actions"]
    rows = zip(
        golden.arrays["simulator.action"],
        golden.arrays["simulator.moved"],
        golden.arrays["simulator.reference"],
        golden.arrays["simulator.output"],
        golden.arrays["camera.position"],
        strict=True,
    )
    for action, moved, reference, output, position in rows:
        golden.close("location", model.simulate(names[action], moved, reference), output)
        golden.close("position_m", model.locate(output, golden.camera(0)), position)


def test_plans(golden: Golden, model: nsrm.Model) -> None:
    plans = golden.cases["plans"]
    assert any("steps" in case for case in plans) and any("refused" in case for case in plans)
    for number, case in enumerate(plans):
        scene = golden.scene(model, case["scene"])
        if "refused" in case:
            with pytest.raises(nsrm.Refused) as refused:
                model.plan(scene, case["sentence"])
            assert refused.value.kind == case["refused"]["kind"]
            if "candidates" in case["refused"]:
                listed = refused.value.details["candidates"]
                found = [candidate["object_id"] for candidate in listed]
                assert found == case["refused"]["candidates"]
            continue
        plan = model.plan(scene, case["sentence"])
        check_steps(golden, plan, case["steps"], f"plan.{number}")
        parsed = model.parse(case["sentence"])
        assert parsed.notation == plan.program.notation


def check_steps(golden: Golden, plan: nsrm.Plan, expected: list[dict[str, Any]], name: str) -> None:
    """The steps of a plan against those of the trainer."""

    def array(part: str) -> NDArray[np.float32]:
        return golden.arrays[f"{name}.{part}"]

    for index, (step, case) in enumerate(zip(plan.steps, expected, strict=True)):
        assert step.action == case["action"]
        assert sorted(step.object) == sorted(case["object"])
        assert sorted(step.reference) == sorted(case["reference"])
        assert (step.object_id, step.reference_id) == (case["object_id"], case["reference_id"])
        golden.close("cosine", step.object_score, array("object_scores")[index].max())
        golden.close("cosine", step.reference_score, array("reference_scores")[index].max())
        golden.close("location", step.location, array("locations")[index])
        golden.close("position_m", step.position, array("positions")[index])

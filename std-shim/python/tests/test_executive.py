"""The closed loop in Python: events come typed, and say what is to be done."""

from __future__ import annotations

import gc
import math
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import pytest

import nsrm

MODEL_FILE = Path(__file__).parents[3] / "weights-codegen/tabletop/tabletop.safetensors"
SENTENCE = "put the red block to the right of the blue block"
MS = 1_000_000
ACCEPTED, REACHED, NOT_GRASPED, STOPPED, CLEARING = 1, 2, 4, 7, 16
"""Of the messages' `Outcome`."""

Kind = TypeVar("Kind")


class World:
    """Red and blue on a table, under a camera that looks straight down, and an executive."""

    def __init__(self, model: nsrm.Model, limits: nsrm.Limits | None = None) -> None:
        self.model, self.executive = model, nsrm.Executive(model, limits)
        self.camera = nsrm.Camera(
            640, 480, 900.0, 720.0, 320.0, 240.0, (0.5, 0.0, 1.1525), (1.0, 0.0, 0.0, 0.0)
        )
        image = np.full((480, 640, 3), 120, np.uint8)
        image[220:244, 224:256], image[240:264, 320:352] = (204, 23, 23), (23, 51, 204)
        boxes = np.array([(224, 220, 256, 244), (320, 240, 352, 264)], np.float32)
        self.locations = np.column_stack([boxes / (640, 480, 640, 480), [1.125, 1.125]])
        self.embeddings = model.observe(
            image, [1, 2], self.locations[:, :4], self.locations[:, 4], self.camera
        ).embeddings
        self.now_ns = 10_000 * MS

    def see(self, age_ns: int = 0) -> str | None:
        scene = self.model.scene_from_embeddings(
            [1, 2], self.locations[:, :4], self.locations[:, 4], self.embeddings, self.camera
        )
        return self.executive.on_scene(scene, self.now_ns - age_ns, self.now_ns)

    def hear(self, command: nsrm.Command, outcome: int, **details: Any) -> None:
        self.executive.on_feedback(command.plan, command.command, outcome, self.now_ns, **details)

    def next(self, kind: type[Kind]) -> Kind:
        """The next event that is not work or waiting, with a scene each 10 ms."""
        for _ in range(100_000):
            event = self.executive.poll(self.now_ns)
            if isinstance(event, nsrm.Waiting):
                self.now_ns += 10 * MS
                self.see()
            elif not isinstance(event, nsrm.Working):
                assert isinstance(event, kind), event
                return event
        raise AssertionError(kind)

    def carry_out(self, command: nsrm.Command) -> None:
        self.locations[command.object_id - 1] = command.location
        self.hear(command, REACHED)


@pytest.fixture(scope="module")
def model() -> nsrm.Model:
    return nsrm.Model.pretrained()


def test_a_sentence_is_carried_out(model: nsrm.Model) -> None:
    world = World(model)
    assert world.executive.plan is None
    assert world.executive.ask(SENTENCE) == world.executive.plan == 1
    planned = world.next(nsrm.Planned)
    (step,) = planned.plan.steps
    assert planned.first == 0
    command = world.next(nsrm.Command)
    assert (command.plan, command.command, command.step, command.steps) == (1, 1, 0, 1)
    assert (command.object_id, command.reference_id) == (1, 2)
    assert (command.action, command.position) == (step.action, step.position)
    assert command.orientation == step.orientation and command.confidence == step.confidence
    assert command.until_ns == world.now_ns + nsrm.Limits().accept_wait_ns
    world.hear(command, ACCEPTED)
    world.hear(command, CLEARING, objects=(2, 0))
    assert world.next(nsrm.Clearing).first == (2, 0)
    world.now_ns += 5000 * MS
    world.carry_out(command)
    reached = world.next(nsrm.Reached)
    assert reached.step == 0 and reached.off_m < 0.001
    assert world.next(nsrm.Ended).why is None
    assert world.executive.plan is None
    assert isinstance(world.executive.poll(world.now_ns), nsrm.Waiting)


def test_what_goes_wrong_is_tried_again_and_then_told(model: nsrm.Model) -> None:
    world = World(model, nsrm.Limits(attempts=2))
    world.executive.ask(SENTENCE)
    for number in (1, 2):
        world.next(nsrm.Planned)
        command = world.next(nsrm.Command)
        assert command.command == number
        world.hear(command, NOT_GRASPED, objects=(2, 0))
        if number == 1:
            again = world.next(nsrm.Again)
            assert (again.step, again.why.kind) == (0, "unsuccessful")
    why = world.next(nsrm.Ended).why
    assert why is not None
    assert (why.kind, why.step, why.outcome, why.objects) == ("unsuccessful", 0, 4, (2, 0))
    assert str(why) == why.message and "did not grasp" in why.message
    assert why.refusal is why.object_id is why.off_m is None


def test_what_is_elsewhere_is_named(model: nsrm.Model) -> None:
    world = World(model, nsrm.Limits(retries=0))
    world.executive.ask(SENTENCE)
    world.next(nsrm.Planned)
    command = world.next(nsrm.Command)
    world.hear(command, REACHED)
    why = world.next(nsrm.Ended).why
    assert why is not None and (why.kind, why.object_id) == ("not_there", 1)
    assert why.off_m is not None and why.off_m > 0.015


def test_a_refusal_comes_with_the_failure(model: nsrm.Model) -> None:
    world = World(model)
    world.executive.ask("put the red block on the green block")
    why = world.next(nsrm.Ended).why
    assert why is not None and why.kind == "no_such_object"
    assert why.refusal is not None and why.refusal.kind == why.kind
    assert str(why.refusal) == why.message
    with pytest.raises(nsrm.Refused) as caught:
        world.executive.ask("put the red block on the blue block " * 200)
    assert caught.value.kind == "sentence_too_long"


def test_a_cancelled_sentence_stops_the_controller(model: nsrm.Model) -> None:
    world = World(model)
    world.executive.ask(SENTENCE)
    with pytest.raises(nsrm.NsrmError, match="being executed"):
        world.executive.ask(SENTENCE)
    world.next(nsrm.Planned)
    command = world.next(nsrm.Command)
    world.executive.cancel()
    stop = world.next(nsrm.Stop)
    assert (stop.plan, stop.command) == (command.plan, command.command)
    world.hear(command, STOPPED)
    why = world.next(nsrm.Ended).why
    assert why is not None and why.kind == "cancelled"


@pytest.mark.parametrize(
    ("lose", "kind"),
    [("on_controller_lost", "controller_lost"), ("on_command_undelivered", "not_accepted")],
)
def test_a_controller_that_is_gone_is_told_of(model: nsrm.Model, lose: str, kind: str) -> None:
    world = World(model)
    world.executive.ask(SENTENCE)
    world.next(nsrm.Planned)
    world.next(nsrm.Command)
    getattr(world.executive, lose)()
    if kind == "controller_lost":
        world.next(nsrm.Stop)
    why = world.next(nsrm.Ended).why
    assert why is not None and (why.kind, why.step) == (kind, 0)


def test_modes(model: nsrm.Model) -> None:
    world = World(model)
    world.executive.ask(SENTENCE, "plan_only")
    world.next(nsrm.Planned)
    assert world.next(nsrm.Ended).why is None
    world.executive.ask(SENTENCE, "open_loop")
    world.next(nsrm.Planned)
    world.hear(world.next(nsrm.Command), REACHED)
    # The scene is not observed again.
    assert math.isnan(world.next(nsrm.Reached).off_m)
    assert world.next(nsrm.Ended).why is None
    with pytest.raises(nsrm.NsrmError, match="mode: expected closed_loop, open_loop or plan_only"):
        world.executive.ask(SENTENCE, "ajar")  # type: ignore[arg-type]


def test_scenes_and_words_that_are_not_acted_upon(model: nsrm.Model) -> None:
    world = World(model)
    assert world.see(age_ns=600 * MS) == (
        "the scene is 600 ms old, 500 ms are allowed: does the camera work?"
    )
    assert world.see() is None
    assert "older than the previous one" in str(world.see(age_ns=MS))
    world.executive.on_feedback(7, 1, REACHED, world.now_ns)
    with pytest.raises(nsrm.NsrmError, match="77"):
        world.executive.on_feedback(7, 1, 77, world.now_ns)


def test_limits() -> None:
    usual = nsrm.Limits()
    assert usual == nsrm.Limits() != nsrm.Limits(retries=1)
    assert usual.moved_m < usual.covered_m < usual.tolerance_m
    with pytest.raises(nsrm.NsrmError, match="limits: attempts: must be 1 or more"):
        nsrm.Limits(attempts=0)
    with pytest.raises(AttributeError):
        usual.retries = 2  # type: ignore[misc]


def test_a_model_from_a_file_outlives_its_name() -> None:
    world = World(nsrm.Model.load(MODEL_FILE))
    del world.model
    gc.collect()
    world.executive.ask("put the purple block on the blue block")
    why = world.next(nsrm.Ended).why
    assert why is not None and why.kind == "unknown_word"


def test_events_say_what_they_are(model: nsrm.Model) -> None:
    world = World(model)
    assert repr(world.executive) == "Executive(plan=None)"
    assert repr(world.executive.poll(0)) == "Waiting()"
    world.executive.ask(SENTENCE)
    assert repr(world.next(nsrm.Planned)) == "Planned(first=0)"
    assert repr(world.next(nsrm.Command)).startswith("Command(plan=1, command=1, step=0")

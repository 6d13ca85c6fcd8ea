"""Says how far an object is moved from where it is: "move the red block 5 cm to the left"; and near
misses, which move nothing so."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nsrm_harness.data.compounds import Put, bases
from nsrm_harness.data.distances import DISTANCES_MM, NONE, DistanceSentences
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.moves import Arrangement
from nsrm_harness.data.programs import Descriptions, unique_descriptions
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import ALL, ITSELF, Program, Step
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import block_from_attributes

#: Share of sentences with a further step, and of these with another one before.
FOLLOWED, PRECEDED = 0.4, 0.4
#: Share of sentences in which several objects are moved.
SEVERAL = 0.1
#: How a distance stands before a direction, and behind it.
BEFORE = ("{}", "{}", "about {}", "exactly {}", "just {}", "by {}", "a distance of {}")
BEHIND = ("by {}", "{}", "by about {}", "by exactly {}")
#: Behind both.
ORIGINS = ("from where it is", "from its current position", "of where it is now")


class ShiftSentences(DistanceSentences):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        super().__init__(domain, rng)
        if domain.distances is None or not domain.distances.shifts:
            raise ValueError("the domain's wording moves nothing from where it is")
        self._shifts = domain.distances.shifts

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        words, step = self._shift()
        if self._rng.random() >= FOLLOWED:
            return words, (step,)
        further = self._step()
        other = self._put(further, self._place(further))
        connective = self._choose((", then", "and then", "."))
        if self._rng.random() < PRECEDED:
            return f"{other} {connective} {words}", (further, step)
        return f"{words} {connective} {other}", (step, further)

    def of_step(self, step: Step) -> str:
        """A sentence of a step that moves its object from where it is."""
        return self._said(step, f"{step.distance_mm} mm")

    def _shift(self) -> tuple[str, Step]:
        text, mm = self.distance()
        which = ALL if self._rng.random() < SEVERAL else None
        action = self._choose([*self._shifts])
        step = Step(
            action, self._values(), (), object_which=which, reference_which=ITSELF, distance_mm=mm
        )
        return self._said(step, text), step

    def _said(self, step: Step, text: str) -> str:
        direction = self._choose(self._shifts[step.action])
        if self._rng.random() < 0.5:
            place = [self._choose(BEFORE).format(text), direction]
        else:
            place = [direction, self._choose(BEHIND).format(text)]
        if self._rng.random() < 0.1:
            place.append(self._choose(ORIGINS))
        moved, do = (self._speaker.words(name, step) for name in ("{moved}", "{do}"))
        words = self._choose(
            [
                [*self._speaker.words("{before}"), *do, *moved, *place],
                [*self._speaker.words("{before}"), "move", *moved, *place],
                ["i want you to", *do, *moved, *place, "please"],
                [*self._speaker.words("{taking}"), *moved, "and", *do, "it", *place],
            ]
        )
        return " ".join(" ".join(words).split())

    def near_miss(self) -> str:
        """A sentence with such words that must be refused."""
        step = self._side_step()
        moved, other = (self._speaker.words(name, step) for name in ("{moved}", "{reference}"))
        do, (text, _), (far, _) = self._speaker.words("{do}"), self.distance(), self.distance()
        one, two = self._rng.permutation([*self._shifts])[:2]
        direction, another = (self._choose(self._shifts[str(name)]) for name in (one, two))
        on = self._choose(self._domain.actions[0].phrases)
        words = self._choose(
            [
                [*do, *moved, direction],
                [*do, *moved, "a bit", direction],
                [*do, *moved, "a little", direction],
                [*do, *moved, text],
                [*do, *moved, text, "up"],
                [*do, *moved, text, "higher"],
                [*do, *moved, text, "forward"],
                [*do, *moved, text, on, direction],
                [*do, *moved, self._choose(NONE).format(text, far), direction],
                [*do, *moved, text, direction, "and", far, another],
                [*do, *moved, text, direction, "and", another],
                [*do, *moved, text, direction, "or", another],
                [*do, *moved, text, direction, another, *other],
                [*do, *moved, "or", *other, text, direction],
                [*do, *moved, text, direction, on, *other],
                [*do, *moved, text, direction, "of"],
                [*do, *moved, text, direction, "until it is", on, *other],
                [*do, text, direction],
                [*do, *moved, "not", text, direction],
                ["do not", *do, *moved, text, direction],
                ["is", *moved, text, direction],
                ["was", *moved, text, direction],
                ["if", *moved, "is", text, direction, *do, *other, on, *moved],
                ["how many cm is", *moved, direction],
                ["i have moved", *moved, text, direction],
                [*do, *moved, "that is", text, direction],
                ["turn", *moved, text, direction],
                [*do, "the table", text, direction],
            ]
        )
        return " ".join(" ".join([*self._speaker.words("{before}"), *words]).split())


def shifted_programs(domain: Domain, truth: Truth, rng: np.random.Generator) -> Iterator[Put]:
    """Each direction in which a block of an episode's initial scene that stands on the table, and
    carries none, is moved by one of `DISTANCES_MM`, where there is room for it, by a unique
    description."""
    blocks = tuple(block_from_attributes(domain, values) for values in truth.attributes)
    scene = Arrangement(blocks, truth.initial_poses, bases(truth))
    unique = unique_descriptions(domain, blocks, Descriptions(1, 2))
    for action in domain.actions:
        for moved, kinds in enumerate(unique):
            if action.direction is None or not kinds:
                continue
            mm = DISTANCES_MM[int(rng.integers(len(DISTANCES_MM)))]
            if moved in scene.base or scene.base[moved] is not None:
                continue
            x, y, z = scene.poses[moved].position
            dx, dy = action.direction
            goal = Pose.upright(x + dx * mm / 1000, y + dy * mm / 1000, z)
            if scene.has_room(moved, moved, goal):
                values = next(iter(kinds.values()))
                step = Step(action.name, values, (), reference_which=ITSELF, distance_mm=mm)
                yield Put(step, False, moved, moved, (goal.position,))

"""Says how far from its reference an object is put: "put the red block two centimetres to the left
of the blue one", "… 5 cm from it"; and near misses, which mean no such distance."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from nsrm_harness.data.compounds import Put, bases
from nsrm_harness.data.draws import Draws
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.moves import GAP_M, Arrangement, Move, target
from nsrm_harness.data.programs import Descriptions, unique_descriptions
from nsrm_harness.domain import Action, Domain
from nsrm_harness.domain.program import Program, Step
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import block_from_attributes

#: Share of sentences with a further step.
FOLLOWED = 0.3
#: Share of sentences without a side, if the domain has a compound for that.
SIDELESS = 0.2
#: Units with their millimetres, and from and to how many of each are said.
UNITS = (
    (("cm", "centimetres", "centimeters"), 10.0, (2, 12)),
    (("mm", "millimetres", "millimeters"), 1.0, (8, 95)),
    (("inches",), 25.4, (2, 4)),
)
#: Numbers that are said in words.
WORDS = (
    "one", "two", "three", "four", "five", "six", "seven", "eight", "nine", "ten", "eleven",
    "twelve",
)  # fmt: skip
#: Single distances.
SINGLE = (
    ("a centimetre", 10), ("one inch", 25), ("half a centimetre", 5), ("an inch", 25),
    ("one and a half centimetres", 15), ("2.5 cm", 25), ("4.5cm", 45), ("two and a half cm", 25),
)  # fmt: skip
#: Share of distances that are one of these.
SINGLES = 0.15
#: Distances in scenes.
DISTANCES_MM = (10, 20, 30, 40, 50, 80, 100)
#: How a distance stands before a side, and behind the reference.
BEFORE = ("{}", "{}", "about {}", "exactly {}", "{} away", "at a distance of {}", "just {}")
BEHIND = (
    "by {}", ", {} away", "{} away", "at a distance of {}", ", with a gap of {}",
    "with {} in between", ", leaving a gap of {}", ", {} apart", "with {} between them",
)  # fmt: skip
#: Between a distance and a reference without a side.
SOURCES = ("from", "away from")
#: Distances that are none.
NONE = (
    "at least {}", "at most {}", "more than {}", "less than {}", "up to {}", "within {}", "not {}",
    "0 cm or", "some centimetres", "{} or {}", "a few cm", "no more than {}", "the {}",
    "between {} and {}", "every {}", "minus {}", "2,{}", "1 {}", "{} square",
)  # fmt: skip


class DistanceSentences(Draws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.distances is None:
            raise ValueError("the domain's wording has no distances")
        super().__init__(domain, rng)
        self._sides = [action for action in domain.actions if action.direction is not None]
        made = domain.compounds.made if domain.compounds is not None else ()
        self._sideless = [compound.name for compound in made if compound.any]

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        said, step = self.said(self._side_step(), self.distance())
        program = [step]
        if self._rng.random() < FOLLOWED:
            if self._rng.random() < 0.5:
                words, further = self.said(self._side_step(), self.distance())
            else:
                further = self._step()
                words = self._put(further, self._place(further))
            said = f"{said} , {self._choose(('then', 'and then', 'and'))} {words}"
            program.append(further)
        return said, tuple(program)

    def said(self, step: Step, distance: tuple[str, int]) -> tuple[str, Step]:
        """A step at a distance, whose action puts its object beside another one, and what it then
        means; sometimes without the side."""
        text, mm = distance
        step = replace(step, distance_mm=mm)
        if self._sideless and self._rng.random() < SIDELESS:
            step = replace(step, action=self._choose(self._sideless))
            reference = self._speaker.words("{reference}", step)
            return self._put(step, [text, self._choose(SOURCES), *reference]), step
        return self._with_side(step, text), step

    def _with_side(self, step: Step, text: str) -> str:
        place = self._place(step)
        if self._rng.random() < 0.5:
            return self._put(step, [self._choose(BEFORE).format(text), *place])
        return self._put(step, [*place, self._choose(BEHIND).format(text)])

    def _place(self, step: Step) -> list[str]:
        side = self._choose(self._domain.action(step.action).phrases)
        return [side, *self._speaker.words("{reference}", step)]

    def _put(self, step: Step, place: list[str]) -> str:
        moved, do = (self._speaker.words(name, step) for name in ("{moved}", "{do}"))
        words = self._choose(
            [
                [*self._speaker.words("{before}"), *do, *moved, *place],
                [*self._speaker.words("{before}"), *do, *moved, *place],
                [*moved, self._choose(("goes", "should be", "belongs", "should go")), *place],
                ["i want", *moved, *place],
                ["move", *moved, "so that it's", *place],
            ]
        )
        return " ".join(" ".join(words).split())

    def of_side(self, step: Step) -> str:
        """A sentence of a step with a distance, whose side is named."""
        return self._with_side(step, f"{step.distance_mm} mm")

    def near_miss(self) -> str:
        """A sentence with such words that must be refused."""
        step = self._side_step()
        moved, reference = (self._speaker.words(name, step) for name in ("{moved}", "{reference}"))
        do, side = (
            self._speaker.words("{do}"),
            self._choose(self._domain.action(step.action).phrases),
        )
        (text, _), (other, _) = self.distance(), self.distance()
        none = self._choose(NONE).format(text, other)
        on = self._choose(self._domain.actions[0].phrases)
        size = self._values()
        words = self._choose(
            [
                [*do, *moved, none, side, *reference],
                [*do, *moved, side, *reference, none],
                [*do, *moved, text, on, *reference],
                [*do, *moved, on, *reference, "by", text],
                [*do, *moved, text, *reference],
                [*do, "the", text, *size, "block", side, *reference],
                [*do, "a", text, "block", side, *reference],
                [*do, *moved, side, "the", text, *size, "block"],
                [*do, *moved, side, "a", text, "block"],
                [*do, *moved, text, side],
                [*do, *moved, text],
                ["do not", *do, *moved, text, side, *reference],
                ["is", *moved, text, side, *reference],
                ["how many cm is", *moved, side, *reference],
                [*do, *moved, text, side, *reference, "by", other],
                [*do, *moved, text, side, "and", other, on, *reference],
                [*do, *moved, text, "high", side, *reference],
                [*do, *moved, "a bit", side, *reference],
                [*do, text, *moved, side, *reference],
                [*do, *moved, "for", text, side, *reference],
                [*do, *moved, side, *reference, "and", text],
                ["cut", text, "off", *moved, side, *reference],
                [*do, *moved, text, side, *reference, ", or on it"],
            ]
        )
        return " ".join(" ".join([*self._speaker.words("{before}"), *words]).split())

    def distance(self) -> tuple[str, int]:
        """A distance in words, and in millimetres."""
        if self._rng.random() < SINGLES:
            return self._choose(SINGLE)
        units, mm, (least, most) = self._choose(UNITS)
        number, unit = int(self._rng.integers(least, most + 1)), self._choose(units)
        rounded = int(number * mm + 0.5)
        if self._rng.random() < 0.4 and number <= len(WORDS):
            return f"{WORDS[number - 1]} {unit}", rounded
        glue = "" if unit in ("cm", "mm") and self._rng.random() < 0.3 else " "
        return f"{number}{glue}{unit}", rounded

    def _side_step(self) -> Step:
        return Step(self._choose(self._sides).name, self._values(), self._values())


def spaced_programs(domain: Domain, truth: Truth, rng: np.random.Generator) -> Iterator[Put]:
    """Each action that puts a block of an episode's initial scene beside another one, at one of
    `DISTANCES_MM`, where there is room for it, by the unique descriptions of both. Nothing can be
    measured from what carries another block."""
    blocks = tuple(block_from_attributes(domain, values) for values in truth.attributes)
    scene = Arrangement(blocks, truth.initial_poses, bases(truth))
    unique = unique_descriptions(domain, blocks, Descriptions(1, 2))
    named = [index for index, kinds in enumerate(unique) if kinds]
    for action in domain.actions:
        for moved in named:
            for reference in named:
                if action.direction is None or moved == reference:
                    continue
                mm = DISTANCES_MM[int(rng.integers(len(DISTANCES_MM)))]
                goal = _goal(scene, action, moved, reference, mm)
                if goal is not None:
                    one, other = (next(iter(unique[each].values())) for each in (moved, reference))
                    step = Step(action.name, one, other, distance_mm=mm)
                    yield Put(step, False, moved, reference, (goal.position,))


def _goal(scene: Arrangement, action: Action, moved: int, reference: int, mm: int) -> Pose | None:
    if {moved, reference} & {*scene.base} or scene.base[reference] is not None:
        return None
    if action.direction is None:
        return None
    usual = target(Move(action, moved, reference), scene.blocks, scene.poses)
    x, y, z = usual.position
    dx, dy = action.direction
    farther_m = mm / 1000 - GAP_M
    goal = Pose.upright(x + dx * farther_m, y + dy * farther_m, z)
    return goal if scene.has_room(moved, reference, goal) else None

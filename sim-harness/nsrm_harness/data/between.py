"""Says that something is put between two objects, or lies there: "put the green block between the
red and the blue one"; and near misses, which mean nothing that can be done."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nsrm_harness.data.compounds import Put, bases
from nsrm_harness.data.draws import Draws, Values
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.moves import Arrangement
from nsrm_harness.data.programs import Descriptions, unique_descriptions
from nsrm_harness.domain import Domain
from nsrm_harness.domain.compounds import Compound
from nsrm_harness.domain.program import AND, BOTH, Program, Relation, Step
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import block_from_attributes

#: Share of sentences with a further step.
FOLLOWED = 0.3
#: Share of sentences in which an object is described by two others, and of those in which the two
#: look alike.
DESCRIBING, ALIKE = 0.25, 0.15


class BetweenSentences(Draws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if (compound := between_of(domain)) is None:
            raise ValueError("nothing is put between two objects in the domain's wording")
        super().__init__(domain, rng)
        self._between = compound

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        moved, one, other, further = self._four()
        place = f"{self._choose(self._between.said)} {self._two(one, other)}"
        draw = self._rng.random()
        if draw < DESCRIBING:
            sentence, step = self._describing(moved, one, other, further, place)
        elif draw < DESCRIBING + ALIKE:
            both = self._choose(["the two", "both", "both of the"])
            alike = f"{self._choose(self._between.said)} {both} {' '.join(one)} blocks"
            step = Step(self._between.name, moved, one, reference_which=BOTH)
            sentence = self._doing(moved, alike)
        else:
            step = Step(self._between.name, moved, one, reference_relations=(Relation(AND, other),))
            sentence = self._doing(moved, place)
        program: Program = (step,)
        if self._rng.random() < FOLLOWED:
            second = self._step()
            lead = self._choose([", then", "and then", ". then", ". after that ,"])
            sentence = f"{sentence} {lead} {' '.join(self._speaker.words('{order}', second))}"
            program = (step, second)
        before = " ".join(self._speaker.words("{before}"))
        return " ".join(f"{before} {sentence}".split()), program

    def near_miss(self) -> str:
        """A sentence with such words that must be refused."""
        moved, one, other, further = (self._object(each) for each in self._four())
        said, do = (
            self._choose(self._between.said),
            " ".join(self._speaker.words("{do}")),
        )
        words = self._choose(
            [
                f"{do} {moved} {said} {one}",
                f"{do} {moved} {said}",
                f"{do} {said} {one} and {other}",
                f"{do} {moved} {said} {one} or {other}",
                f"{do} {moved} {said} {one} {other}",
                f"{do} {moved} {said} {one} and",
                f"{do} {moved} {said} {one} and the table",
                f"{do} {moved} {said} {one} and me",
                f"{do} {moved} {said} {one} , {other}",
                f"{do} {moved} {said} {one} and {other} and {further}",
                f"{do} {moved} {said} them",
                f"{do} {moved} not {said} {one} and {other}",
                f"do not {do} {moved} {said} {one} and {other}",
                f"is {moved} {said} {one} and {other}",
                f"{moved} was {said} {one} and {other}",
                f"choose {said} {one} and {other}",
                f"{do} {moved} {said} {one} and {other} on {further}",
                f"{do} {moved} or {further} {said} {one} and {other}",
                f"{do} all {moved.removeprefix('the ')} {said} {one} and {other}",
                f"{do} {moved} 2 cm {said} {one} and {other}",
                f"what is {said} {one} and {other}",
            ]
        )
        before = " ".join(self._speaker.words("{before}"))
        return " ".join(f"{before} {words}".split())

    def _doing(self, moved: Values, place: str) -> str:
        do = " ".join(self._speaker.words("{do}"))
        return self._choose(
            [
                f"{do} {self._object(moved)} {place}",
                f"{do} {self._object(moved)} {place}",
                f"{place} , {do} {self._object(moved)}",
                f"could you {do} {self._object(moved)} {place}",
                f"take {self._object(moved)} and {do} it {place}",
                f"{self._object(moved)} should go {place}",
            ]
        )

    def _describing(
        self, moved: Values, one: Values, other: Values, further: Values, place: str
    ) -> tuple[str, Step]:
        """An object that lies between two, as that which is moved or the reference."""
        relations = (Relation(self._between.name, one), Relation(AND, other))
        on, do = self._domain.actions[0], " ".join(self._speaker.words("{do}"))
        phrase = self._choose(on.phrases)
        # Without "that is", it may as well be where the object is put.
        lies = f"the {' '.join(moved)} block {self._choose(['that is', 'which is'])} {place}"
        if self._rng.random() < 0.5:
            said = f"{do} {lies} {phrase} {self._object(further)}"
            return said, Step(on.name, moved, further, relations)
        said = f"{do} {self._object(further)} {phrase} {lies}"
        return said, Step(on.name, further, moved, (), relations)

    def _two(self, one: Values, other: Values) -> str:
        if self._rng.random() < 0.3 and len(one) == len(other):
            return f"the {' '.join(one)} and {' '.join(other)} blocks"
        return f"{self._object(one)} and {self._object(other)}"

    def _object(self, values: Values) -> str:
        words = " ".join(values)
        return self._choose([f"the {words} block", f"the {words} one", f"the {words}"])

    def _four(self) -> tuple[Values, Values, Values, Values]:
        """Descriptions of four objects of which no two are the same."""
        found: list[Values] = []
        while len(found) < 4:
            values = self._values()
            if all({*values} != {*other} for other in found):
                found.append(values)
        first, second, third, fourth = found
        return first, second, third, fourth


def between_of(domain: Domain) -> Compound | None:
    """The action of the domain that puts something between two objects."""
    made = domain.compounds.made if domain.compounds is not None else ()
    return next((compound for compound in made if compound.between), None)


def between_programs(domain: Domain, truth: Truth) -> Iterator[Put]:
    """Each block of an episode's initial scene between each two others that stand on the table and
    carry none, where there is room for it, by the unique descriptions of all."""
    if (compound := between_of(domain)) is None:
        return
    blocks = tuple(block_from_attributes(domain, values) for values in truth.attributes)
    scene = Arrangement(blocks, truth.initial_poses, bases(truth))
    unique = unique_descriptions(domain, blocks, Descriptions(1, 2))
    named = {index: next(iter(kinds.values())) for index, kinds in enumerate(unique) if kinds}
    free = [index for index in named if index not in scene.base]
    ends = [index for index in free if scene.base[index] is None]
    for moved in free:
        for one in ends:
            for other in ends:
                if len({moved, one, other}) < 3:
                    continue
                places = (scene.poses[each].position for each in (one, other))
                x, y = (sum(axis) / 2 for axis in list(zip(*places, strict=True))[:2])
                goal = Pose.upright(x, y, float(truth.edges_m[moved, 2]) / 2)
                if all(scene.has_room(moved, end, goal) for end in (one, other)):
                    step = Step(
                        compound.name,
                        named[moved],
                        named[one],
                        reference_relations=(Relation(AND, named[other]),),
                    )
                    yield Put(step, False, moved, one, (goal.position,))

"""Says what compounds of actions mean: "put the red block next to the blue one", "move the one in
front and to the left of it"; and near misses, which mean nothing that can be done."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from nsrm_harness.data.draws import Draws, Values
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.moves import Arrangement, Move, target
from nsrm_harness.data.programs import Descriptions, unique_descriptions
from nsrm_harness.domain import Domain
from nsrm_harness.domain.compounds import Compound
from nsrm_harness.domain.program import Program, Relation, Step
from nsrm_harness.geometry.pose import Pose
from nsrm_harness.simulation.blocks import block_from_attributes

#: Share of sentences with a further step.
FOLLOWED = 0.3
#: Share of sentences in which a compound describes an object.
DESCRIBING = 0.3
#: What nothing can be put beside, or where.
NOTHING = (
    "the edge", "the corner", "the robot", "yourself", "me", "itself", "the left", "the right side",
    "it all", "nothing", "the table", "anything", "each other", "the camera",
)  # fmt: skip

#: Sides that contradict one another.
SIDES = ("its left and its right", "its left or right", "top", "both sides", "its other side")


class CompoundSentences(Draws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.compounds is None:
            raise ValueError("the domain's wording has no compounds")
        super().__init__(domain, rng)
        self._compounds = [each for each in domain.compounds.made if not each.between]

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        program = [self._describing() if self._rng.random() < DESCRIBING else self._doing()]
        if self._rng.random() < FOLLOWED:
            program.append(self._doing() if self._rng.random() < 0.5 else self._plain())
        return " ".join(self._speaker.sentence(tuple(program))), tuple(program)

    def near_miss(self) -> str:
        """A sentence of the same words that must be refused."""
        one, other, further = (self._described(values) for values in self._apart())
        do = self._speaker.words("{do}")
        said, also = (self._choose(self._compound().said) for _ in range(2))
        words = self._choose(
            [
                [*do, *one, said, *other, "or", *further],
                [*do, *one, "or", *other, said, *further],
                [*do, *one, "not", said, *other],
                ["do not", *do, *one, said, *other],
                ["why is", *one, said, *other],
                ["is", *one, said, *other],
                ["cut", *one, said, *other],
                [*do, *one, said],
                [*do, said, *other],
                [*do, *one, said, also, *other],
                [*do, *one, said, self._choose(NOTHING)],
                [*do, *one, said, *other, "and", *further],
                [*do, *one, "nor", *other, said, *further],
                [*do, *one, "at least two centimetres", said, *other],
                [*do, *one, "away from", said, *other],
                [*do, *one, said, *other, "upside down"],
                [*do, *one, said, *other, said],
                [*do, *one, *other, said],
                [*do, *one, said, *other, ", on", self._choose(SIDES)],
                [*do, *one, said, *other, "please first", *do, *further, "on", *one],
                [*do, *one, said, *other, ", unless", *further, "is on", *one],
                [*do, *one, "on", *further, "and", said, *other],
            ]
        )
        return " ".join(" ".join([*self._speaker.words("{before}"), *words]).split())

    def _doing(self) -> Step:
        """A step whose action is a compound."""
        return Step(self._compound().name, self._values(), self._values())

    def _describing(self) -> Step:
        """A step in which an object is described by one."""
        step, relation = self._plain(), Relation(self._compound().name, self._values())
        own = [((relation,), ()), ((), (relation,))][int(self._rng.integers(2))]
        return Step(step.action, step.object, step.reference, *own)

    def _plain(self) -> Step:
        action = self._choose([action.name for action in self._domain.actions])
        return Step(action, self._values(), self._values())

    def _compound(self) -> Compound:
        return self._choose(self._compounds)

    def _described(self, values: Values) -> list[str]:
        return self._speaker.words("{moved}", Step(self._domain.actions[0].name, values, ()))

    def _apart(self) -> list[Values]:
        """Values of three objects of which no two can be those of one."""
        attribute = self._domain.attributes[0]
        every = self._rng.permutation([value.name for value in attribute.values])
        return [(str(name),) for name in every[:3]]


@dataclass(frozen=True)
class Put:
    """A step that puts a block of an episode's initial scene beside another one: by a compound, or
    at a distance that is named."""

    step: Step
    #: Whether any of its places will do.
    is_any: bool
    #: Indices of the block that is moved and of its reference.
    moved: int
    reference: int
    #: Where the block's centre may end, if there is room, metres.
    goals: tuple[tuple[float, float, float], ...]


def compound_programs(domain: Domain, truth: Truth) -> Iterator[Put]:
    """Each compound of each pair of blocks of an episode's initial scene of which one can be moved
    so, by the unique descriptions of both."""
    blocks = tuple(block_from_attributes(domain, values) for values in truth.attributes)
    scene = Arrangement(blocks, truth.initial_poses, bases(truth))
    unique = unique_descriptions(domain, blocks, Descriptions(1, 2))
    named = [index for index, kinds in enumerate(unique) if kinds]
    made = domain.compounds.made if domain.compounds is not None else ()
    for compound in (each for each in made if not each.between):
        for moved in named:
            for reference in named:
                if goals := _goals(domain, scene, compound, moved, reference):
                    one, other = (next(iter(unique[each].values())) for each in (moved, reference))
                    step = Step(compound.name, one, other)
                    yield Put(step, bool(compound.any), moved, reference, goals)


def _goals(
    domain: Domain, scene: Arrangement, compound: Compound, moved: int, reference: int
) -> tuple[tuple[float, float, float], ...]:
    if moved == reference or moved in scene.base or scene.base[reference] is not None:
        return ()
    moves = [Move(domain.action(name), moved, reference) for name in compound.parts]
    ends = [target(move, scene.blocks, scene.poses).position for move in moves]
    if compound.any:
        return tuple(ends) if any(map(scene.allowed, moves)) else ()
    # As far along each axis as the action in its direction puts it.
    start = scene.poses[reference].position
    along = [max(ends, key=lambda end: abs(end[axis] - start[axis]))[axis] for axis in range(2)]
    goal = Pose.upright(along[0], along[1], ends[0][2])
    return (goal.position,) if scene.has_room(moved, reference, goal) else ()


def bases(truth: Truth) -> tuple[int | None, ...]:
    """Which block each one rests on; None for the table."""
    places = np.array([pose.position for pose in truth.initial_poses])
    heights = 0.5 * truth.edges_m[:, 2]
    bases: list[int | None] = []
    for index, place in enumerate(places):
        aside = np.linalg.norm(places[:, :2] - place[:2], axis=1)
        gaps = np.abs(place[2] - heights[index] - (places[:, 2] + heights))
        below = np.flatnonzero((aside < 0.03) & (gaps < 0.01) & (places[:, 2] < place[2]))
        bases.append(int(below[0]) if len(below) else None)
    return tuple(bases)

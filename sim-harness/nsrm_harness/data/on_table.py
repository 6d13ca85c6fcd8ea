"""Says what is put on the table, or stands on it: "put the red block on the table", "take it off
the blue one"; and near misses, which mean nothing that can be done."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nsrm_harness.data.draws import Draws, Values
from nsrm_harness.data.ground_truth import Truth
from nsrm_harness.data.programs import Descriptions, unique_descriptions
from nsrm_harness.domain import Domain
from nsrm_harness.domain.program import ALL, TABLE, Program, Relation, Step
from nsrm_harness.domain.rewriting import Table
from nsrm_harness.simulation.blocks import block_from_attributes

#: Share of sentences with a further step.
FOLLOWED = 0.3
#: How the place of the object of a step is said without naming the table.
DOWN = ("{do} {moved} down", "{do} down {moved}", "{taken} {joining} {do} it down")
#: What is said of the table that it is not: a place beside it, or a part of it.
OTHER_PLACES = (
    "under", "below", "behind", "beside", "next to", "near", "left of", "to the right of",
    "in front of", "on the edge of", "on the left side of", "in the middle of", "at the corner of",
    "across", "off",
)  # fmt: skip


class TableSentences(Draws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.table is None:
            raise ValueError("the domain's wording has no table")
        super().__init__(domain, rng)
        self._table: Table = domain.table

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        words, program = self._command()
        if self._rng.random() < FOLLOWED:
            further = self._step()
            lead = self._choose([", then", "and then", ". then", ". after that ,"])
            words = [*words, lead, *self._speaker.words("{order}", further)]
            program = (*program, further)
        return " ".join(" ".join(words).split()), program

    def _command(self) -> tuple[list[str], Program]:
        """The words of a first step about the table, and what they mean."""
        moved, reference, third = (self._values() for _ in range(3))
        on = self._table.action
        on_table = (Relation(on, (), TABLE),)
        on_reference = (Relation(on, reference),)
        put = Step(on, moved, (), reference_which=TABLE)
        taken = Step(on, moved, (), on_reference, reference_which=TABLE)
        before = self._speaker.words("{before}")
        kind = int(self._rng.integers(9))
        if kind == 0:
            return self._speaker.step(put, 0), (put,)
        if kind == 1:
            every = Step(on, moved, (), reference_which=TABLE, object_which=ALL)
            return self._speaker.step(every, 0), (every,)
        if kind == 2:
            step = self._step()
            relations = [(on_table, ()), ((), on_table)][int(self._rng.integers(2))]
            step = Step(step.action, step.object, step.reference, *relations)
            return self._speaker.step(step, 0), (step,)
        if kind == 3:
            said = self._speaker.words(self._choose(DOWN), put)
            return [*before, *said], (put,)
        if kind == 4:
            off = self._choose([text for text in self._table.off if " " not in text][:1])
            return [*before, *self._speaker.words(f"{{taking}} {{moved}} {off}", put)], (put,)
        if kind == 5:
            return [*before, *self._off(moved, reference)], (taken,)
        step = Step(self._step().action, moved, third, on_reference)
        if kind == 6:
            goes_on = self._speaker.words("and {do} it {relation}", step)
            off = self._off(moved, reference, sources=self._table.sources)
            return [*before, *off, *goes_on], (step,)
        if kind == 7 and self._table.removing:
            return [*before, *self._removed(moved, reference)], (taken,)
        # "Get the red block from the blue one to the left of …" is no command of the wording.
        source = self._choose(self._table.sources or self._table.off).split()
        moved_from = [*self._described(moved), *source, *self._described(reference)]
        where = self._speaker.words("{relation}", step)
        return [*before, *self._speaker.words("{do}"), *moved_from, *where], (step,)

    def near_miss(self) -> str:
        """A sentence of the same words that must be refused."""
        moved, reference, third = (self._values() for _ in range(3))
        one, other, further = (self._described(values) for values in (moved, reference, third))
        table = ["the", self._choose(self._table.words)]
        do = self._speaker.words("{do}")
        off = self._choose(self._table.off).split()
        words = self._choose(
            [
                [*do, *one, *self._choose(OTHER_PLACES).split(), *table],
                [*do, *table, "on", *one],
                [*do, *one, "on the", *reference[:1], *table[1:]],
                [*do, *one, "on", *table, "to the left of", *table],
                ["take", *one, *off, *table],
                ["take", *one, "or", *other, *off, *further],
                ["take", *one, *off, *other, "or", *further],
                ["do not take", *one, *off, *other],
                ["take", *one, "not", *off, *other],
                ["why is", *one, *off, *other],
                ["cut", *one, *off, *other],
                ["is", *one, "on", *table],
                ["do not", *do, *one, "down"],
                [*do, *one, "upside down"],
                ["bring", *one, "down to", *other],
                ["turn", *one, "off"],
                ["get", "off", *one],
                ["remove", *one],
                ["take", *one, "from", *other],
                ["remove", *one, "from", *other, "on", *further],
                ["remove", *one, "or", *other, "from", *further],
                ["do not remove", *one, "from", *other],
                ["was", *one, "removed from", *other],
                [*do, *one, "from", *other, "to", *further],
                [*do, *one, "far from", *other],
                [*do, *one, "not from", *other, "on", *further],
            ]
        )
        return " ".join(" ".join([*self._speaker.words("{before}"), *words]).split())

    def _off(self, moved: Values, reference: Values, sources: tuple[str, ...] = ()) -> list[str]:
        """What is taken off another block.

        * `sources`: what may also stand between the two
        """
        taking = self._choose(["take", "take", "take", "get", "lift", "pick up", "grab"])
        off = self._choose((*self._table.off, *sources * 4)).split()
        return [taking, *self._described(moved), *off, *self._described(reference)]

    def _removed(self, moved: Values, reference: Values) -> list[str]:
        """What is removed from another block."""
        between = self._choose((*self._table.off[:2], *self._table.sources * 4)).split()
        removing = self._choose(self._table.removing)
        return [removing, *self._described(moved), *between, *self._described(reference)]

    def _described(self, values: Values) -> list[str]:
        return self._speaker.words("{moved}", Step(self._table.action, values, ()))


def table_programs(domain: Domain, truth: Truth) -> Iterator[tuple[Step, int, bool]]:
    """For each block of an episode's initial scene that carries no other one: the step that puts it
    on the table, its id, and whether it stands on another block, so that this can be done."""
    if domain.table is None:
        return
    blocks = [block_from_attributes(domain, values) for values in truth.attributes]
    places = np.array([pose.position for pose in truth.initial_poses])
    for index, kinds in enumerate(unique_descriptions(domain, blocks, Descriptions(1, 2))):
        aside = np.linalg.norm(places[:, :2] - places[index, :2], axis=1)
        carries = bool(np.any((aside < 0.03) & (places[:, 2] > places[index, 2] + 0.02)))
        stands_high = bool(places[index, 2] > truth.edges_m[index, 2])
        if kinds and not carries:
            values = next(iter(kinds.values()))
            step = Step(domain.table.action, values, (), reference_which=TABLE)
            yield step, index + 1, stands_high

"""Says commands about several objects that are listed, "put the red and the blue block on the green
one"; and near misses, which list none."""

from __future__ import annotations

import numpy as np

from nsrm_harness.data.draws import JOINTS, PLURAL, ListDraws, Values
from nsrm_harness.domain import Domain
from nsrm_harness.domain.everyday import everyday_of, filled_in
from nsrm_harness.domain.program import Program, Step

#: Share of sentences with a further step behind the list.
FOLLOWED = 0.3
#: Share of those in which the objects are taken before.
TAKEN = 0.25
#: Most objects.
MOST_LISTED = 4


class ListedSentences(ListDraws):
    """Draws sentences of one domain. They are about no scene."""

    def __init__(self, domain: Domain, rng: np.random.Generator) -> None:
        if domain.lists is None or domain.simplification is None:
            raise ValueError("the domain's wording lists no objects")
        super().__init__(domain, rng)
        words = everyday_of(domain)
        self._said = domain.lists
        self._relations = {
            name: [
                filled
                for text in words.rules[relation["rule"]]
                if (filled := filled_in(text, relation)).endswith("{reference}")
                and "," not in filled
            ]
            for name, relation in words.placements().items()
        }

    def draw(self) -> tuple[str, Program]:
        """A sentence and the program that it means."""
        listed, step = self._objects_and_step()
        words = [*self._before(), *self._order(self._items(listed), step)]
        anchors = (step.reference, *listed)
        program: Program = tuple(
            Step(step.action, moved, anchor) for moved, anchor in zip(listed, anchors, strict=False)
        )
        if self._rng.random() < FOLLOWED:
            further = self._step()
            lead = self._choose([", then", "and then", ". then", ". after that ,"])
            words += [lead, *self._speaker.words("{order}", further)]
            program = (*program, further)
        return " ".join(" ".join(words).split()), program

    def near_miss(self) -> str:
        """A sentence of the same words that must be refused."""
        listed, step = self._objects_and_step()
        items, (first, second) = self._items(listed), (self._object(each) for each in listed[:2])
        relation = self._speaker.words(self._choose(self._relations[step.action]), step)
        colours = [value.name for value in self._domain.attributes[0].values]
        one, other = self._rng.choice(colours, 2, replace=False)
        words = self._choose(
            [
                f"put {items}",
                f"put {first} or {second} {{relation}}",
                # Perhaps the first one is taken back.
                f"put {first} , {second} {{relation}}",
                f"put {first} {second} {{relation}}",
                f"put {first} {{relation}} and {second}",
                f"put the {one} and {other} block {{relation}}",
                f"take {items} {{relation}}",
                f"take {items} and put it {{relation}}",
                f"do not put {items} {{relation}}",
                f"{items} {{relation}} is what i like",
                f"put neither {first} nor {second} {{relation}}",
                f"put one of {items} {{relation}}",
                f"put {items} {{relation}} if they are small",
                f"put both {first} , {second} and the {one} block {{relation}}",
                f"stack {items} to the left of the {other} block",
                f"take {items} and stack them behind the {other} block",
            ]
        )
        words = words.replace("{relation}", " ".join(relation))
        return " ".join([*self._before(), *words.split()])

    def _items(self, listed: tuple[Values, ...]) -> str:
        """The words of a list. Without "and", one may be taken back."""
        between, before_last = self._choose(JOINTS[:-1])
        items = [self._object(values) for values in listed]
        if self._rng.random() < PLURAL:
            *before, last = [" ".join(values) for values in listed]
            items = [f"the {before[0]}", *before[1:], f"{last} {self._choose(self._nouns[2:])}"]
        return f"{between.join(items[:-1])}{before_last}{items[-1]}"

    def _object(self, values: Values) -> str:
        words = " ".join(values)
        return self._choose([f"the {words} block", f"the {words} one", f"the {words}"])

    def _order(self, items: str, step: Step) -> list[str]:
        # "Stack them left of it" is a tower there.
        on = self._domain.actions[0].name
        verbs = [*self._domain.placing]
        if step.action != on:
            verbs = [each for each in verbs if each not in self._said.stacking]
        verb = self._choose(verbs)
        relation = self._speaker.words(self._choose(self._relations[step.action]), step)
        if self._rng.random() > TAKEN:
            return [verb, items, *relation]
        joining = self._choose(["and", "and then", ", then"])
        them = self._choose([*self._said.them, "both of them", "all of them", "them both", "both"])
        return ["take", items, joining, verb, them, *relation]

    def _objects_and_step(self) -> tuple[tuple[Values, ...], Step]:
        """Objects with as many values each, and what is done with the first one."""
        step = self._step()
        while True:
            objects = self._objects()[:MOST_LISTED]
            if len({len(values) for values in objects}) == 1:
                return objects, Step(step.action, objects[0], step.reference)

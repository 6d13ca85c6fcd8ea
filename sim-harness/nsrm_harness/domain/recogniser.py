"""Recognises the commands of everyday wording: every sentence that its rules can make."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise, takewhile

from nsrm_harness.domain.domain import GROUP_TOKEN, RELATING_RULES, Domain, EverydayWords
from nsrm_harness.domain.everyday import everyday_of, filled_in, own_texts, state_texts
from nsrm_harness.domain.reader import COUNTING, MAX_STEPS
from nsrm_harness.domain.rewriting import Simplification
from nsrm_harness.domain.tokens import split

_FIELD = re.compile(r"\{(#?[a-z_]+)\}")
#: How steps are joined, generously: what is recognised is not used as an example of nonsense.
_SENTENCE = {
    "#first": ("", "{starting}", "{#first_listed}"),
    "#later": ("{next}", "{#later_listed}", ". {#later_listed}", ", {#later_listed}"),
    "#told": tuple(
        f"{{before}} {please} {{command}} {{after}} {end}".strip()
        for please in ("", "{please}")
        for end in ("", ".", ",")
    ),
}


@dataclass(frozen=True)
class Recogniser:
    """Recognises the commands of a domain's everyday wording."""

    _tries: Mapping[str, _Node] = field(repr=False)
    #: What a sentence can do without.
    _simplification: Simplification | None = None
    _articles: Sequence[str] = ()
    _nouns: Sequence[str] = ()

    @classmethod
    def of(cls, domain: Domain, rules: Mapping[str, Sequence[str]] | None = None) -> Recogniser:
        """The recogniser of a domain with everyday wording.

        `rules`: replace those of the wording, or are added
        """
        every = {**recognised_rules(domain), **(rules or {})}
        tries = {name: _trie(texts) for name, texts in every.items()}
        articles = () if domain.ordinals is None else domain.ordinals.articles
        nouns = tuple(word for text in every["noun"] for word in text.split())
        return cls(tries, domain.simplification, articles, nouns)

    def command(self, words: Sequence[str]) -> bool:
        """Whether the words, with group tokens, are a step or a command, also without those that it
        can do without."""
        readings = [words]
        if self._simplification is not None:
            left = self._simplification.simplified(words, self._articles)
            readings.append(_with_values_before(left, self._nouns))
        return any(self.step(each) or self.program(each) for each in readings)

    def step(self, words: Sequence[str]) -> bool:
        """Whether the words, with group tokens, are one step of a command: the first or a later
        one."""
        memo: dict[tuple[str, int], frozenset[int]] = {}
        begun = self._through(("#first",), {0}, words, memo)
        begun |= self._through(("#later",), {0}, words, memo)
        return len(words) in self._through(("#told",), begun, words, memo)

    def program(self, words: Sequence[str]) -> bool:
        """Whether the words, with group tokens, are a command of one or more steps."""
        memo: dict[tuple[str, int], frozenset[int]] = {}
        reached = set(self._through(("#first", "#told"), {0}, words, memo))
        while True:
            if len(words) in reached:
                return True
            further = self._through(("#later", "#told"), reached, words, memo) - reached
            if not further:
                return False
            reached |= further

    def _through(
        self,
        rules: Sequence[str],
        places: set[int],
        words: Sequence[str],
        memo: dict[tuple[str, int], frozenset[int]],
    ) -> set[int]:
        for rule in rules:
            places = {end for place in places for end in self._ends(rule, place, words, memo)}
        return places

    def _ends(
        self,
        rule: str,
        start: int,
        words: Sequence[str],
        memo: dict[tuple[str, int], frozenset[int]],
    ) -> frozenset[int]:
        """Where the rule may end if it begins at word `start`."""
        found = memo.get((rule, start))
        if found is None:
            ends: set[int] = set()
            left = [(self._tries[rule], start)]
            while left:
                node, place = left.pop()
                if node.is_end:
                    ends.add(place)
                if place < len(words) and (behind := node.words.get(words[place])) is not None:
                    left.append((behind, place + 1))
                for name, behind in node.rules.items():
                    left += [(behind, end) for end in self._ends(name, place, words, memo)]
            found = memo[rule, start] = frozenset(ends)
        return found


def _with_values_before(words: Sequence[str], nouns: Collection[str]) -> list[str]:
    """The words with group tokens before their nouns: "the block [[X]]" is "the [[X]] block"."""
    told, left = list[str](), list(words)
    while left:
        first, *left = left
        is_noun = first in nouns and left[:1] == [GROUP_TOKEN] and {*left[1:2]}.isdisjoint(nouns)
        if is_noun:
            del left[0]
            # Values on both sides are one group.
            told += [] if told[-1:] == [GROUP_TOKEN] else [GROUP_TOKEN]
        told.append(first)
    return told


def with_values_joined(domain: Domain, sentence: str) -> list[str]:
    """The words of a sentence with group tokens, each for all values of one object, also where they
    stand apart: "put the big and blue block on the block that is red" has two."""
    types = {
        word: number
        for number, attribute in enumerate(domain.attributes)
        for value in attribute.values
        for word in value.words
    }
    nouns = {word for text in everyday_of(domain).rules["noun"] for word in text.split()}
    between, phrases = set[str](), set[str]()
    if domain.apart is not None:
        phrases = {*domain.apart.phrases}
        between = {"", *domain.apart.between} | phrases
    told, group, since = list[str](), set[int](), list[str]()
    for word in split(sentence):
        if word not in types:
            told.append(word)
            since.append(word)
            continue
        # "The big toy that is blue" is "the [[X]] toy".
        named = [*takewhile(nouns.__contains__, since)]
        joint = since[len(named) :]
        is_joint = " ".join(joint) in (phrases if named else between) or not since
        if group and is_joint and types[word] not in group:
            group.add(types[word])
            del told[len(told) - len(joint) :]
            since = named
        else:
            told.append(GROUP_TOKEN)
            group, since = {types[word]}, []
    return told


@dataclass
class _Node:
    """The alternatives of a rule with the same beginning."""

    words: dict[str, _Node] = field(default_factory=dict)
    rules: dict[str, _Node] = field(default_factory=dict)
    is_end: bool = False


def means_compound(domain: Domain, sentence: str) -> bool:
    """Whether a sentence may mean a compound: it has the words of one, and of any of some actions
    only if it names no side."""
    if domain.compounds is None:
        return False
    spaced, sides = f" {' '.join(split(sentence))} ", {*domain.compounds.sides}
    return any(
        not compound.any or not sides & {*spaced.replace(f" {text} ", " ", 1).split()}
        for compound in domain.compounds.made
        for text in compound.said
        if f" {text} " in spaced
    )


def means_list(domain: Domain, sentence: str) -> bool:
    """Whether a sentence may list objects that are moved: two descriptions with a word in between
    that joins them, behind a word that puts or takes something."""
    if domain.lists is None or domain.simplification is None or domain.ordinals is None:
        return False
    taking = domain.simplification.taking
    verbs = {*domain.placing, *(taking.words if taking is not None else ()), "up"}
    articles, values = "|".join(domain.ordinals.articles), {*domain.group_words(), GROUP_TOKEN}
    spaced = " ".join("{}" if word in values else word for word in split(sentence))
    nouns = "|".join(everyday_of(domain).rules["noun"])
    item = rf"(?:(?:{articles}) )?{{}}(?: {{}})*(?: (?:{nouns}))?"
    between = "|".join(domain.lists.between)
    listed = rf"{item}(?: , {item})*(?: ,)? (?:{between}) {item} "
    return any(re.search(rf"(?:^| ){verb} {listed}", f"{spaced} ") for verb in verbs)


def means_rewritten(domain: Domain, sentence: str) -> bool:
    """Whether a sentence of known words may mean what the core reads in other words: a compound,
    a list, what is taken from another object, steps in another order, or another phrase. Also
    without what it can do without."""
    meant = (means_compound, means_list, _means_source, _means_sequence, _means_rephrased)
    readings = [sentence]
    if domain.simplification is not None:
        articles = domain.ordinals.articles if domain.ordinals is not None else ()
        readings.append(" ".join(domain.simplification.simplified(split(sentence), articles)))
    return any(means(domain, reading) for reading in readings for means in meant)


def _means_rephrased(domain: Domain, sentence: str) -> bool:
    """Whether a sentence has a phrase that is read as another one."""
    spaced = f" {' '.join(split(sentence))} "
    phrases = domain.rephrasing.items()
    return any(f" {text} " in spaced for text, read_as in phrases if text != read_as)


def _means_sequence(domain: Domain, sentence: str) -> bool:
    """Whether a sentence has words that say in which order steps are carried out."""
    spaced = f" {' '.join(split(sentence))} "
    return domain.sequence is not None and any(
        f" {text} " in spaced for text in domain.sequence.said()
    )


def _means_source(domain: Domain, sentence: str) -> bool:
    """Whether something is taken from another object, and more is said of it: a description or its
    noun stands before "from", and two descriptions or a pronoun behind it."""
    if domain.table is None:
        return False
    words, described = split(sentence), {*domain.group_words(), *domain.pronouns, GROUP_TOKEN}
    for source in domain.table.sources:
        length = len(source.split())
        for at in range(1, len(words)):
            before = {*words[max(at - 3, 0) : at]}
            if {*domain.table.unless} & {*words[:at]}:
                break
            if words[at : at + length] == source.split() and described & before:
                behind = [word in described for word in words[at + length :]]
                groups = sum(now and not last for last, now in pairwise([False, *behind]))
                if groups > 1:
                    return True
    return False


def recognised_rules(domain: Domain) -> dict[str, Sequence[str]]:
    """The rules of commands, with group tokens for all values."""
    words = everyday_of(domain)
    described = ["{description}"]
    if words.states():
        described += [f"{{{rule}}}" for rule in RELATING_RULES]
        described += [text for rule in RELATING_RULES for text in own_texts(words, rule)]
    return {
        **words.rules,
        "relation": [
            filled_in(text, relation)
            for relation in words.placements().values()
            for text in words.rules[relation["rule"]]
        ],
        "relating": state_texts(words),
        "values": (GROUP_TOKEN,),
        "moved": described,
        "reference": described,
        **_SENTENCE,
        "#first_listed": [_counted(text, words, 0) for text in words.rules["listing"]],
        "#later_listed": [
            _counted(text, words, index)
            for text in words.rules["listing"]
            for index in range(1, MAX_STEPS)
        ],
    }


def _trie(texts: Sequence[str]) -> _Node:
    root = _Node()
    for text in texts:
        node = root
        for word in text.split():
            found = _FIELD.fullmatch(word)
            if found is None:
                node = node.words.setdefault(word, _Node())
            else:
                node = node.rules.setdefault(found.group(1), _Node())
        node.is_end = True
    return root


def _counted(text: str, words: EverydayWords, index: int) -> str:
    """An alternative with the words for the number of a step."""
    return filled_in(text, {name: words.rules[name][index] for name in COUNTING})

"""Words of a dictionary that are near those of a domain: they mean something else, and are never
taken for misspelt ones."""

from __future__ import annotations

import json

from spellchecker import SpellChecker

from nsrm_harness.common.json_text import json_text
from nsrm_harness.domain import Domain, from_json
from nsrm_harness.domain.spelling import LEAST_LETTERS, one_edit


def with_dictionary(domain: Domain) -> Domain:
    """The domain with the words of its language's dictionary that are near its own, if it has a
    language."""
    spelling = domain.spelling
    if spelling is None or spelling.language is None:
        return domain
    dictionary = SpellChecker(language=spelling.language).word_frequency
    known = domain.known_words()
    words = (word for word in known if word.isalpha() and len(word) >= LEAST_LETTERS)
    near = {edited for word in words for edited in one_edit(word) if edited in dictionary}
    document = json.loads(domain.as_json())
    other_words = {*spelling.other_words, *near} - known - spelling.heard.keys()
    document["spelling"]["other_words"] = sorted(other_words)
    return from_json(json_text(document, ensure_ascii=False), domain.name)

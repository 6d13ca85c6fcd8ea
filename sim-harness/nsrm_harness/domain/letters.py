"""White space and case, letter by letter: the same for the trainer and the core.

Each letter is read in its own lower case (`char::to_lowercase`), whatever stands beside it: Σ is
σ at the end of a word too, and I is i in every language. So what is written otherwise is another
word: "WEISS" is not "weiß", "KIRMIZI" not "kırmızı", "ΛΕΥΚΌΣ" not "λευκός". Accents that are
written apart stay apart.
"""

from __future__ import annotations

SPACE = r"[^\S\x1c-\x1f]"
"""A pattern for Unicode's white space, to which Python adds four control characters."""


def lower_case(text: str) -> str:
    """As sentences are read."""
    return "".join(map(str.lower, text))


def upper_case(text: str) -> str:
    """The same number of letters, that read back as `text`; one whose upper case does not (ß, ς,
    ı) stays as it is."""
    return "".join(
        upper if lower_case(upper := letter.upper()) == letter else letter for letter in text
    )

"""White space and case, letter by letter, for the trainer as in the core.

Each letter is converted to its own lower case (`char::to_lowercase`), whatever its neighbours: Σ is
σ at the end of a word, too, and I is i in every language. So other spellings are other words:
"WEISS" is not "weiß", "KIRMIZI" not "kırmızı", "ΛΕΥΚΌΣ" not "λευκός". Combining accents stay
separate.
"""

from __future__ import annotations

SPACE = r"[^\S\x1c-\x1f]"
"""A pattern for Unicode's white space, without the four control characters that Python adds."""


def lower_case(text: str) -> str:
    """The lower case in which sentences are read."""
    return "".join(map(str.lower, text))


def upper_case(text: str) -> str:
    """The upper case, with the same number of letters, which reads back as `text`. A letter whose
    upper case does not (ß, ς, ı) stays as it is."""
    return "".join(
        upper if lower_case(upper := letter.upper()) == letter else letter for letter in text
    )

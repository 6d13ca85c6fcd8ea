"""The words and templates that near misses are made from; `{rules}` are those of the everyday
wording."""

from __future__ import annotations

#: Rules of the parts of a command that stand in for each other.
PARTS = (
    "asking",
    "wishing",
    "minding",
    "letting",
    "shall",
    "goes",
    "done",
    "doing",
    "do",
    "be",
    "is",
    "ensuring",
    "taking",
)
#: Sentences with a relation in a description, and with pronouns, that no program has; `{words}`
#: stands for the words of a relation without its reference, `{part}` for some of them.
REFERRING_TEXTS = (
    "{do} {article} {noun} {that_is} {relation} {relation}",
    "{do} {article} {noun} {relation} {relation}",
    "{do} {moved} {that_is} {relation}",
    "{do} {moved} {words} {article} {noun} {that_is} {relation}",
    "{do} {moved} {words} {article} {noun} {relation}",
    "{taken} {relation}",
    "{taken} {that_is} {relation}",
    "{taking} {article} {noun} {that_is} {relation} {joining} {do} it {relation}",
    "{taking} {article} {noun} {relation} {joining} {do} it {relation}",
    "{taken} {joining} {do} it {words} {article} {noun} {relation}",
    "{taken} {joining} {do} {reference} {words} it",
    "{taken} {joining} {words} it {do} {reference}",
    "{taken} {joining} {taking} {reference}",
    "{taken} and {reference} {joining} {do} it {words}",
    "{taken} {joining} {do} it {joining} {reference}",
    "{taking} it {joining} {do} {moved} {relation}",
    "{do} it {relation} {joining} {do} {moved}",
    "{do} {moved} {relation} {joining} {do} it {words}",
    "{do} {moved} {relation} {joining} {do} it {words} it",
    "{do} {moved} {relation} {joining} {taking} it",
    "{ensuring} it {is} {relation} {joining} {do} {moved}",
    "{moved} {is} {relation}",
    "{moved} {that_is} {relation}",
    "{do} {moved} {relation} {part}",
    "{do} {moved} {part} {relation}",
    "{moved} {relation} {part}",
    "{taken} {joining} {do} it {relation} {part}",
)
#: Sentences that join descriptions or relations as no program does.
JOINED_TEXTS = (
    "{do} {moved} and {reference} {relation}",
    "{do} {moved} , {reference} {relation}",
    "{do} {moved} or {reference} {relation}",
    "{do} both {moved} and {reference} {relation}",
    "{do} {moved} {relation} and {moved}",
    "{do} {moved} {relation} , {moved}",
    "{do} {moved} {relation} or {relation}",
    "{do} {moved} {relation} and {relation}",
    "{do} {moved} {relation} , and {relation}",
    "{do} {moved} {relation} {joining} {relation}",
    "{do} {moved} {relation} , {relation}",
    "{do} {moved} {words} and {reference} {relation}",
    "{do} {moved} {words} and {reference} {words} {moved}",
    "{do} {moved} {relation} {moved}",
    "{do} {moved} {reference} {relation}",
    "{do} {moved} {relation} {do} {moved}",
    "{do} {moved} {joining} {do} {moved} {relation}",
    "{do} {moved} {relation} {joining} {do} {moved}",
    "{do} {moved} first , then {moved} {relation}",
    "{do} {moved} then {moved} {relation}",
    "{taken} and {reference} {joining} {do} it {relation}",
    "{taken} {relation} {joining} {do} {reference}",
    "{taken} {joining} {do} it {relation} and {relation}",
    "{taken} {joining} {do} {moved} {relation}",
    "{taken} {joining} {taken} {joining} {do} it {relation}",
    "{moved} and {moved} {where}",
    "{moved} {where} and {moved}",
    "{moved} {goes} {where} or {where}",
    "{where} {do} {moved} and {moved}",
    "{where} , {where} , {do} {moved}",
    "{where} and {where} {do} {moved}",
    "{do} {moved} {where} {where}",
    "{do} {moved} {where} {that_is} {moved}",
    "{do} {moved} {that_is} {moved} {where}",
    "{do} {moved} of {moved} {where}",
    "{do} {moved} {words} {relation}",
    "{moved} {is} {relation} {relation}",
    "{taken} from {moved} {joining} {do} it {where}",
    "{do} {moved} from {moved} {where}",
    "{do} {moved} from {moved} to {moved}",
    "{do} {moved} with {moved} {where}",
    "{asking} {do} {moved} {where} {is} {relation}",
)
#: Rules whose words are inserted.
INSERTED = (*PARTS, "degree", "towards", "please", "opening", "address", "noun", "article", "next")
#: Words that join two relations.
JOINTS = ("and", ",", "", ", and")
#: Who might be said to do something, and how: "I have put …", "we should …".
SUBJECTS = ("i", "we", "you", "it")
AUXILIARIES = (
    "is",
    "are",
    "has",
    "have",
    "will",
    "can",
    "could",
    "would",
    "should",
    "do",
    "am",
    "want",
    "may",
)

"""The domain (concepts, actions and their words; Table I), sentences, programs and tokens."""

from nsrm_harness.domain.domain import GROUP_TOKEN, Action, Domain, Value
from nsrm_harness.domain.reader import DEFAULT, FOUR_SIDES, from_json, load, parse

__all__ = [
    "DEFAULT",
    "FOUR_SIDES",
    "GROUP_TOKEN",
    "Action",
    "Domain",
    "Value",
    "from_json",
    "load",
    "parse",
]

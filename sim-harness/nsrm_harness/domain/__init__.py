"""The domain: what may be named, what may be done, and in which words (Table I); sentences,
their programs and their tokens."""

from nsrm_harness.domain.domain import GROUP_TOKEN, Action, Domain, Value
from nsrm_harness.domain.reader import DEFAULT, from_json, load, parse

__all__ = ["DEFAULT", "GROUP_TOKEN", "Action", "Domain", "Value", "from_json", "load", "parse"]

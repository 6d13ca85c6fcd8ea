"""Blocks: shapes and colours from a domain's attribute values."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from nsrm_harness.geometry.mesh import Mesh, studded_box
from nsrm_harness.geometry.pose import Vector3

if TYPE_CHECKING:
    from nsrm_harness.domain import Domain

STUD_HEIGHT_M = 0.004
"""Height of the studs, the topmost part of a block's height."""

DEFAULT_EDGES_M: Vector3 = (0.04, 0.04, 0.04)
DEFAULT_RGB: Vector3 = (0.6, 0.6, 0.6)


@dataclass(frozen=True)
class Block:
    """A block, without a pose.

    * `attributes`: value of each attribute type, in the domain's order
    * `edges_m`: length along x, y, z, studs included
    * `rgb`: colour, each in 0..1
    * `studs`: rows along x and columns along y on the top face, or none
    """

    attributes: tuple[tuple[str, str], ...]
    edges_m: Vector3
    rgb: Vector3
    studs: tuple[int, int] | None = None

    @property
    def values(self) -> dict[str, str]:
        """Values by attribute type."""
        return dict(self.attributes)


def block_from_attributes(domain: Domain, attributes: Mapping[str, str]) -> Block:
    """The block with these values; properties of later attribute types win.

    Raises `KeyError` for an attribute type that is missing or unknown, and for a
    value that the domain does not have.
    """
    known = {attribute.name for attribute in domain.attributes}
    if unknown := sorted(set(attributes) - known):
        raise KeyError(f"the domain {domain.name!r} has no attribute {unknown[0]!r}")
    edges_m, rgb, studs = DEFAULT_EDGES_M, DEFAULT_RGB, None
    chosen: list[tuple[str, str]] = []
    for attribute in domain.attributes:
        if attribute.name not in attributes:
            raise KeyError(f"a block needs a value of the attribute {attribute.name!r}")
        name = attributes[attribute.name]
        value = next((value for value in attribute.values if value.name == name), None)
        if value is None:
            raise KeyError(f"the attribute {attribute.name!r} has no value {name!r}")
        edges_m = edges_m if value.edges_m is None else value.edges_m
        rgb = rgb if value.rgb is None else value.rgb
        studs = studs if value.studs is None else value.studs
        chosen.append((attribute.name, name))
    return Block(tuple(chosen), edges_m, rgb, studs)


@lru_cache(maxsize=256)
def block_mesh(block: Block) -> Mesh:
    """The block's surface about its centre, flat normals, studs on top."""
    return studded_box(block.edges_m, block.studs, STUD_HEIGHT_M, block.rgb)

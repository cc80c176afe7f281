# SPDX-License-Identifier: GPL-3.0-or-later
"""What is cheap to know of what is selected. Tasks say which of it they suit."""

from enum import Enum


class Trait(Enum):
    """Something about what is selected. What says most about what the artist is up to comes first."""

    TWIN = "with another mesh that has the same faces"
    CACHED = "played from a cache"
    MOVED = "moved before Sinew, by modifiers, shape keys or a parent"
    BONES = "with an armature"
    LOOSE = "of many parts"
    SHEET = "open, like a sheet"
    POINTS = "text, a curve, hair or a cloud: without a surface"
    SURFACE = "a mesh"


_ORDER = tuple(Trait)
PLAIN = frozenset({Trait.POINTS, Trait.SURFACE})  # which say nothing special


def first(wanted: tuple[Trait, ...], there: frozenset[Trait]) -> tuple[int, int] | None:
    """How well what is there suits what is wanted: the smaller, the better; None if it does not."""
    found = [(_ORDER.index(trait), place) for place, trait in enumerate(wanted) if trait in there]
    return min(found, default=None)

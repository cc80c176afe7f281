# SPDX-License-Identifier: GPL-3.0-or-later
"""What is cheap to know of what is selected. Tasks say which of it they need, and which they suit."""

from enum import Enum


class Trait(Enum):
    """Something about the selected object, and what a task that needs it says where it is not so.

    Those that say most about what the artist is up to come first.
    """

    TWIN = "Needs another mesh with the same faces - select it, too"
    CACHED = "Needs a cache before Sinew"
    MOVED = "Needs bones, shape keys or a cache that move the mesh before Sinew"
    BONES = "Needs an armature - select it together with the mesh"
    LOOSE = "Needs a mesh of many parts"
    SHEET = "Needs an open surface"
    POINTS = "Needs text, a curve, hair or a cloud"
    SURFACE = "Needs the surface of a mesh"


TRAITS = tuple(Trait)
PLAIN = frozenset({Trait.POINTS, Trait.SURFACE})  # which say nothing special


def first(wanted: tuple[Trait, ...], there: frozenset[Trait]) -> tuple[int, int] | None:
    """How well what is there suits what is wanted: the smaller, the better; None if it does not."""
    found = [(TRAITS.index(trait), place) for place, trait in enumerate(wanted) if trait in there]
    return min(found, default=None)

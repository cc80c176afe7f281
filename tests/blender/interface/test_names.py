# SPDX-License-Identifier: GPL-3.0-or-later
"""What files and scripts of artists name keeps its name: operators with arguments, and stored properties."""

from collections.abc import Iterator
from pathlib import Path

import bpy

NAMES = Path(__file__).parents[2] / "names" / "blender.txt"


def stored(group: bpy.types.Struct, path: str) -> Iterator[str]:
    """The properties below one, by path."""
    for prop in group.properties:
        if prop.identifier not in ("rna_type", "name"):
            yield f"{path}.{prop.identifier}"
            kind = prop.fixed_type if prop.type in ("POINTER", "COLLECTION") else None
            if kind and kind.base and kind.base.identifier == "PropertyGroup":
                yield from stored(kind, f"{path}.{prop.identifier}")


def operators() -> Iterator[str]:
    for name in dir(bpy.ops.sinew):
        kind = getattr(bpy.ops.sinew, name).get_rna_type()
        arguments = sorted(prop.identifier for prop in kind.properties if prop.identifier != "rna_type")
        yield f"sinew.{name}({', '.join(arguments)})"


def test_operators_and_properties_keep_their_names():
    owners = (bpy.types.Object, bpy.types.Scene, bpy.types.PoseBone)
    now = [
        line
        for owner in owners
        for line in stored(owner.bl_rna.properties["sinew"].fixed_type, f"{owner.__name__}.sinew")
    ]
    assert sorted([*operators(), *now]) == NAMES.read_text(encoding="utf-8").splitlines()

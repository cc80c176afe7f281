# SPDX-License-Identifier: GPL-3.0-or-later
"""Paths in properties."""

from bpy.types import Property


def beside_the_file() -> set[str]:
    """The options of a path that may begin with ``//``, of which Blender 4.5 and later warns otherwise."""
    is_known = "is_path_supports_blend_relative" in Property.bl_rna.properties
    return {"PATH_SUPPORTS_BLEND_RELATIVE"} if is_known else set()

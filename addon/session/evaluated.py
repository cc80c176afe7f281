# SPDX-License-Identifier: GPL-3.0-or-later
"""The mesh that an object shows, also in Edit Mode, and where a Subdivision lives on the graphics card."""

from collections.abc import Iterator
from contextlib import contextmanager

from bpy.types import Depsgraph, Mesh, Object


@contextmanager
def evaluated_mesh(obj: Object, depsgraph: Depsgraph) -> Iterator[Mesh | None]:
    """After all modifiers, in object space; None where Blender gives none. Gone afterwards."""
    evaluated = obj.evaluated_get(depsgraph)
    try:
        yield evaluated.to_mesh()
    finally:
        evaluated.to_mesh_clear()

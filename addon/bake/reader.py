# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads the positions after a deformer, at its place in the modifier stack.

If no visible modifier follows, these are the positions that the object shows. Otherwise a copy of the object
without the later modifiers is evaluated during the bake. It shows the same shape mesh, and the modifiers of
the object itself stay as they are.
"""

from dataclasses import dataclass

import bpy
import numpy as np
from bpy.types import Depsgraph, Mesh, Modifier, Object

from ..compat import read_positions
from ..core.errors import SinewError
from ..mesh_io import read_incoming
from ..properties import SinewDeformer
from ..session.datablocks import owners
from ..session.state import sessions
from ..session.targets import modified


@dataclass
class ShapeReader:
    """Where to read a deformer. It keeps names only, no Blender data.

    ``object`` is the owner of the deformer with the key ``uid``, ``copy_name`` the copy to read, if any.
    """

    object: str
    uid: str
    copy_name: str = ""

    def owner(self) -> Object:
        """The object of the deformer."""
        obj = bpy.data.objects.get((self.object, None))
        if obj is None or not any(deformer.uid == self.uid for deformer in obj.sinew.deformers):
            raise SinewError(f"{self.object} was removed or renamed during the bake - bake again")
        return obj

    def deformer(self) -> SinewDeformer:
        """The deformer's settings."""
        return next(deformer for deformer in self.owner().sinew.deformers if deformer.uid == self.uid)

    def modifier(self) -> Modifier:
        """The modifier that shows the deformer."""
        found = modified.shown_by(self.owner(), self.deformer())
        if found is None:
            raise SinewError(
                f"The modifier of {self.deformer().name} was removed - press Rebind, then bake again"
            )
        return found

    def earlier(self) -> list[Modifier]:
        """Modifiers that act before the deformer."""
        modifiers = list(self.owner().modifiers)
        return [other for other in modifiers[: modifiers.index(self.modifier())] if _is_shown(other)]

    def open(self) -> None:
        """Make the copy, if it is needed."""
        obj = self.owner()
        position = list(obj.modifiers).index(self.modifier())
        if not any(other.show_viewport for other in list(obj.modifiers)[position + 1 :]):
            return
        with sessions.suspended():
            copy = obj.copy()
            self.copy_name = copy.name
            copy.sinew.deformers.clear()
            for modifier in list(copy.modifiers)[position + 1 :]:
                copy.modifiers.remove(modifier)
            _remove_our_drivers(copy)
            copy.hide_render = True
            bpy.context.scene.collection.objects.link(copy)
        owners.forget_owners()

    def close(self) -> None:
        """Remove the copy."""
        copy = bpy.data.objects.get((self.copy_name, None)) if self.copy_name else None
        self.copy_name = ""
        if copy is not None:
            with sessions.suspended():
                bpy.data.objects.remove(copy)
            owners.forget_owners()

    def positions(self, depsgraph: Depsgraph) -> np.ndarray:
        """The positions after the deformer, float32 (n, 3), in object space."""
        return read_positions(self._evaluated(depsgraph))

    def incoming(self, depsgraph: Depsgraph) -> np.ndarray:
        """The positions before the deformer, float32 (n, 3)."""
        mesh = self._evaluated(depsgraph)
        found = read_incoming(mesh, *modified.attribute_names(self.uid), len(mesh.vertices))
        if found.points is None:
            raise SinewError(
                f"The shape before {self.deformer().name} is not known - press Rebind, then bake again"
            )
        return found.points

    def _evaluated(self, depsgraph: Depsgraph) -> Mesh:
        obj = bpy.data.objects[self.copy_name, None] if self.copy_name else self.owner()
        return obj.evaluated_get(depsgraph).data


def _remove_our_drivers(copy: Object) -> None:
    """Remove drivers of deformers, which the copy does not have, since Blender would print warnings."""
    for curve in list(copy.animation_data.drivers) if copy.animation_data else ():
        if curve.data_path.startswith("sinew."):
            copy.animation_data.drivers.remove(curve)


def _is_shown(modifier: Modifier) -> bool:
    return modifier.show_viewport or modifier.show_render


def changes_count(obj: Object, deformer: SinewDeformer) -> bool:
    """Whether modifiers before the deformer change the number of vertices."""
    return deformer.rest is not None and len(deformer.rest.vertices) != len(obj.data.vertices)


def labels(modifiers: list[Modifier]) -> str:
    """The names of modifiers, for a message."""
    return ", ".join(modifier.name for modifier in modifiers)

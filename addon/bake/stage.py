# SPDX-License-Identifier: GPL-3.0-or-later
"""The positions that leave a deformer, read at its place in the stack.

Where no shown modifier follows, that is what the object shows. Otherwise a copy without the later modifiers,
which shows the same shape mesh, is evaluated beside the object while the bake lasts; the user's stack is not
touched.
"""

from dataclasses import dataclass

import bpy
import numpy as np
from bpy.types import Depsgraph, Mesh, Modifier, Object

from .. import session
from ..compat import read_positions
from ..core.errors import SinewError
from ..mesh_io import read_incoming
from ..properties import SinewDeformer


@dataclass
class Stage:
    """Names only, no Blender data: ``object`` owns the deformer ``uid``, ``stand_in`` is the copy to read."""

    object: str
    uid: str
    stand_in: str = ""

    def owner(self) -> Object:
        """The object of the deformer."""
        obj = bpy.data.objects.get((self.object, None))
        if obj is None or not any(deformer.uid == self.uid for deformer in obj.sinew.deformers):
            raise SinewError(f"{self.object} is gone - bake again")
        return obj

    def deformer(self) -> SinewDeformer:
        """The deformer's settings."""
        return next(deformer for deformer in self.owner().sinew.deformers if deformer.uid == self.uid)

    def modifier(self) -> Modifier:
        """The modifier that shows the deformer."""
        found = session.find_modifier(self.owner(), self.deformer())
        if found is None:
            raise SinewError(f"{self.deformer().name} has no modifier any more - press Bind, then bake again")
        return found

    def earlier(self) -> list[Modifier]:
        """Modifiers that act before the deformer."""
        modifiers = list(self.owner().modifiers)
        return [other for other in modifiers[: modifiers.index(self.modifier())] if _acts(other)]

    def open(self) -> None:
        """Make the copy, where one is needed."""
        obj = self.owner()
        position = list(obj.modifiers).index(self.modifier())
        if not any(other.show_viewport for other in list(obj.modifiers)[position + 1 :]):
            return
        with session.suspended():
            copy = obj.copy()
            self.stand_in = copy.name
            copy.sinew.deformers.clear()
            for modifier in list(copy.modifiers)[position + 1 :]:
                copy.modifiers.remove(modifier)
            _without_our_drivers(copy)
            copy.hide_render = True
            bpy.context.scene.collection.objects.link(copy)
        session.forget_owners()

    def close(self) -> None:
        """Remove the copy."""
        copy = bpy.data.objects.get((self.stand_in, None)) if self.stand_in else None
        self.stand_in = ""
        if copy is not None:
            with session.suspended():
                bpy.data.objects.remove(copy)
            session.forget_owners()

    def positions(self, depsgraph: Depsgraph) -> np.ndarray:
        """What leaves the deformer now, float32 (n, 3), object space."""
        return read_positions(self._evaluated(depsgraph))

    def incoming(self, depsgraph: Depsgraph) -> np.ndarray:
        """What enters the deformer now, float32 (n, 3)."""
        mesh = self._evaluated(depsgraph)
        found = read_incoming(mesh, *session.attribute_names(self.uid), len(mesh.vertices))
        if found.points is None:
            raise SinewError("What enters the deformer is not known - press Bind, then bake again")
        return found.points

    def _evaluated(self, depsgraph: Depsgraph) -> Mesh:
        obj = bpy.data.objects[self.stand_in, None] if self.stand_in else self.owner()
        return obj.evaluated_get(depsgraph).data


def _without_our_drivers(copy: Object) -> None:
    """What drives a deformer's settings finds none on a copy, and Blender would complain."""
    for curve in list(copy.animation_data.drivers) if copy.animation_data else ():
        if curve.data_path.startswith("sinew."):
            copy.animation_data.drivers.remove(curve)


def _acts(modifier: Modifier) -> bool:
    return modifier.show_viewport or modifier.show_render


def changes_count(obj: Object, deformer: SinewDeformer) -> bool:
    """The deformer does not work on the vertices of the mesh itself: modifiers before it made others."""
    return deformer.rest is not None and len(deformer.rest.vertices) != len(obj.data.vertices)


def labels(modifiers: list[Modifier]) -> str:
    """Names for a message."""
    return ", ".join(modifier.name for modifier in modifiers)

# SPDX-License-Identifier: GPL-3.0-or-later
"""What an evaluation changed, so that nothing of ours runs when nothing of ours changed.

Blender lists what it updated, but not objects that are hidden or in no scene (3.4.1). So the controls are
compared by their matrices, and only the target is looked up in the list.
"""

from bpy.types import Depsgraph, Object

from . import poses, state


class News:
    """The updates of one evaluation. A render evaluates everything anew, so there everything is news."""

    def __init__(self, depsgraph: Depsgraph) -> None:
        self._depsgraph = depsgraph
        self._geometry: dict[object, bool] | None = None

    @property
    def _updates(self) -> dict[object, bool]:
        """Updated datablocks, and whether their geometry changed."""
        if self._geometry is None:
            self._geometry = {
                update.id.original: update.is_updated_geometry for update in self._depsgraph.updates
            }
        return self._geometry

    def leaves_alone(self, obj: Object, evaluated: Object) -> bool:
        """Neither the target nor one of its controls changed since ``note``."""
        seen = state.seen(obj.name_full) if self._depsgraph.mode == "VIEWPORT" else None
        return seen is not None and not self._touches(obj) and seen == self._controls(obj, evaluated)

    def has_new_geometry(self, obj: Object) -> bool:
        """What enters the modifiers of the target may have changed."""
        if self._depsgraph.mode == "RENDER" or not self._lists(obj):
            return True
        return self._updates.get(obj, False) or self._updates.get(obj.data, False)

    def has_edited_mesh(self, obj: Object) -> bool:
        """The mesh itself, or its stack of modifiers, was edited."""
        return self._updates.get(obj.data, False)

    def note(self, obj: Object, evaluated: Object) -> None:
        """The target is up to date with this evaluation."""
        if self._depsgraph.mode == "VIEWPORT":
            state.see(obj.name_full, self._controls(obj, evaluated))

    def _touches(self, obj: Object) -> bool:
        return not self._lists(obj) or obj in self._updates or obj.data in self._updates

    def _lists(self, obj: Object) -> bool:
        """Blender lists this object among the updates, if there are any."""
        return obj.visible_get(view_layer=self._depsgraph.view_layer)

    def _controls(self, obj: Object, evaluated: Object) -> tuple:
        """Where the target and its controls are."""
        placed = [poses.fingerprint(evaluated.matrix_world)]
        for deformer in obj.sinew.deformers:
            for handle in deformer.handles:
                if handle.kind == "HANDLE":
                    placed.append(poses.placement(handle, self._depsgraph))
        return tuple(placed)

# SPDX-License-Identifier: GPL-3.0-or-later
"""What changed since the last evaluation. If neither a target nor its controls changed, Sinew does nothing.

Blender lists what it updated, but not objects that are hidden or in no scene, nor those of which drivers
changed a property (3.4.1). So the controls are compared by their matrices and driven settings by their
values, and only the target is looked up in the list.
"""

from collections.abc import Iterator
from enum import IntEnum

from bpy.types import ID, Depsgraph, DepsgraphUpdate, Object, Scene

from ..controls import kinds, placement
from ..datablocks import references
from ..state import sessions
from ..state.evaluation import ControlState
from ..state.sessions import LastUpdate

_OURS = "sinew."  # how the paths of our settings begin


class Change(IntEnum):
    """The largest change of an object and its mesh since the last evaluation."""

    NOTHING = 0
    DRIVEN = 1  # at most values of its properties, such as the one whose driver follows the controls
    SETTINGS = 2
    GEOMETRY = 3  # what enters the modifiers may differ


class Changes:
    """What changed in one evaluation. In a render everything counts as changed, as all is evaluated anew."""

    def __init__(self, depsgraph: Depsgraph) -> None:
        self._depsgraph = depsgraph
        self._in_viewport = depsgraph.mode == "VIEWPORT"
        self._updates: dict[object, Change] | None = None
        self._new_geometry: set[Object] = set()

    def change_of(self, obj: Object) -> Change:
        """What changed of an object: everything, if Blender does not show it and so does not list it."""
        if not self._in_viewport or not obj.visible_get(view_layer=self._depsgraph.view_layer):
            return Change.GEOMETRY
        if obj in self._new_geometry:
            return Change.GEOMETRY
        return max(self._listed(obj), self._listed(obj.data))

    def take(self) -> None:
        """Read Blender's list now, because another evaluation is about to begin a new one."""
        self._listed(None)

    @property
    def has_scene(self) -> bool:
        """Whether the scene itself is on Blender's list."""
        return any(isinstance(update.id, Scene) for update in self._depsgraph.updates)

    def add_geometry(self, obj: Object) -> None:
        """Note that what enters the modifiers of an object may differ, whatever Blender lists."""
        self._new_geometry.add(obj)

    def has_edited_mesh(self, obj: Object) -> bool:
        """Whether the mesh itself, or its stack of modifiers, was edited."""
        return self._listed(obj.data) is Change.GEOMETRY

    def is_edited(self, part: ID) -> bool:
        """Whether Blender lists a datablock."""
        return self._listed(part) is not Change.NOTHING

    def read(self, obj: Object, evaluated: Object) -> tuple[tuple, list[ControlState]]:
        """Where the target and its controls are, for comparison; and the control of each deformer."""
        placed: list[object] = [placement.fingerprint(evaluated.matrix_world), *_driven(obj, evaluated)]
        controls = []
        for index, deformer in enumerate(obj.sinew.deformers):
            method = deformer.definition
            control = kinds.kind_of_method(method).read_state(deformer, self._depsgraph)
            controls.append(control)
            for place in control:
                placed.append(place and place.fingerprint)
            if method.keyed and deformer.keys:
                placed.append(self._depsgraph.scene.frame_current_final)
            if (method.references or method.wraps) and index < len(evaluated.sinew.deformers):
                placed += references.placed(evaluated.sinew.deformers[index])
        return tuple(placed), controls

    def last_update(self, obj: Object) -> LastUpdate | None:
        """What ``note`` noted of the object."""
        return sessions.last_update(obj.name_full) if self._in_viewport else None

    def note(self, obj: Object, update: LastUpdate) -> None:
        """Note that the target is up to date."""
        if self._in_viewport:
            sessions.note_update(obj.name_full, update)

    def _listed(self, part: object) -> Change:
        if self._updates is None:
            self._updates = {update.id.original: _change(update) for update in self._depsgraph.updates}
        return self._updates.get(part, Change.NOTHING)


def _driven(obj: Object, evaluated: Object) -> Iterator[str]:
    """The present value of each of our settings that has a driver."""
    animation = obj.animation_data
    for curve in animation.drivers if animation is not None else ():
        if curve.data_path.startswith(_OURS):
            try:
                value = evaluated.path_resolve(curve.data_path)
            except ValueError:  # it drives a row that is gone
                continue
            yield repr(value if isinstance(value, (bool, int, float, str)) else tuple(value))


def _change(update: DepsgraphUpdate) -> Change:
    if update.is_updated_geometry:
        return Change.GEOMETRY
    return Change.SETTINGS if update.is_updated_transform or update.is_updated_shading else Change.DRIVEN

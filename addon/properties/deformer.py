# SPDX-License-Identifier: GPL-3.0-or-later
"""A deformer of an object, and the list of them."""

from collections.abc import Callable, Sequence

from bpy.props import (
    BoolProperty,
    CollectionProperty,
    EnumProperty,
    FloatProperty,
    IntProperty,
    PointerProperty,
    StringProperty,
)
from bpy.types import Context, Mesh, Object, PropertyGroup

from ..core import status
from ..core.labels import items_of
from ..core.methods import BY_ID, DEFAULT_METHOD, METHODS, Curve, Method, Pointer, group_property, wrapper_of
from ..core.names import is_numbered, numbered
from ..core.tasks import TASKS, task_of
from ..ids import Keys
from .bake import SinewBake
from .companion import SinewCompanion
from .control import SinewControl, StoredCage
from .handle import SinewHandle
from .key import SinewKey
from .parameters import BASE, GROUPS
from .setting import SHARE, evaluate_again, field, matrix, option, record, setting, setting_list

LOOSE_PARTS = (
    ("FOLLOW", "Follow", "They ride on the surface that they lie on or in, like eyes, buttons and belts", 0),
    ("STAY", "Stay", "They stay where they are", 1),
)

SIZES = (
    ("BOX", "Box", "Those of boxes along the axes, as in files of earlier builds", 0),
    ("SURFACE", "Surface", "Those of each part of the surface, and of a ball around all handles", 1),
)

PLAYBACK = (
    ("FULL", "Full", "Every frame as it is rendered", 0),
    (
        "DRAFT",
        "Draft",
        "Frames after few iterations, the same for each frame; the full shape follows when playback rests",
        1,
    ),
)


method_items = items_of(METHODS, headed=True)

# Sinew gives, or gave, these names to new deformers, so nobody chose them.
_GIVEN = {
    "Sinew",
    *(task.deformer for task in TASKS),
    *(name for method in METHODS for name in (method.label, method.known_as)),
}


def _method_changed(deformer: "SinewDeformer", context: Context) -> None:
    """Name the deformer after the task of its method, as long as nobody has given it a name."""
    if is_numbered(deformer.name, _GIVEN):
        others = [other.name for other in deformer.id_data.sinew.deformers if other.uid != deformer.uid]
        deformer.name = numbered(task_of(deformer.definition).deformer, others)
    evaluate_again(deformer, context)


def _cage_changed(deformer: "SinewDeformer", context: Context) -> None:
    """Forget the rest cage, since another cage was chosen. The next bind stores its rest shape."""
    deformer.cage_rest = None
    evaluate_again(deformer, context)


def _keeps_details(deformer: "SinewDeformer") -> bool:
    return bool(deformer.definition.wraps)


def _keep_details(deformer: "SinewDeformer", wanted: bool) -> None:
    """Put the method that keeps details around the one in use, or take it off again."""
    method, _values = deformer.methods[-1]
    wrapper = wrapper_of(method)
    if wrapper is None or wanted == _keeps_details(deformer):
        return
    if wanted:
        setattr(getattr(deformer, wrapper.id), BASE, method.id)
    deformer.method = wrapper.id if wanted else method.id


_click_observers: list[Callable[["SinewDeformer", str], None]] = []


def add_click_observer(observer: Callable[["SinewDeformer", str], None]) -> None:
    """Call ``observer`` with a deformer and "handles" or "controls" when a row of that list is clicked."""
    _click_observers.append(observer)


def remove_click_observer(observer: Callable[["SinewDeformer", str], None]) -> None:
    """Stop calling ``observer``."""
    _click_observers.remove(observer)


def _clicked_row(rows: str, active: str):
    """The active row of a list as the list itself changes it: only an artist clicks there, no script."""

    def click(deformer: "SinewDeformer", index: int) -> None:
        setattr(deformer, active, index)
        for observer in _click_observers:
            observer(deformer, rows)

    return field(
        IntProperty,
        get=lambda deformer: getattr(deformer, active),
        set=click,
        options={"HIDDEN", "SKIP_SAVE"},
    ).named("Active Row", "Choose a row, and select what moves it")


def _may_be_cage(deformer: "SinewDeformer", obj: Object) -> bool:
    return obj.type == "MESH" and obj != deformer.id_data


class SinewDeformer(PropertyGroup):
    """Settings of one deformer"""

    uid: record(StringProperty)
    name: option(StringProperty, default="Sinew").named(
        "Name", "Name the deformer in the list; until you do, it has the name of its task"
    )
    method: setting(
        EnumProperty, update=_method_changed, items=method_items, default=BY_ID[DEFAULT_METHOD].number
    ).named("Method", "Set how the mesh follows its controls")
    keep_details: field(BoolProperty, get=_keeps_details, set=_keep_details, options={"SKIP_SAVE"}).named(
        "Keep Details", "Turn bumps with the surface, or with the space around it, instead of shearing them"
    )
    cage: setting(PointerProperty, type=Object, poll=_may_be_cage, update=_cage_changed).named(
        "Cage", "Choose the closed mesh around this one that moves it, with its own modifiers applied"
    )
    cage_rest: record(
        PointerProperty,
        type=Mesh,
        description="The shape of the cage at bind, in the object space of the target",
    )
    owns_cage: record(
        BoolProperty, description="Whether the cage was made for this deformer, and is removed with it"
    )
    controls: setting_list(type=SinewControl)
    active_control: record(IntProperty)
    chosen_control: _clicked_row("controls", "active_control")
    handles: setting_list(type=SinewHandle)
    active_handle: record(IntProperty)
    chosen_handle: _clicked_row("handles", "active_handle")
    companions: record(
        CollectionProperty,
        type=SinewCompanion,
        description="The objects that share handles, at bind, and the target among them; empty if none do",
    )
    keys: setting_list(type=SinewKey)
    active_key: record(IntProperty)
    use_mirror_x: setting(BoolProperty, options=set()).named(
        "Mirror",
        "Let the control of the other side follow as a mirror image, across the local X axis "
        "of the mesh, where names have a side, such as Hand L",
    )
    factor: setting(FloatProperty, **SHARE).named("Factor", "Set how much of the deformation is shown")
    mask_group: setting(StringProperty).named(
        "Mask",
        "Choose the vertex group that limits where the deformation is shown; if empty, it is "
        "shown everywhere",
    )
    loose_parts: setting(EnumProperty, items=LOOSE_PARTS).named(
        "Loose Parts", "Choose what the parts of the mesh do that no region touches"
    )
    sizes: record(
        EnumProperty,
        items=SIZES,
        description="Which sizes the parameters are shares of that are shares of a size. A file that says "
        "nothing is of an earlier build, and keeps its looks",
    )
    defaults: record(
        IntProperty,
        description="How often defaults of parameters had changed when it was made. A file that says "
        "nothing is of an earlier build: 1 with sizes of the surface, else 0",
    )
    live: setting(BoolProperty, default=True).named(
        "Live", "Follow the controls; if it is off, the last shape stays"
    )
    playback: option(EnumProperty, options=set(), items=PLAYBACK).named(
        "Playback", "Play faster by drafts in viewports; renders and bakes are always full"
    )
    auto_rebind: option(BoolProperty).named(
        "Automatic Rebind",
        "Bind again by itself when the mesh, or an object whose points move it, gains or loses points",
    )
    topology_changed: record(BoolProperty)
    proxy: record(PointerProperty, type=Object)
    proxy_render: record(PointerProperty, type=Object)
    shape_key: record(
        StringProperty, description="The name of the shape key that shows the deformer of a lattice object"
    )
    rest: record(PointerProperty, type=Mesh)
    rest_render: record(
        PointerProperty,
        type=Mesh,
        description="The rest shape for renders, if modifiers before Sinew give another number of vertices "
        "there",
    )
    has_applied: record(BoolProperty)
    applied: matrix("Applied", "Transform from rest to current object space, after Apply or Set Origin")
    bake: option(PointerProperty, type=SinewBake)()
    status: field(
        StringProperty, options={"SKIP_SAVE"}, get=lambda deformer: status.told(deformer.uid)
    ).named("Status", "Say what the deformer is doing, or what is wrong and what to do about it")
    status_level: field(
        StringProperty,
        options={"HIDDEN", "SKIP_SAVE"},
        get=lambda deformer: status.current(deformer.uid).level.value,
    ).named("Status Level", "NONE, INFO, WARNING or ERROR")

    @property
    def definition(self) -> Method:
        """The registry row of the method in use; that of the default if a file names an unknown method."""
        return BY_ID.get(self.method, BY_ID[DEFAULT_METHOD])

    @property
    def parameters(self) -> PropertyGroup:
        """The parameters of the method in use, by name."""
        return getattr(self, self.definition.id)

    @property
    def methods(self) -> tuple[tuple[Method, PropertyGroup], ...]:
        """The methods in use, each with its parameters: the method, then the one that it is put around."""
        method = self.definition  # Blender takes as long to say which as for some of the other steps
        own = (method, getattr(self, method.id))
        if not method.wraps:
            return (own,)
        base = BY_ID[getattr(own[1], BASE)]
        return own, (base, getattr(self, base.id))

    @property
    def plain_parameters(self) -> list[tuple[str, str]]:
        """The parameters in use with a plain value, each by the method and its own name."""
        found = []
        for method, _values in self.methods:
            found += [(method.id, BASE)] * bool(method.wraps)
            for parameter in method.parameters:
                if not isinstance(parameter, Curve | Pointer):
                    found.append((method.id, parameter.id))
        return found

    @property
    def is_iterative(self) -> bool:
        """Whether a method in use is iterative, so that a drag can show an early step."""
        return any(method.iterative for method, _values in self.methods)

    @property
    def draft_iterations(self) -> int:
        """How many iterations a draft of a frame takes."""
        return max(method.draft_iterations for method, _values in self.methods)

    def complete(self) -> None:
        """Let Blender create all settings now, so that no render thread has to (see ``deformers_of``)."""
        for group in ("bake", *BY_ID):
            getattr(self, group)

    @property
    def is_bound(self) -> bool:
        """Whether a rest shape is stored. The factor is computed from it when needed."""
        return self.rest_in("VIEWPORT") is not None

    @property
    def all_controls(self) -> list[StoredCage | SinewControl]:
        """The objects that move the deformer with any of its methods; first the cage, if there is one."""
        cage = StoredCage(self)
        return [*([] if cage.object is None and cage.rest is None else [cage]), *self.controls]

    @property
    def cage_missing(self) -> bool:
        """Whether the cage was deleted, or removed from all scenes."""
        return StoredCage(self).missing

    @property
    def renders_differ(self) -> bool:
        """Whether renders have another number of vertices. If not, ``rest_render`` is empty or None."""
        return isinstance(self.rest_render, Mesh) and len(self.rest_render.vertices) > 0

    def take_group_names(self, renamed: dict[str, str]) -> None:
        """Use the new names of renamed vertex groups, by their old names."""
        for handle in self.handles:
            if handle.vertex_group in renamed:
                handle.vertex_group = renamed[handle.vertex_group]
        for method, values in self.methods:
            for name in map(group_property, method.paintable):
                if getattr(values, name) in renamed:
                    setattr(values, name, renamed[getattr(values, name)])
        self.mask_group = renamed.get(self.mask_group, self.mask_group)

    def rename_rest_group(self, old: str, new: str) -> None:
        """Rename a vertex group in the rest shapes, which remember the groups that they were made with."""
        for name in ("rest", "rest_render"):
            mesh = getattr(self, name)
            if not isinstance(mesh, Mesh) or Keys.REST_GROUPS not in mesh or mesh.library is not None:
                continue
            if mesh.users > 1:  # a copy of the object, whose groups keep their names, uses it too
                mesh = mesh.copy()
                setattr(self, name, mesh)
            mesh[Keys.REST_GROUPS] = [new if group == old else group for group in mesh[Keys.REST_GROUPS]]

    def shape(self, mode: str) -> Object | None:
        """The hidden object that holds the shape for VIEWPORT or RENDER; None if Sinew did not make it."""
        shape = self.proxy_render if mode == "RENDER" else self.proxy
        if not isinstance(shape, Object) or shape.type != "MESH" or Keys.SHAPE not in shape.data:
            return None
        # "not vertices" would ask Blender for write access, which copies the data.
        if len(shape.data.vertices) == 0:
            return None
        return None if mode == "RENDER" and shape == self.proxy else shape

    def rest_in(self, mode: str) -> Mesh | None:
        """The rest shape for VIEWPORT or RENDER; None if the deformer is not bound."""
        rest = self.rest_render if mode == "RENDER" and self.renders_differ else self.rest
        return rest if isinstance(rest, Mesh) else None


for _method in METHODS:
    SinewDeformer.__annotations__[_method.id] = option(PointerProperty, type=GROUPS[_method.id])()


def deformers_of(obj: Object) -> Sequence[SinewDeformer]:
    """The deformers of any object.

    When settings are read that do not exist, Blender creates them, even in another thread, where two threads
    could write at once. This function leaves an object without settings as it is.
    """
    return obj.sinew.deformers if obj.is_property_set("sinew") else ()


class SinewObject(PropertyGroup):
    """What Sinew stores on an object"""

    deformers: setting_list(type=SinewDeformer)
    active_deformer: record(IntProperty)

    def rename_group(self, old: str, new: str) -> None:
        """Rename a vertex group of the object, with all settings that name it."""
        group = self.id_data.vertex_groups.get(old)
        if group is None:
            return
        group.name = new
        for deformer in self.deformers:
            deformer.take_group_names({old: group.name})
            deformer.rename_rest_group(old, group.name)

    @property
    def active(self) -> SinewDeformer | None:
        """The deformer shown in the panel."""
        if not self.deformers:
            return None
        return self.deformers[min(max(self.active_deformer, 0), len(self.deformers) - 1)]

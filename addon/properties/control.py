# SPDX-License-Identifier: GPL-3.0-or-later
"""An object that moves a deformer. Handles, which are regions of the mesh too, have their own list."""

from bpy.props import BoolProperty, PointerProperty, StringProperty
from bpy.types import Context, Mesh, Object, PropertyGroup

_OVERRIDE = {"LIBRARY_OVERRIDABLE"}


def _object_changed(control: "SinewControl", _context: Context) -> None:
    """Another object rests where it is when it is bound."""
    control.rest = None
    control.id_data.update_tag(refresh={"OBJECT"})


class SinewControl(PropertyGroup):
    """An object that moves a deformer"""

    kind: StringProperty(
        options={"HIDDEN"}, override=_OVERRIDE, description="The kind of control, as its folder is called"
    )
    name: StringProperty(name="Name", override=_OVERRIDE, description="What the list calls the control")
    object: PointerProperty(
        name="Object",
        type=Object,
        update=_object_changed,
        override=_OVERRIDE,
        description="The object that moves this one, as its own modifiers leave it",
    )
    rest: PointerProperty(
        type=Mesh,
        options={"HIDDEN"},
        override=_OVERRIDE,
        description="The object at bind, in the frame of the mesh",
    )
    owned: BoolProperty(
        options={"HIDDEN"},
        override=_OVERRIDE,
        description="The object was made for this deformer, and goes with it",
    )


class StoredCage:
    """The cage of a deformer, as a row like ``SinewControl``.

    A deformer has one cage, which files keep in properties of the deformer itself. Library overrides and
    linked files name these, so they stay.
    """

    kind = "cage"
    object = property(lambda row: row.deformer.cage, lambda row, cage: setattr(row.deformer, "cage", cage))
    rest = property(
        lambda row: row.deformer.cage_rest if isinstance(row.deformer.cage_rest, Mesh) else None,
        lambda row, mesh: setattr(row.deformer, "cage_rest", mesh),
    )
    owned = property(
        lambda row: row.deformer.owns_cage, lambda row, owned: setattr(row.deformer, "owns_cage", owned)
    )

    def __init__(self, deformer: PropertyGroup) -> None:
        self.deformer = deformer

# SPDX-License-Identifier: GPL-3.0-or-later
"""An object that moves a deformer. Handles, which are regions of the mesh too, have their own list."""

from bpy.props import BoolProperty, PointerProperty, StringProperty
from bpy.types import Context, Mesh, Object, PropertyGroup

from .setting import record, reshape, setting


def _object_changed(control: "SinewControl", context: Context) -> None:
    """Another object rests where it is when it is bound."""
    control.rest = None
    reshape(control, context)


class SinewControl(PropertyGroup):
    """An object that moves a deformer"""

    kind: record(StringProperty, description="The kind of control, as its folder is called")
    name: setting(StringProperty, update=None, name="Name", description="What the list calls the control")
    object: setting(
        PointerProperty,
        update=_object_changed,
        name="Object",
        type=Object,
        description="The object that moves this one, as its own modifiers leave it",
    )
    rest: record(PointerProperty, type=Mesh, description="The object at bind, in the frame of the mesh")
    owned: record(BoolProperty, description="The object was made for this deformer, and goes with it")


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

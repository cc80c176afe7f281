# SPDX-License-Identifier: GPL-3.0-or-later
"""An object that moves a deformer. Handles are not among them: they are regions and have their own list."""

import bpy
from bpy.props import BoolProperty, PointerProperty, StringProperty
from bpy.types import Context, Mesh, Object, PropertyGroup

from ..core.methods import CONTROL_PARAMETERS
from .parameters import declare
from .setting import evaluate_again, option, record, setting


def _object_changed(control: "SinewControl", context: Context) -> None:
    """Forget the rest shape, since another object was chosen. The next bind stores its rest shape."""
    control.rest = None
    evaluate_again(control, context)


def _domain_changed(control: "SinewControl", context: Context) -> None:
    """Forget the shape of the domain curve. The next bind stores that of the new one beside the wire."""
    control.has_domain = False
    evaluate_again(control, context)


def _is_missing(control: "SinewControl | StoredCage") -> bool:
    """Whether the object was deleted, or removed from all scenes."""
    obj = control.object
    return obj is None or not any(obj.name in scene.objects for scene in bpy.data.scenes)


class SinewControl(PropertyGroup):
    """An object that moves a deformer"""

    kind: record(StringProperty, description="The kind of control, by the name of its folder")
    name: option(StringProperty).named("Name", "Give the name of the control in the list")
    object: setting(PointerProperty, update=_object_changed, type=Object).named(
        "Object", "Choose the object that moves this one, with its own modifiers applied"
    )
    rest: record(
        PointerProperty,
        type=Mesh,
        description="The shape of the object at bind, in the object space of the target",
    )
    owned: record(
        BoolProperty, description="Whether the object was made for this deformer, and is removed with it"
    )
    domain: setting(
        PointerProperty,
        update=_domain_changed,
        type=Object,
        poll=lambda control, obj: obj.type == "CURVE" and obj not in (control.object, control.id_data),
    ).named("Beside", "Let the wire reach no farther than this curve, in its direction")
    has_domain: record(BoolProperty, description="Whether the rest shape holds the domain curve, too")
    enabled: setting(BoolProperty, default=True).named(
        "Use", "Use this control; if it is off, nothing follows it"
    )
    missing = property(_is_missing)


for _parameter in CONTROL_PARAMETERS:
    SinewControl.__annotations__[_parameter.id] = declare(_parameter)


class StoredCage:
    """The cage of a deformer, with the same attributes as ``SinewControl``.

    Files store the cage in properties of the deformer itself. Library overrides and linked files refer to
    these properties, so they cannot move into the list of controls.
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
    missing = property(_is_missing)

    def __init__(self, deformer: PropertyGroup) -> None:
        self.deformer = deformer

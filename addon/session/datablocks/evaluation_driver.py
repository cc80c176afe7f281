# SPDX-License-Identifier: GPL-3.0-or-later
"""The driver on a target that makes Blender evaluate its controls, also hidden ones. Main thread only."""

from collections.abc import Sequence
from dataclasses import dataclass

from bpy.types import FCurve, Object

from ...ids import Keys
from .references import pointed

_KEEP = f'["{Keys.KEEP}"]'


@dataclass(frozen=True)
class Link:
    """An object or a bone that a deformer follows. ``by_shape``: its vertices count, not only its place."""

    object: Object
    bone: str = ""
    by_shape: bool = False


def find_driver(obj: Object) -> FCurve | None:
    """The driver, if the object has it."""
    return obj.animation_data.drivers.find(_KEEP) if obj.animation_data is not None else None


def pointer_links(obj: Object) -> list[Link]:
    """The objects that parameters refer to."""
    return [
        Link(other, by_shape=by_shape)
        for deformer in obj.sinew.deformers
        for other, by_shape in pointed(deformer)
    ]


def is_kept(obj: Object) -> bool:
    """Whether the driver is there if it is needed, and names the objects that parameters refer to."""
    pointers = {link.object for link in pointer_links(obj)}
    if Keys.KEEP not in obj:
        return not pointers
    curve = find_driver(obj)
    if curve is None or not pointers:
        return curve is not None
    return pointers <= {variable.targets[0].id for variable in curve.driver.variables}


def write_driver(obj: Object, links: Sequence[Link]) -> None:
    """One SUM driver with a variable per link, so that Blender evaluates controls hidden or in no scene too.

    A link whose shape counts has a second variable, which reads dimensions, as these depend on the shape. The
    driver has no Python expression, so it also works in files that are not trusted.
    """
    if obj.animation_data is not None:
        for curve in [curve for curve in obj.animation_data.drivers if curve.data_path == _KEEP]:
            obj.animation_data.drivers.remove(curve)
    if not links:
        if Keys.KEEP in obj:
            del obj[Keys.KEEP]
        return
    obj[Keys.KEEP] = 0.0
    driver = obj.driver_add(_KEEP).driver
    driver.type = "SUM"
    for link in links:
        variable = driver.variables.new()
        variable.type = "TRANSFORMS"
        target = variable.targets[0]
        target.id = link.object
        if link.bone:
            target.bone_target = link.bone
    for link in links:
        if link.by_shape:
            variable = driver.variables.new()
            variable.type = "SINGLE_PROP"
            target = variable.targets[0]
            target.id, target.data_path = link.object, "dimensions[0]"

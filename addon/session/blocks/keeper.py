# SPDX-License-Identifier: GPL-3.0-or-later
"""The driver on a target that makes Blender evaluate its controls, hidden ones too. Main thread only."""

from bpy.types import Object

from ...ids import Keys

_KEEP = f'["{Keys.KEEP}"]'


def _kept_controls(obj: Object) -> list[tuple[Object, str]]:
    """Controls and bones of the object's handles, each once, in the order of the driver's variables."""
    return list(
        dict.fromkeys(
            (handle.control, handle.bone)
            for deformer in obj.sinew.deformers
            for handle in deformer.handles
            if handle.kind == "HANDLE" and handle.control is not None
        )
    )


def _kept_cages(obj: Object) -> list[Object]:
    """The object's cages, each once."""
    cages = (deformer.cage for deformer in obj.sinew.deformers)
    return list(dict.fromkeys(cage for cage in cages if cage is not None))


def follow_renamed_bones(obj: Object) -> bool:
    """Blender renames bones in drivers, not in our settings: take the new names from there."""
    curve = obj.animation_data.drivers.find(_KEEP) if obj.animation_data is not None else None
    kept = _kept_controls(obj)
    if curve is None or len(curve.driver.variables) < len(kept):
        return False
    renamed = False
    for (control, bone), variable in zip(kept, curve.driver.variables, strict=False):
        target = variable.targets[0]
        bones = control.pose.bones if control.pose is not None else ()
        if target.id != control or not bone or bone in bones or target.bone_target not in bones:
            continue
        for deformer in obj.sinew.deformers:
            for handle in deformer.handles:
                if handle.control == control and handle.bone == bone:
                    had_rest = handle.has_rest
                    handle.bone = target.bone_target
                    handle.has_rest = had_rest
                    renamed = True
    return renamed


def is_kept(obj: Object) -> bool:
    """The driver that keeps the controls evaluated is there, where it is needed."""
    if Keys.KEEP not in obj:
        return True
    return obj.animation_data is not None and obj.animation_data.drivers.find(_KEEP) is not None


def keep_evaluated(obj: Object) -> None:
    """One SUM driver, one variable per control: Blender then evaluates hidden and unlinked controls too.

    A cage has two: its dimensions depend on its shape. It has no Python expression, so it also works in
    files that are not trusted.
    """
    if obj.animation_data is not None:
        for curve in [curve for curve in obj.animation_data.drivers if curve.data_path == _KEEP]:
            obj.animation_data.drivers.remove(curve)
    controls, cages = _kept_controls(obj), _kept_cages(obj)
    if not controls and not cages:
        if Keys.KEEP in obj:
            del obj[Keys.KEEP]
        return
    obj[Keys.KEEP] = 0.0
    driver = obj.driver_add(_KEEP).driver
    driver.type = "SUM"
    for control, bone in (*controls, *((cage, "") for cage in cages)):
        variable = driver.variables.new()
        variable.type = "TRANSFORMS"
        target = variable.targets[0]
        target.id = control
        if bone:
            target.bone_target = bone
    for cage in cages:
        variable = driver.variables.new()
        variable.type = "SINGLE_PROP"
        target = variable.targets[0]
        target.id, target.data_path = cage, "dimensions[0]"

# SPDX-License-Identifier: GPL-3.0-or-later
"""Drivers of our settings: the viewport shows what they say, at once and in each frame.

The expected shape is that of the same rig with the value set by hand, or a closed form.
"""

from collections.abc import Callable, Iterator

import bpy
import numpy as np
import pytest
from rigs.kinds import HandleRig
from rigs.rig import close, evaluated_points, key, new_empty, push, update

HEIGHT = 0.5
TOLERANCE = 2e-5
Set = Callable[[float], None]


def _follow(driver: bpy.types.Driver) -> bpy.types.Object:
    source = new_empty("Source")
    variable = driver.variables.new()
    variable.type = "TRANSFORMS"
    variable.targets[0].id = source
    variable.targets[0].transform_type = "LOC_X"
    return source


def by_object(driver: bpy.types.Driver) -> Set:
    _follow(driver)

    def set_to(value: float) -> None:
        bpy.data.objects["Source"].location.x = value
        update()

    return set_to


def by_scene(driver: bpy.types.Driver) -> Set:
    bpy.context.scene["amount"] = 0.0
    target = driver.variables.new().targets[0]
    target.id_type, target.id, target.data_path = "SCENE", bpy.context.scene, '["amount"]'

    def set_to(value: float) -> None:
        bpy.context.scene["amount"] = value
        bpy.context.scene.update_tag()
        update()

    return set_to


def by_keys(driver: bpy.types.Driver) -> Set:
    """Driven by the place of an object that is animated: ten frames for each 1."""
    ends = {frame: {"location": (0.1 * frame, 0.0, 0.0)} for frame in (-100, 100)}
    key(_follow(driver), ends, linear=True)
    return _go_to


def by_frame(driver: bpy.types.Driver) -> Set:
    driver.type, driver.expression = "SCRIPTED", "frame / 10"
    return _go_to


def _go_to(value: float) -> None:
    bpy.context.scene.frame_set(round(10.0 * value))


SOURCES = {"object": by_object, "scene": by_scene, "keys": by_keys, "frame": by_frame}


def drive(owner: bpy.types.PropertyGroup, name: str, source: str = "object") -> Set:
    """Let a property follow something; returns how to change that."""
    driver = owner.driver_add(name).driver
    driver.type = "SUM"
    return SOURCES[source](driver)


@pytest.mark.parametrize("source", SOURCES)
def test_a_driven_factor_is_shown_at_once(posed: HandleRig, source: str):
    """In a render, too, and after undo and redo."""
    rest, whole = posed.rest(), posed.at(HEIGHT)
    set_to = drive(posed.deformer, "factor", source)

    def is_shown(value: float) -> bool:
        return posed.shows(rest + value * (whole - rest), tolerance=TOLERANCE)

    for value in (0.3, 0.8, 0.1):
        set_to(value)
        assert is_shown(value), value
        push(f"{value}")
    if source == "object":  # what a step of undo holds
        bpy.ops.ed.undo()
        assert is_shown(0.8)
        bpy.ops.ed.redo()
    set_to(0.5)
    assert is_shown(0.5)
    assert posed.renders(rest + 0.5 * (whole - rest), TOLERANCE)


def settings(rig: HandleRig) -> Iterator[tuple[str, str, float, float]]:
    """Each setting of numbers and choices: its owner, its name, its value, and another one, as numbers."""
    deformer = rig.deformer
    owners = {"": deformer, f"{deformer.method}.": deformer.parameters}
    owners |= {
        f"{rows}[0].": getattr(deformer, rows)[0]
        for rows in ("handles", "controls")
        if getattr(deformer, rows)
    }
    for path, owner in owners.items():
        for row in owner.bl_rna.properties:
            if not row.is_animatable or row.is_readonly or getattr(row, "is_array", False):
                continue
            now = getattr(owner, row.identifier)
            if row.type == "ENUM" and not row.is_enum_flag:
                numbers = {item.identifier: item.value for item in row.enum_items}
                others = [number for name, number in numbers.items() if name != now]
                if now in numbers and others:
                    yield path, row.identifier, numbers[now], others[0]
            elif row.type == "BOOLEAN":
                yield path, row.identifier, float(now), float(not now)
            elif row.type in ("FLOAT", "INT"):
                least, most = row.soft_min, row.soft_max
                other = now + 0.5 * (most - now) if most - now > now - least else now - 0.5 * (now - least)
                other = now + 1.0 if abs(other) > 100.0 else other
                yield path, row.identifier, now, float(round(other)) if row.type == "INT" else other


NOT_A_SETTING = ("method", "kind", "index", "active")  # another kind of control, or what the panel shows


def test_every_setting_can_be_driven(posed: HandleRig):
    seen = []
    for path, name, before, other in list(settings(posed)):
        if name.startswith(NOT_A_SETTING):
            continue

        def owner(path: str = path) -> bpy.types.PropertyGroup:
            return posed.deformer.path_resolve(path[:-1]) if path else posed.deformer

        shapes = {}
        for value in (before, other):
            _set(owner(), name, value)
            posed.obj.update_tag()
            shapes[value] = evaluated_points(posed.obj)
        _set(owner(), name, before)
        update()
        if np.abs(shapes[other] - shapes[before]).max() < 1e-3:
            continue
        set_to = drive(owner(), name)
        for value in (before, other, before):
            set_to(value)
            assert close(evaluated_points(posed.obj), shapes[value], TOLERANCE), f"{path}{name} = {value}"
        owner().driver_remove(name)
        _set(owner(), name, before)
        bpy.data.objects.remove(bpy.data.objects["Source"])
        update()
        seen.append(path + name)
    assert "factor" in seen
    if posed.deformer.handles or posed.deformer.controls:
        assert len(seen) > 1, seen


def _set(owner: bpy.types.PropertyGroup, name: str, value: float) -> None:
    row = owner.bl_rna.properties[name]
    if row.type == "ENUM":
        value = next(item.identifier for item in row.enum_items if item.value == value)
    setattr(owner, name, {"BOOLEAN": bool, "INT": round}.get(row.type, lambda same: same)(value))

# SPDX-License-Identifier: GPL-3.0-or-later
"""Undo and redo of every button of lattices, wires, tools and handle points."""

from __future__ import annotations

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from rigs.rig import close, evaluated_points, grid_object, linked, make_active, push, update
from rigs.rig_of_curves import polyline, stroke_through

LINE = np.column_stack((np.linspace(-1.0, 1.0, 6), np.zeros((6, 2))))
STROKE = [tuple(place) for place in LINE[1:-1]]


def plate() -> bpy.types.Object:
    return bpy.data.objects["Plate"]


def press(name: str, **options: object) -> None:
    make_active(plate())
    assert getattr(bpy.ops.sinew, name)(**options) == {"FINISHED"}


def with_lattice() -> None:
    press("lattice_add", resolution=(3, 3, 2))
    lattice = bpy.data.objects["Plate Lattice"]
    lattice.location.z += 0.3


def with_wire() -> None:
    polyline(LINE, "Wire")
    press("wire_add", curve="Wire", radius=0.6)
    bpy.data.objects["Wire"].location.z = 0.3


def with_tool() -> None:
    press("tool_add", tool="drag", location=(0.0, 0.0, 0.0))
    plate().sinew.active.controls[0].object.location.z = 0.2


def with_an_empty() -> None:
    linked(bpy.data.objects.new("Point", None)).location = (0.5, 0.5, 0.0)


def nothing() -> None:
    polyline(LINE, "Wire")


BUTTONS: dict[str, tuple[Callable[[], None], dict[str, object]]] = {
    "lattice_add": (nothing, {"resolution": (3, 3, 2)}),
    "lattice_set_rest": (with_lattice, {}),
    "wire_add": (nothing, {"curve": "Wire", "radius": 0.6}),
    "wire_draw": (nothing, {"points": 5, "radius": 0.6}),
    "control_remove": (with_wire, {"index": 0}),
    "control_set_rest": (with_wire, {}),
    "tool_add": (nothing, {"tool": "twist"}),
    "tool_stop": (with_tool, {}),
    "tool_drag": (nothing, {"radius": 0.8}),
    "point_add": (with_an_empty, {"source": "CURSOR"}),
}
STROKES = {"wire_draw": "stroke", "tool_drag": "path"}


def seen() -> tuple[list, list[str]]:
    """What the panel lists, and the objects of the scene."""
    update()
    rows = [
        (
            row.method,
            row.is_bound,
            [handle.name for handle in row.handles],
            [control.object.name if control.object else "" for control in row.controls],
        )
        for row in plate().sinew.deformers
    ]
    return rows, sorted(obj.name for obj in bpy.context.scene.objects)


@pytest.mark.parametrize("name", BUTTONS)
def test_undo_and_redo_of(name: str):
    prepare, options = BUTTONS[name]
    if name in STROKES:
        way = [(0.0, 0.0, 0.1 * k) for k in range(5)] if name == "tool_drag" else STROKE
        options = options | {STROKES[name]: stroke_through(way)}
    grid_object()
    push("plate")
    prepare()
    make_active(plate())
    push("posed")
    before, shape_before = seen(), evaluated_points(plate())
    press(name, **options)
    after, shape = seen(), evaluated_points(plate())
    push("pressed")
    for _ in range(2):
        bpy.ops.ed.undo()
        assert seen() == before
        assert close(evaluated_points(plate()), shape_before)
        bpy.ops.ed.redo()
        assert seen() == after
        assert close(evaluated_points(plate()), shape)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Tools of vector fields: twist, bend and drag, their stored paths, and their animation."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import native
from mathutils import Matrix
from rigs.cages import fine_box
from rigs.rig import (
    FLOAT32,
    apply_matrix,
    base_points,
    close,
    evaluated_points,
    grid_object,
    key,
    linked,
    make_active,
    press,
    reopen,
    update,
)
from rigs.rig_of_curves import stroke_through
from rigs.rig_of_tools import FRAME

INTEGRATED = 3e-5  # the tolerance of the flow, on each piece of a path


def bar(levels: int = 4) -> bpy.types.Object:
    """A closed bar along z of height 4."""
    obj = fine_box(2**levels - 1)
    obj.data.transform(Matrix.Diagonal((0.5, 0.5, 2.0, 1.0)))
    return obj


def add(obj: bpy.types.Object, tool: str, **reach: float) -> bpy.types.PropertyGroup:
    """A tool in the middle of the object; its row in the list."""
    press(obj, "tool_add", tool=tool, location=obj.location)
    make_active(obj)
    row = obj.sinew.active.controls[-1]
    for name, value in reach.items():
        setattr(row, name, value)
    update()
    return row


def straight(points: np.ndarray, frames: np.ndarray, **options: object) -> np.ndarray:
    """What a tool at the origin makes of points on its path through frames (4 f, 3)."""
    field = native().VectorField(np.tile(FRAME, (len(frames) // 4, 1)), **options)
    field.bind(points)
    return field.warp(frames)


POSE = Matrix.Translation((0.3, 0.0, 0.2)) @ Matrix.Rotation(0.8, 4, "X")
MORE_THAN_ONCE = [Matrix.Rotation(np.radians(degrees), 4, "Z") for degrees in (150.0, 300.0, 450.0)]


@pytest.mark.parametrize(
    ("tool", "inner", "stops"),
    [("twist", -1.2, MORE_THAN_ONCE), ("bend", -1.2, [POSE]), ("drag", 0.0, [POSE])],
)
def test_tools_are_those_of_the_library(tool: str, inner: float, stops: list[Matrix]) -> None:
    obj = bar()
    reach = {"inner": inner, "outer": 1.2, "width": 0.9}
    row = add(obj, tool, **reach)
    for stop in stops:
        row.object.matrix_world = stop
        if stop is not stops[-1]:
            press(obj, "tool_stop")
    posed = np.concatenate([apply_matrix(stop, FRAME) for stop in stops])
    expected = straight(base_points(obj), posed, tools=tool, **reach)
    assert close(evaluated_points(obj), expected, INTEGRATED)
    assert np.abs(expected - base_points(obj)).max() > 0.3


def walk(row, *places: tuple[float, float, float]) -> None:
    """Move the tool from stop to stop."""
    for place in places:
        row.object.location = place
        press(row.id_data, "tool_stop")


STOPS = ((0.5, 0.0, 0.0), (0.5, 0.5, 0.2))
END = (0.0, 0.6, 0.4)


@pytest.fixture
def walked() -> tuple[bpy.types.Object, bpy.types.PropertyGroup]:
    """A plate, and the row of the tool that was dragged over it."""
    obj = grid_object(cells=20)
    row = add(obj, "drag", inner=0.3, outer=0.9)
    walk(row, *STOPS)
    row.object.location = END
    return obj, row


def on_path(obj: bpy.types.Object, places=(*STOPS, END), **options: object) -> np.ndarray:
    frames = np.concatenate([FRAME + place for place in places])
    return straight(base_points(obj), frames, inner=0.3, outer=0.9, **options)


def test_the_path_is_stored_and_a_frame_depends_on_it_alone(walked, tmp_path: Path) -> None:
    obj, _row = walked
    shape = evaluated_points(obj)
    assert close(shape, on_path(obj), INTEGRATED)
    assert not close(shape, on_path(obj, (END,)), 0.02), "the way counts"
    reopen(tmp_path / "path.blend")
    obj = bpy.data.objects["Plate"]
    assert close(evaluated_points(obj), shape)
    tool = obj.sinew.active.controls[0].object
    tool.location = (0.0, 0.0, 3.0)  # another way to the same place changes nothing
    update()
    tool.location = END
    assert close(evaluated_points(obj), shape)
    press(obj, "tool_stop", clear=True)
    assert close(evaluated_points(obj), on_path(obj, (END,)), INTEGRATED)


def test_progress_goes_along_the_path(walked) -> None:
    obj, row = walked
    whole = evaluated_points(obj)
    row.progress = 0.0
    assert close(evaluated_points(obj), base_points(obj))
    ways = [
        np.linalg.norm(np.subtract(b, a)) for a, b in zip(((0, 0, 0), *STOPS), (*STOPS, END), strict=True)
    ]
    row.progress = ways[0] / sum(ways)
    assert close(evaluated_points(obj), on_path(obj, STOPS[:1]), INTEGRATED)
    row.progress = (ways[0] + 0.5 * ways[1]) / sum(ways)
    middle = tuple(0.5 * (np.array(STOPS[0]) + STOPS[1]))
    assert close(evaluated_points(obj), on_path(obj, (STOPS[0], middle)), INTEGRATED)
    row.progress = 1.0
    assert close(evaluated_points(obj), whole)


def test_progress_and_tools_can_be_keyed() -> None:
    obj = grid_object(cells=20)
    row = add(obj, "drag", inner=0.3, outer=0.9)
    row.object.location = (0.6, 0.0, 0.0)
    key(row, {1: {"progress": 0.0}, 11: {"progress": 1.0}})
    key(row.object, {1: {"location": (0.6, 0.0, 0.0)}, 21: {"location": (0.6, 0.0, 0.5)}})
    for frame, place in ((1, None), (11, (0.6, 0.0, row.object.location.z)), (21, (0.6, 0.0, 0.5))):
        bpy.context.scene.frame_set(frame)
        place = place and tuple(row.object.evaluated_get(bpy.context.evaluated_depsgraph_get()).location)
        expected = base_points(obj) if place is None else on_path(obj, (place,))
        assert close(evaluated_points(obj), expected, INTEGRATED), frame


def test_a_drag_from_a_script_leaves_a_path() -> None:
    obj = grid_object(cells=20)
    make_active(obj)
    way = stroke_through([(0.0, 0.0, 0.1 * k) for k in range(9)])
    assert bpy.ops.sinew.tool_drag(path=way, radius=0.8) == {"FINISHED"}
    row = obj.sinew.active.controls[0]
    assert row.outer == pytest.approx(0.8)
    assert len(row.rest.vertices) > 8, "stops"
    middle = np.linalg.norm(base_points(obj), axis=1) < 0.2
    assert np.allclose(evaluated_points(obj)[middle, 2], 0.8, atol=1e-4)
    assert len(obj.sinew.deformers) == 1
    assert bpy.ops.sinew.tool_drag(path=way[::-1], radius=0.8) == {"FINISHED"}
    assert len(obj.sinew.active.controls) == 2, "a second drag is another tool of the same deformer"


def test_wrong_reaches_are_refused_by_name() -> None:
    obj = grid_object()
    row = add(obj, "drag")
    name = row.object.name
    row.inner = row.outer + 1.0
    update()
    assert f"{name}: Outer must be larger than Inner" in obj.sinew.active.status
    row.inner = -0.5
    update()
    assert f"{name}: Inner must not be negative for a Drag" in obj.sinew.active.status
    row.tools = "bend"
    update()
    assert obj.sinew.active.status_level == "INFO", obj.sinew.active.status


def test_a_tool_of_no_size_is_refused_by_name_and_one_scaled_to_nothing_later_is_not_a_crash() -> None:
    obj = grid_object()
    tool = linked(bpy.data.objects.new("Flat", None))
    tool.scale = (1.0, 1.0, 0.0)
    press(obj, "tool_add", control="Flat")
    assert "Flat is flat" in obj.sinew.active.status
    tool.scale = (1.0, 1.0, 1.0)
    press(obj, "unbind")
    assert bpy.ops.sinew.bind() == {"FINISHED"}
    tool.scale = (0.0, 0.0, 0.0)
    tool.location.z = 0.3
    assert np.isfinite(evaluated_points(obj)).all()


def test_lengths_are_those_of_the_tool() -> None:
    """A larger tool reaches farther, wherever the target is."""
    obj = grid_object(cells=20)
    obj.scale = (2.0, 2.0, 2.0)
    tool = linked(bpy.data.objects.new("Tool", None))
    tool.scale = (3.0, 3.0, 3.0)
    press(obj, "tool_add", control="Tool", outer=0.5)
    row = obj.sinew.active.controls[0]
    row.inner = 0.1
    tool.location.z = 0.4
    made = native().VectorField(1.5 * FRAME, inner=0.15, outer=0.75)
    made.bind(base_points(obj))
    shape = made.warp(1.5 * FRAME + (0.0, 0.0, 0.2))
    assert close(evaluated_points(obj), shape, INTEGRATED + FLOAT32)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Tools of vector fields: twist, bend and drag, their stored paths, and their animation."""

from __future__ import annotations

from pathlib import Path

import bpy
import numpy as np
import pytest
from inside import native
from mathutils import Matrix
from rigs import rig as scenes
from rigs.cages import fine_box
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
    scenes.press(obj, "tool_add", tool=tool, location=obj.location)
    scenes.make_active(obj)
    row = obj.sinew.active.controls[-1]
    for name, value in reach.items():
        setattr(row, name, value)
    scenes.update()
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
            scenes.press(obj, "tool_stop")
    posed = np.concatenate([scenes.apply_matrix(stop, FRAME) for stop in stops])
    expected = straight(scenes.base_points(obj), posed, tools=tool, **reach)
    assert scenes.close(scenes.evaluated_points(obj), expected, INTEGRATED)
    assert np.abs(expected - scenes.base_points(obj)).max() > 0.3


STOPS = ((0.5, 0.0, 0.0), (0.5, 0.5, 0.2))
END = (0.0, 0.6, 0.4)


@pytest.fixture
def walked() -> tuple[bpy.types.Object, bpy.types.PropertyGroup]:
    """A plate, and the row of the tool that was dragged over it, from stop to stop."""
    obj = scenes.grid_object(cells=20)
    row = add(obj, "drag", inner=0.3, outer=0.9)
    for place in STOPS:
        row.object.location = place
        scenes.press(obj, "tool_stop")
    row.object.location = END
    return obj, row


def is_on_path(obj: bpy.types.Object, *places) -> bool:
    """It shows what a tool on this path makes of it."""
    frames = np.concatenate([FRAME + place for place in places])
    return scenes.close(
        scenes.evaluated_points(obj),
        straight(scenes.base_points(obj), frames, inner=0.3, outer=0.9),
        INTEGRATED,
    )


def test_the_path_is_stored_and_a_frame_depends_on_it_alone(walked, tmp_path: Path) -> None:
    obj, _row = walked
    shape = scenes.evaluated_points(obj)
    assert is_on_path(obj, *STOPS, END)
    scenes.reopen(tmp_path / "path.blend")
    obj = bpy.data.objects["Plate"]
    assert scenes.close(scenes.evaluated_points(obj), shape)
    tool = obj.sinew.active.controls[0].object
    tool.location = (0.0, 0.0, 3.0)  # another way to the same place changes nothing
    scenes.update()
    tool.location = END
    assert scenes.close(scenes.evaluated_points(obj), shape)
    scenes.press(obj, "tool_stop", clear=True)
    assert is_on_path(obj, END)
    assert not scenes.close(scenes.evaluated_points(obj), shape, 0.02), "the way counts"


def test_progress_goes_along_the_path(walked) -> None:
    obj, row = walked
    stations = np.array([(0.0, 0.0, 0.0), *STOPS, END])
    ways = np.linalg.norm(np.diff(stations, axis=0), axis=1)
    half, middle = ways[0] + 0.5 * ways[1], 0.5 * (stations[1] + stations[2])
    paths = {0.0: stations[:1], ways[0]: stations[1:2], half: (stations[1], middle), ways.sum(): stations[1:]}
    for way, places in paths.items():
        row.progress = way / ways.sum()
        assert is_on_path(obj, *places), way


def test_progress_and_tools_can_be_keyed() -> None:
    obj = scenes.grid_object(cells=20)
    row = add(obj, "drag", inner=0.3, outer=0.9)
    scenes.key(row, {1: {"progress": 0.0}, 11: {"progress": 1.0}})
    scenes.key(row.object, {1: {"location": (0.6, 0.0, 0.0)}, 21: {"location": (0.6, 0.0, 0.5)}}, linear=True)
    for frame, place in ((1, (0.0, 0.0, 0.0)), (11, (0.6, 0.0, 0.25)), (21, (0.6, 0.0, 0.5))):
        bpy.context.scene.frame_set(frame)
        assert is_on_path(obj, place), frame


def test_a_drag_from_a_script_leaves_a_path() -> None:
    obj = scenes.grid_object(cells=20)
    scenes.make_active(obj)
    way = stroke_through([(0.0, 0.0, 0.1 * k) for k in range(9)])
    assert bpy.ops.sinew.tool_drag(path=way, radius=0.8) == {"FINISHED"}
    row = obj.sinew.active.controls[0]
    assert row.outer == pytest.approx(0.8)
    assert len(row.rest.vertices) > 8, "stops"
    middle = np.linalg.norm(scenes.base_points(obj), axis=1) < 0.2
    assert np.allclose(scenes.evaluated_points(obj)[middle, 2], 0.8, atol=1e-4)
    assert len(obj.sinew.deformers) == 1
    assert bpy.ops.sinew.tool_drag(path=way[::-1], radius=0.8) == {"FINISHED"}
    assert len(obj.sinew.active.controls) == 2, "a second drag is another tool of the same deformer"


def test_wrong_reaches_are_refused_by_name() -> None:
    obj = scenes.grid_object()
    row = add(obj, "drag")
    for inner, tool, said in (
        (row.outer + 1.0, "drag", "Outer must be larger than Inner"),
        (-0.5, "drag", "Inner must not be negative for a Drag"),
        (-0.5, "bend", ""),
    ):
        row.inner, row.tools = inner, tool
        scenes.update()
        assert f"{row.object.name}: {said}" in obj.sinew.active.status or not said
        assert (obj.sinew.active.status_level == "INFO") is (not said), obj.sinew.active.status


def test_a_tool_of_no_size_is_refused_by_name_and_one_scaled_to_nothing_later_is_not_a_crash() -> None:
    obj, tool = scenes.grid_object(), scenes.new_empty("Flat")
    tool.scale.z = 0.0
    scenes.press(obj, "tool_add", control="Flat")
    assert "Flat is flat" in obj.sinew.active.status
    tool.scale.z = 1.0
    scenes.press(obj, "unbind")
    scenes.press(obj, "bind")
    tool.scale, tool.location.z = (0.0, 0.0, 0.0), 0.3
    assert np.isfinite(scenes.evaluated_points(obj)).all()


def test_lengths_are_those_of_the_tool() -> None:
    """A larger tool reaches farther, wherever the target is."""
    obj = scenes.grid_object(cells=20)
    obj.scale = (2.0, 2.0, 2.0)
    tool = scenes.new_empty("Tool")
    tool.scale = (3.0, 3.0, 3.0)
    scenes.press(obj, "tool_add", control="Tool", outer=0.5)
    row = obj.sinew.active.controls[0]
    row.inner = 0.1
    tool.location.z = 0.4
    made = native().VectorField(1.5 * FRAME, inner=0.15, outer=0.75)
    made.bind(scenes.base_points(obj))
    shape = made.warp(1.5 * FRAME + (0.0, 0.0, 0.2))
    assert scenes.close(scenes.evaluated_points(obj), shape, INTEGRATED + scenes.FLOAT32)

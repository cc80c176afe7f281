# SPDX-License-Identifier: GPL-3.0-or-later
"""Controls as they are made: how far they reach, what is drawn of that, and the numbers in the sidebar."""

from collections.abc import Callable

import bpy
import numpy as np
import pytest
from inside import inner
from mathutils import Euler, Matrix, Vector
from rigs.cages import ball
from rigs.rig import add_group, base_points, make_active, press, update
from rigs.rig_of_curves import polyline, stroke_through
from test_drag import drag

BIG, SMALL = 4.0, 0.4  # the longest sides of the two parts of a mesh
CENTRE = np.array((5.0, 0.0, 0.0))  # of the small part


@pytest.fixture
def head() -> bpy.types.Object:
    """A large ball with a small one beside it, as one mesh."""
    parts = [ball("Head", 3), ball("Beside", 3)]
    for part, size, place in zip(parts, (BIG, SMALL), (Vector(), Vector(CENTRE)), strict=True):
        reach = np.abs(base_points(part)).max()
        part.data.transform(Matrix.Translation(place) @ Matrix.Scale(0.5 * size / reach, 4))
    make_active(*parts)
    bpy.ops.object.join()
    return parts[0]


def stroke(length: float, middle: np.ndarray) -> list[dict[str, object]]:
    return stroke_through(middle + np.outer(np.linspace(-0.5, 0.5, 20), (0.0, length, 0.0)))


@pytest.mark.parametrize("scale", [1.0, 0.01])
@pytest.mark.parametrize(
    ("length", "middle", "radius"),
    [
        (0.4, np.array((0.0, 0.0, 2.0)), 0.35 * 0.4),
        (3.0, np.array((0.0, 0.0, 2.0)), 0.15 * BIG),
        (0.3, CENTRE, 0.15 * SMALL),
    ],
)
def test_a_wire_reaches_as_its_stroke_and_its_part_ask_for(
    head: bpy.types.Object, length: float, middle: np.ndarray, radius: float, scale: float
):
    head.scale = (scale,) * 3
    update()
    assert bpy.ops.sinew.wire_draw(stroke=stroke(scale * length, scale * middle)) == {"FINISHED"}
    (row,) = head.sinew.active.controls
    assert row.radius * row.object.matrix_world.median_scale == pytest.approx(scale * radius, rel=0.05)


def test_each_of_several_curves_gets_a_radius_of_its_own(head: bpy.types.Object):
    lengths = {"Short": 0.3, "Long": 0.9}
    curves = [
        polyline(np.array([(0.0, end * length, 2.0) for end in (-0.5, 0.5)]), name)
        for name, length in lengths.items()
    ]
    make_active(head, *curves)
    assert bpy.ops.sinew.wire_add(source="CURVES") == {"FINISHED"}
    found = {row.object.name: row.radius for row in head.sinew.active.controls}
    assert found == pytest.approx({name: 0.35 * length for name, length in lengths.items()}, rel=0.01)


@pytest.mark.parametrize(("place", "size"), [((0.0, 0.0, 2.0), BIG), (tuple(CENTRE), SMALL)])
def test_a_field_reaches_as_the_part_asks_for(head: bpy.types.Object, place: tuple, size: float):
    bpy.context.scene.cursor.location = place
    for act in (
        lambda: bpy.ops.sinew.tool_add(tool="drag"),
        lambda: bpy.ops.sinew.tool_drag(path=stroke(0.1, np.array(place))),
    ):
        make_active(head)
        assert act() == {"FINISHED"}
        assert head.sinew.active.controls[-1].outer == pytest.approx(size / 3.0, rel=1e-3)


def test_the_rings_of_the_active_control_are_as_large_as_it_reaches(head: bpy.types.Object):
    middle = np.array((0.0, 0.0, 2.0))

    def radii() -> list[float]:
        update()
        rings = inner.reach.rings(head.sinew.active.controls[-1], bpy.context.evaluated_depsgraph_get())
        return [float(np.linalg.norm(line - middle, axis=1).mean()) for line in rings]

    bpy.ops.sinew.wire_draw(stroke=stroke(0.4, middle), points=0)
    assert radii() == pytest.approx([0.14], rel=0.1)
    press(head, "tool_add", tool="drag", location=middle, outer=0.8)
    assert radii() == pytest.approx([0.2] * 3 + [0.8] * 3, rel=1e-4)
    head.sinew.active.controls[-1].object.scale = (2.0, 2.0, 2.0)
    assert radii() == pytest.approx([0.4] * 3 + [1.6] * 3, rel=1e-4)


def _handles(obj: bpy.types.Object) -> None:
    bpy.ops.sinew.deformer_add(method="arap")
    for name in ("One", "Two"):
        press(obj, "handle_add", kind="HANDLE", vertex_group=name)


def _handle_beside_a_moved_one(obj: bpy.types.Object) -> None:
    bpy.ops.sinew.deformer_add(method="arap")
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="One")
    bpy.context.object.rotation_euler = (0.2, 0.3, 0.1)
    press(obj, "handle_add", kind="HANDLE", vertex_group="Two")


def _point(obj: bpy.types.Object) -> None:
    bpy.context.scene.cursor.location = (0.3, 0.2, 0.1)
    bpy.ops.sinew.point_add(source="CURSOR")


def _drag(obj: bpy.types.Object) -> None:
    place = obj.matrix_world @ obj.data.vertices[0].co
    drag(place.x, place.y, 50.0, value=(0.0, 0.0, 0.0), method="inverse_ffd")


def _tool(obj: bpy.types.Object) -> None:
    for tool in ("drag", "twist", "bend"):
        press(obj, "tool_add", tool=tool)


MAKERS: dict[str, Callable[[bpy.types.Object], object]] = {
    "handles": _handles,
    "handles beside a moved one": _handle_beside_a_moved_one,
    "point at the cursor": _point,
    "point under the mouse": _drag,
    "tools": _tool,
    "wire": lambda obj: bpy.ops.sinew.wire_draw(stroke=stroke(1.0, np.array(obj.location))),
    "cage": lambda obj: bpy.ops.sinew.cage_add(),
    "lattice": lambda obj: bpy.ops.sinew.lattice_add(),
}


@pytest.mark.parametrize("turned", [False, True])
@pytest.mark.parametrize("maker", MAKERS)
def test_a_fresh_control_shows_no_minus_zero(maker: str, turned: bool):
    """A number that the sidebar rounds to 0 is 0."""
    obj = ball("Ball", 2)
    add_group(obj, "One", lambda point: point[1] > 0.3)
    add_group(obj, "Two", lambda point: point[1] < -0.3)
    if turned:
        obj.matrix_world = Matrix.LocRotScale((0.0, 7.3, -2.1), Euler((0.3, -0.2, 0.5)), (1.0, 1.0, 1.0))
    make_active(obj)
    before = set(bpy.data.objects)
    MAKERS[maker](obj)
    update()
    made = [other for other in bpy.data.objects if other not in before and other.users_scene]
    assert made
    for other in made:
        for value in (*other.location, *other.rotation_euler, *(1.0 - size for size in other.scale)):
            assert abs(value) >= 5e-7 or str(value) == "0.0", (other.name, value)

# SPDX-License-Identifier: GPL-3.0-or-later
"""How far from the final shape the last preview of a drag is, and the first shape that follows.

    blender -b --factory-startup -P benchmarks/first_shape.py -- [MESH...]

MESH are .obj and .off files; four models are made here, one of them from the largest file. One end of each is
dragged and turned in twelve steps, as in a window, by `arap`. The rows give the largest distance of a vertex
from its place in the final shape, in per cent of the largest side of the box around the model.
"""

import math
import sys
import time
from pathlib import Path

import bpy
import numpy as np
import pytest

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests" / "blender" / "support")]

from inside import catch_up, dragging, inner  # noqa: E402
from installed import enable  # noqa: E402
from mathutils import Matrix  # noqa: E402
from rigs.rig import evaluated_points, make_active, new_file, update  # noqa: E402

STEPS = 12
ENDS = 0.15  # of the longest side: how deep the handle and the fixed region are
TURN, SHIFT = math.radians(60.0), 0.3  # of the whole drag; the shift relative to the longest side


def read(file: Path) -> bpy.types.Object:
    """A triangle or polygon mesh."""
    if file.suffix == ".off":
        words = iter(file.read_text(encoding="utf-8").split()[1:])
        counts = [int(next(words)) for _ in range(3)]
        points = [[float(next(words)) for _ in range(3)] for _ in range(counts[0])]
        faces = [[int(next(words)) for _ in range(int(next(words)))] for _ in range(counts[1])]
    else:
        lines = [line.split() for line in file.read_text(encoding="utf-8").splitlines()]
        points = [[float(word) for word in line[1:4]] for line in lines if line[:1] == ["v"]]
        faces = [[int(w.split("/")[0]) - 1 for w in line[1:]] for line in lines if line[:1] == ["f"]]
    mesh = bpy.data.meshes.new(file.stem)
    mesh.from_pydata(points, [], faces)
    return added(bpy.data.objects.new(file.stem, mesh))


def added(obj: bpy.types.Object) -> bpy.types.Object:
    bpy.context.scene.collection.objects.link(obj)
    make_active(obj)
    return obj


def applied(obj: bpy.types.Object, kind: str, **settings: object) -> bpy.types.Object:
    """With one of Blender's modifiers applied."""
    modifier = obj.modifiers.new(kind, kind)
    for name, value in settings.items():
        setattr(modifier, name, value)
    make_active(obj)
    bpy.ops.object.modifier_apply(modifier=modifier.name)
    return obj


def suzanne() -> bpy.types.Object:
    bpy.ops.mesh.primitive_monkey_add()
    return applied(bpy.context.object, "SUBSURF", levels=3)


def text() -> bpy.types.Object:
    curve = bpy.data.curves.new("Text", "FONT")
    curve.body, curve.extrude, curve.bevel_depth = "Sinew", 0.1, 0.02
    added(bpy.data.objects.new("Text", curve))
    bpy.ops.object.convert(target="MESH")
    return bpy.context.object


def remeshed() -> bpy.types.Object:
    return named("Suzanne, remeshed", applied(suzanne(), "REMESH", voxel_size=0.03))


def decimated(file: Path) -> bpy.types.Object:
    return named(f"{file.stem}, decimated", applied(read(file), "DECIMATE", ratio=0.1))


def named(name: str, obj: bpy.types.Object) -> bpy.types.Object:
    obj.name = name
    return obj


def rig(obj: bpy.types.Object) -> bpy.types.Object:
    """Regions at both ends of the longest side, bound; the control."""
    points = np.array([vertex.co for vertex in obj.data.vertices])
    axis = int(np.ptp(points, axis=0).argmax())
    place = (points[:, axis] - points[:, axis].min()) / np.ptp(points[:, axis])
    for name, kind, members in (
        ("Held", "FIXED", np.flatnonzero(place < ENDS)),
        ("Moved", "HANDLE", np.flatnonzero(place > 1.0 - ENDS)),
    ):
        obj.vertex_groups.new(name=name).add(members.tolist(), 1.0, "REPLACE")
        make_active(obj)
        bpy.ops.sinew.handle_add(kind=kind, vertex_group=name)
    make_active(obj)
    obj.sinew.active.method = "arap"
    bpy.ops.sinew.bind()
    return next(row.control for row in obj.sinew.active.handles if row.kind == "HANDLE")


def measure(obj: bpy.types.Object) -> str:
    control = rig(obj)
    size = float(np.ptp([vertex.co for vertex in obj.data.vertices], axis=0).max())
    start = control.matrix_world.copy()
    shapes = [evaluated_points(obj)]
    with dragging(), pytest.MonkeyPatch.context() as patch:
        heavy = inner.binding
        patch.setattr(heavy, "may_wait", lambda seconds: seconds >= heavy.HEAVY)  # as in a window
        for step in range(1, STEPS + 1):
            part = step / STEPS
            turn = Matrix.Rotation(TURN * part, 4, (0.3, 1.0, 0.2))
            control.matrix_world = Matrix.Translation((0.0, SHIFT * size * part, 0.0)) @ start @ turn
            update()
            shown(obj, shapes)
            time.sleep(0.02)
            inner.housekeeping.collect()
            update()
            shown(obj, shapes)
        for _ in range(2):  # the hand rests: a thread answers for an earlier step, and then for this one
            work = inner.sessions.find(obj.sinew.active.uid).work
            if work is not None:
                work.thread.join()
                inner.housekeeping.collect()
                update()
                shown(obj, shapes)
        released = len(shapes) - 1
        begin = time.monotonic()
        while catch_up() or inner.sessions.unsettled():
            update()
            shown(obj, shapes)
            time.sleep(0.002)
        waited = time.monotonic() - begin
    final = shapes[-1]
    first = shapes[min(released + 1, len(shapes) - 1)]
    off = [
        100.0 * float(np.linalg.norm(shape - final, axis=1).max()) / size
        for shape in (shapes[released], first)
    ]
    return f"| {obj.name} | {len(final):,} | {off[0]:.2g} | {off[1]:.2g} | {waited:.2f} |"


def shown(obj: bpy.types.Object, shapes: list[np.ndarray]) -> None:
    """Note what is shown, where that is another shape."""
    points = evaluated_points(obj)
    if not np.array_equal(points, shapes[-1]):
        shapes.append(points)


def main() -> None:
    files = [Path(word) for word in sys.argv[sys.argv.index("--") + 1 :]]
    makers = [*(lambda file=file: read(file) for file in files), suzanne, text, remeshed]
    if files:
        largest = max(files, key=lambda file: file.stat().st_size)
        makers.append(lambda: decimated(largest))
    enable()
    print("| model | vertices | last preview, % of the box | first shape after it, % | after seconds |")
    print("|---|---|---|---|---|")
    for make in makers:
        new_file()
        print(measure(make()), flush=True)


main()

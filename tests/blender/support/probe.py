# SPDX-License-Identifier: GPL-3.0-or-later
"""A render engine that draws nothing and records the shapes that it is given."""

from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
from rigs.rig import coordinates, make_active, points_of


class Probe(bpy.types.RenderEngine):
    """Notes the points of every shape, at the frame itself or at ``subframes`` as motion blur does"""

    bl_idname = "SINEW_TEST_PROBE"
    bl_label = "Probe"
    subframes: tuple[float, ...] = (0.0,)
    seen: list[dict[str, np.ndarray]] = []
    frames: list[int] = []
    at_work: Callable[[], None] | None = None  # called in each frame, before the shapes are read
    noting: Callable[[bpy.types.Depsgraph], None] | None = None  # called with what each frame renders

    def render(self, depsgraph: bpy.types.Depsgraph) -> None:
        if Probe.at_work is not None:
            Probe.at_work()
        if Probe.noting is not None:
            Probe.noting(depsgraph)
        frame = depsgraph.scene.frame_current
        for subframe in self.subframes:
            if self.subframes != (0.0,):
                self.frame_set(frame, subframe)
            self.frames.append(frame)
            self.seen.append({obj.name: _points(obj) for obj in depsgraph.objects if obj.type in _SHAPES})
        if self.subframes != (0.0,):
            self.frame_set(frame, 0.0)  # an engine leaves the scene where it was
        self.end_result(self.begin_result(0, 0, *_size(depsgraph.scene)))


_SHAPES = ("MESH", "CURVE", "FONT", "CURVES", "POINTCLOUD", "LATTICE")


def _points(obj: bpy.types.Object) -> np.ndarray:
    return coordinates(obj.data.vertices) if obj.type == "MESH" else points_of(obj)


def _size(scene: bpy.types.Scene) -> tuple[int, int]:
    share = scene.render.resolution_percentage / 100.0
    return int(scene.render.resolution_x * share), int(scene.render.resolution_y * share)


def render(scene=None, layer="", subframes=(0.0,), animation=False) -> list[dict[str, np.ndarray]]:
    """Render; points by object name, object space, one dictionary a (sub)frame."""
    scene = scene or bpy.context.scene
    if scene.camera is None:
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(scene.camera)
    scene.render.resolution_x = scene.render.resolution_y = 8
    scene.render.resolution_percentage = 100
    scene.render.filepath = bpy.app.tempdir + "probe"
    engine, scene.render.engine = scene.render.engine, Probe.bl_idname
    Probe.seen, Probe.frames, Probe.subframes = [], [], subframes
    try:
        bpy.ops.render.render(animation=animation, scene=scene.name, layer=layer)
    finally:
        scene.render.engine = engine
    return Probe.seen


def render_points(obj: bpy.types.Object) -> np.ndarray:
    """What a render of this frame shows of the object, object space, (n, 3)."""
    return render()[-1][obj.name]


def exported_points(obj: bpy.types.Object, folder: Path) -> np.ndarray:
    """What an exporter of Blender's own writes of the object as renders show it, world space, (n, 3)."""
    make_active(obj)
    path = folder / "rendered.obj"
    bpy.ops.wm.obj_export(
        filepath=str(path),
        export_selected_objects=True,
        export_eval_mode="DAG_EVAL_RENDER",
        export_materials=False,
        forward_axis="Y",
        up_axis="Z",
    )
    lines = path.read_text(encoding="utf-8").splitlines()
    return np.array([[float(word) for word in line.split()[1:4]] for line in lines if line.startswith("v ")])


bpy.utils.register_class(Probe)

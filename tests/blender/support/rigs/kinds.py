# SPDX-License-Identifier: GPL-3.0-or-later
"""One rig per kind of control and target, with equal functions: what every event is tested on."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path

import bpy
import numpy as np
from expected import Expected, ExpectedInCage, Poses
from mathutils import Matrix
from probe import render_points
from registry import BY_ID, WITH_CAGE, WITH_HANDLES, Control

from rigs import point_handles, point_objects, rig as scenes
from rigs.cages import TURN, ball
from rigs.object_rigs import object_class


class HandleRig(scenes.Rig):
    """A plate with a handle and a fixed edge; ``poses`` is what to see, ``height`` how far it is lifted."""

    height = 0.0
    methods = WITH_HANDLES
    tolerance = scenes.FLOAT32
    goes_on = True  # another control takes over where the one before left the shape; else it is to be bound
    counts_in_no_scene = True  # a control that is in no scene moves the shape; else the last one stays
    hidden_meshes = 4  # what entered at bind, and in renders; two shapes
    point_arrays = 0  # how many arrays Blender has the points of the control in, where these count
    carries = Matrix.Translation((0.3, -0.2, 0.7))

    @classmethod
    def new(cls, name: str = "Plate") -> HandleRig:
        return cls(scenes.grid_object(name))

    @classmethod
    def large(cls, cells: int = 60) -> HandleRig:
        """One whose bind needs 0.11 MB or more: a thousand times that where handles are many points."""
        return cls(scenes.grid_object(cells=cells))

    @property
    def control_size(self) -> int:
        """The size of the control of a space method, as the registry counts it."""
        return len(self.top) + len(self.base)

    @staticmethod
    def control_of(obj: bpy.types.Object) -> bpy.types.Object:
        """The control of the first deformer of any object."""
        return obj.sinew.deformers[0].handles[0].control

    @staticmethod
    def set_control(obj: bpy.types.Object, control: bpy.types.Object | None) -> None:
        obj.sinew.deformers[0].handles[0].control = control

    @staticmethod
    def another_control(obj: bpy.types.Object) -> bpy.types.Object:
        """One that was not the control of anything."""
        return scenes.new_empty("Another")

    @staticmethod
    def control_is_missing(obj: bpy.types.Object) -> bool:
        return obj.sinew.deformers[0].handles[0].control_missing

    @classmethod
    def lift_of(cls, obj: bpy.types.Object, height: float) -> None:
        """Move the control of any object along the world's z."""
        scenes.move_world(cls.control_of(obj), Matrix.Translation((0.0, 0.0, height)))

    def lift(self, height: float = 1.0) -> None:
        super().lift(height)
        self.height += height

    def lift_to(self, height: float) -> None:
        self.lift(height - self.height)

    @staticmethod
    def unmoved(obj: bpy.types.Object) -> np.ndarray:
        """What it would show without modifiers, (n, 3)."""
        return scenes.base_points(obj)

    def shows(self, shape: np.ndarray, obj: bpy.types.Object | None = None, tolerance: float = 0.0) -> bool:
        """That is what Blender shows of the rig, or of another object of its kind."""
        return scenes.close(scenes.evaluated_points(obj or self.obj), shape, max(tolerance, self.tolerance))

    def shows_in(self, scene, shape: np.ndarray, obj=None, tolerance: float = 0.0) -> bool:
        """So does any view layer, or the first one of any scene."""
        layer = scene.view_layers[0] if isinstance(scene, bpy.types.Scene) else scene
        found = scenes.points_of((obj or self.obj).evaluated_get(layer.depsgraph))
        return scenes.close(found, shape, max(tolerance, self.tolerance))

    def renders(self, shape: np.ndarray, tolerance: float = 0.0) -> bool:
        """So does a render of this frame."""
        return scenes.close(render_points(self.obj), shape, max(tolerance, self.tolerance))

    def at(self, height: float) -> np.ndarray:
        """What to see with the control at a height."""
        return self.poses.lifted(height)

    def now(self, obj: bpy.types.Object | None = None, incoming: np.ndarray | None = None) -> np.ndarray:
        """What to see of it, or of a copy, with its control where it is."""
        obj = obj or self.obj
        return self.poses.now(obj, self.control_of(obj), incoming)

    def is_right(self, tolerance: float = 0.0) -> bool:
        """It shows the pose of its control."""
        return self.shows(self.at(self.height), tolerance=tolerance)

    def is_at_rest(self) -> bool:
        return self.shows(self.rest())

    def press(self, operator: str, **keywords: object) -> None:
        """A button of ours, with the target active."""
        scenes.press(self.obj, operator, **keywords)

    @property
    def held(self) -> np.ndarray:
        """The points that follow the control exactly."""
        return self.top

    def bind_alone(self, method: str) -> None:
        """One control alone holds the shape."""
        self.bind(method, fixed=False)

    def bind_at_rest(self, method: str) -> None:
        """Nothing is posed."""
        self.bind(method)

    def attach(self, method: str) -> None:
        """Nothing is posed, and a refusal of the bind is in the status."""
        self.bind_at_rest(method)

    def relax(self) -> None:
        """Make the control as it was when it was made, for a bind that starts from there."""

    def expected(self, method: str | None = None, **options: object) -> Poses:
        """What to see at each pose of the control. Made while it is at rest."""
        return Expected.of_rig(self, method or self.methods[0], **options)

    def start(self, method: str | None = None) -> HandleRig:
        """Bind, by the operators."""
        self.bind(method or self.methods[0])
        self.poses, self.height = self.expected(method), 0.0
        return self

    def change_topology(self) -> None:
        """In Edit Mode, as a user does: four faces from one."""
        scenes.on_all(self.obj, bpy.ops.mesh.subdivide)


class CageRig(object_class(HandleRig)):
    """A ball in a cage that is bent as no affine map does it."""

    methods = WITH_CAGE
    point_arrays = 1
    carries = TURN

    @classmethod
    def new(cls, name: str = "Ball") -> CageRig:
        return cls(ball(name, 2), 0.3)

    @classmethod
    def large(cls) -> CageRig:
        return cls(ball(levels=6), 0.3)

    @property
    def control_size(self) -> int:
        return sum(len(face.vertices) - 2 for face in self.control.data.polygons)

    def bind(self, method: str = WITH_CAGE[0], **_keywords: object) -> CageRig:
        self.bind_at_rest(method)
        self._cage_rest = scenes.base_points(self.control)
        point_objects.bend(self.control)
        return self

    def attach(self, method: str) -> None:
        point_objects.attach(self.obj, method)

    def relax(self) -> None:
        super().relax()
        self.control.data.vertices.foreach_set("co", self._cage_rest.astype(np.float32).ravel())
        self.control.data.update()

    def expected(self, method: str | None = None, **options: object) -> Poses:
        method, cage = method or self.methods[0], self.control
        return ExpectedInCage(self.obj, cage, self._cage_rest, method, point_objects.moved_by_hand, **options)


class CurveRig(CageRig):
    """Bezier splines in such a cage: it moves their points and handles."""

    tolerance = point_objects.TESSELLATED

    @classmethod
    def new(cls, name: str = "Curve") -> CurveRig:
        obj = point_objects.bezier()
        obj.name = name
        return cls.called(name)

    @staticmethod
    def unmoved(obj: bpy.types.Object) -> np.ndarray:
        return point_objects.unmoved(obj)

    def change_topology(self) -> None:
        scenes.on_all(self.obj, bpy.ops.curve.subdivide)


RIGS = {
    "handles": HandleRig,
    "points of an object": point_handles.new_class(HandleRig),
    "cage": CageRig,
    "curve in a cage": CurveRig,
}
BY_CONTROL = {Control.HANDLES: HandleRig, Control.CAGE: CageRig}
for _control in Control:  # another kind of control has its rig in a module of its own
    if (Path(__file__).parent / f"rig_of_{_control.name.lower()}.py").is_file():
        BY_CONTROL[_control] = import_module(f"rigs.rig_of_{_control.name.lower()}").new_class(HandleRig)
        RIGS[_control.name.lower()] = BY_CONTROL[_control]


def rig_for(method: str) -> HandleRig:
    """A new rig of the kind of control that steers the method. A control without one here is untested."""
    return BY_CONTROL[BY_ID[method].control].new()

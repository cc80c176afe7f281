# SPDX-License-Identifier: GPL-3.0-or-later
"""One rig per kind of control and target, with equal functions: what every event is tested on."""

from __future__ import annotations

import bpy
import numpy as np
import point_objects
from cages import ball
from expected import Expected, ExpectedInCage, Poses
from mathutils import Matrix
from registry import BY_ID, WITH_CAGE, WITH_HANDLES, Control
from rig import FLOAT32, Rig, base_points, close, grid_object, make_active, move_world


class HandleRig(Rig):
    """A plate whose far edge is a handle and whose near edge is fixed."""

    methods = WITH_HANDLES
    tolerance = FLOAT32
    goes_on = (
        True  # another control takes over where the one before it left the shape; else it is to be bound
    )
    counts_in_no_scene = True  # a control that is in no scene moves the shape; else the last one stays
    hidden_meshes = 4  # what entered at bind, and in renders; two shapes
    carries = Matrix.Translation((0.3, -0.2, 0.7))

    @classmethod
    def new(cls, name: str = "Plate") -> HandleRig:
        return cls(grid_object(name))

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
        control = bpy.data.objects.new("Another", None)
        bpy.context.scene.collection.objects.link(control)
        return control

    @staticmethod
    def control_is_missing(obj: bpy.types.Object) -> bool:
        return obj.sinew.deformers[0].handles[0].control_missing

    @classmethod
    def lift_of(cls, obj: bpy.types.Object, height: float) -> None:
        """Move the control of any object along the world's z."""
        move_world(cls.control_of(obj), Matrix.Translation((0.0, 0.0, height)))

    @staticmethod
    def shown(obj: bpy.types.Object) -> np.ndarray:
        """What Blender shows of any object of this kind, (n, 3)."""
        return point_objects.shown(obj)

    def points_in(self, layer: bpy.types.ViewLayer, obj: bpy.types.Object | None = None) -> np.ndarray:
        """What a view layer, of any scene, shows of the rig or of another object, (n, 3)."""
        evaluated = (obj or self.obj).evaluated_get(layer.depsgraph)
        points = np.array([vertex.co[:] for vertex in evaluated.to_mesh().vertices])
        evaluated.to_mesh_clear()
        return points

    @staticmethod
    def unmoved(obj: bpy.types.Object) -> np.ndarray:
        """What it would show without modifiers, (n, 3)."""
        return base_points(obj)

    def shows(self, shape: np.ndarray, obj: bpy.types.Object | None = None, tolerance: float = 0.0) -> bool:
        """That is what Blender shows of the rig, or of another object of its kind."""
        return close(self.shown(obj or self.obj), shape, max(tolerance, self.tolerance))

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

    def relax(self) -> None:
        """Make the control as it was when it was made, for a bind that starts from there."""

    def expected(self, method: str | None = None, **options: object) -> Poses:
        """What to see at each pose of the control. Made while it is at rest."""
        return Expected.of_rig(self, method or self.methods[0], **options)

    def start(self, method: str | None = None) -> Poses:
        """Bind, by the operators; what to expect of it."""
        self.bind(method or self.methods[0])
        return self.expected(method)

    def change_topology(self) -> None:
        """In Edit Mode, as a user does: four faces from one."""
        make_active(self.obj)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.mesh.select_all(action="SELECT")
        bpy.ops.mesh.subdivide()
        bpy.ops.object.mode_set(mode="OBJECT")


class CageRig(HandleRig):
    """A ball in a cage that is bent as no affine map does it."""

    methods = WITH_CAGE
    goes_on = False
    counts_in_no_scene = False
    hidden_meshes = 5  # the cage at rest, too
    carries = (
        Matrix.Translation((0.3, 0.1, -0.2)) @ Matrix.Rotation(0.7, 4, (0.6, 0.0, 0.8)) @ Matrix.Scale(1.3, 4)
    )

    def __init__(self, obj: bpy.types.Object) -> None:
        self.name = obj.name

    @classmethod
    def new(cls, name: str = "Ball") -> CageRig:
        return cls(ball(name, 2))

    @staticmethod
    def control_of(obj: bpy.types.Object) -> bpy.types.Object:
        return obj.sinew.deformers[0].cage

    @staticmethod
    def set_control(obj: bpy.types.Object, control: bpy.types.Object | None) -> None:
        obj.sinew.deformers[0].cage = control

    @classmethod
    def another_control(cls, obj: bpy.types.Object) -> bpy.types.Object:
        control = cls.control_of(obj).copy()
        control.data = control.data.copy()
        control.name = "Another"
        bpy.context.scene.collection.objects.link(control)
        return control

    @staticmethod
    def control_is_missing(obj: bpy.types.Object) -> bool:
        return obj.sinew.deformers[0].cage_missing

    @property
    def control(self) -> bpy.types.Object:
        return self.deformer.cage

    @property
    def held(self) -> slice:
        return slice(None)

    def bind(self, method: str = WITH_CAGE[0]) -> CageRig:
        self.bind_at_rest(method)
        self._cage_rest = base_points(self.control)
        point_objects.bend(self.control)
        return self

    def bind_at_rest(self, method: str) -> None:
        point_objects.bind(self.obj, method)

    def bind_alone(self, method: str) -> None:
        self.bind(method)

    def relax(self) -> None:
        self.control.matrix_basis = Matrix.Identity(4)
        self.control.data.vertices.foreach_set("co", self._cage_rest.astype(np.float32).ravel())
        self.control.data.update()

    def rest(self) -> np.ndarray:
        return self.unmoved(self.obj)

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
        return cls(obj)

    def points(self) -> np.ndarray:
        return self.shown(self.obj)

    @staticmethod
    def unmoved(obj: bpy.types.Object) -> np.ndarray:
        return point_objects.unmoved(obj)

    def change_topology(self) -> None:
        make_active(self.obj)
        bpy.ops.object.mode_set(mode="EDIT")
        bpy.ops.curve.select_all(action="SELECT")
        bpy.ops.curve.subdivide()
        bpy.ops.object.mode_set(mode="OBJECT")


RIGS = {"handles": HandleRig, "cage": CageRig, "curve in a cage": CurveRig}
BY_CONTROL = {Control.HANDLES: HandleRig, Control.CAGE: CageRig}


def rig_for(method: str) -> HandleRig:
    """A new rig of the kind of control that steers the method. A control without one here is untested."""
    return BY_CONTROL[BY_ID[method].control].new()

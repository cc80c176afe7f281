# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing by the add-on's operators, keyframes of the controls, and the checks that every sample makes."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from math import radians
from types import ModuleType

import bpy
import numpy as np
from bpy.types import ID, Mesh, Object, PoseBone, PropertyGroup, bpy_prop_collection, bpy_struct
from mathutils import Euler, Matrix, Vector

from .studio import progress


class SampleError(RuntimeError):
    """A sample did not come out as it should."""


@dataclass(frozen=True)
class Move:
    """How a control has moved from its rest: turned about ``pivot``, then shifted."""

    shift: Sequence[float] = (0.0, 0.0, 0.0)
    turn: Sequence[float] = (0.0, 0.0, 0.0)  # degrees about x, y, z
    pivot: Sequence[float] = (0.0, 0.0, 0.0)

    def matrix(self) -> Matrix:
        about = Matrix.Translation(self.pivot)
        turn = Euler([radians(angle) for angle in self.turn]).to_matrix().to_4x4()
        return Matrix.Translation(self.shift) @ about @ turn @ about.inverted()


REST = Move()
POSE_FRAME = 40


def add_object(name: str, data: ID | None, parent: Object | None = None) -> Object:
    """A new object in the scene's collection; without data an empty."""
    obj = bpy.data.objects.new(name, data)
    obj.parent = parent
    bpy.context.scene.collection.objects.link(obj)
    return obj


def add_lines(name: str, lines: Iterable[Sequence[Sequence[float]]], bevel: float = 0.0) -> Object:
    """A curve object of lines through points (n, 3), as thick as ``bevel``."""
    data = bpy.data.curves.new(name, "CURVE")
    data.dimensions, data.bevel_depth = "3D", bevel
    for line in lines:
        spline = data.splines.new("POLY")
        spline.points.add(len(line) - 1)
        spline.points.foreach_set("co", np.column_stack((line, np.ones(len(line)))).ravel())
    return add_object(name, data)


def add_armature(
    name: str,
    bones: Iterable[tuple[str, Sequence[float], Sequence[float], str]],
    parent: Object | None = None,
    side: Sequence[float] | None = None,
) -> Object:
    """An armature of bones: name, head, tail, and the bone above. ``side`` is where their z axes point."""
    data = bpy.data.armatures.new(name)
    data.display_type = "STICK"
    rig = add_object(name, data, parent)
    make_active(rig)
    bpy.ops.object.mode_set(mode="EDIT")
    for bone, head, tail, above in bones:
        edit = data.edit_bones.new(bone)
        edit.head, edit.tail, edit.parent = head, tail, data.edit_bones.get(above)
        if side:
            edit.align_roll(Vector(side))
    bpy.ops.object.mode_set(mode="OBJECT")
    return rig


def make_active(obj: Object, *others: Object) -> None:
    """Select the object, and perhaps others, and nothing else."""
    for other in bpy.context.selected_objects:
        other.select_set(False)
    for each in (obj, *others):
        each.select_set(True)
    bpy.context.view_layer.objects.active = obj


def places(count: int, spacing: float) -> list[float]:
    """Where the objects of a row stand along x, about its middle."""
    return [(k - 0.5 * (count - 1)) * spacing for k in range(count)]


def line_up(
    first: Object, labels: Iterable[str], places: Iterable[float], heading: float = 0.0
) -> list[Object]:
    """The object and copies of it at places along x, one per label, each turned by ``heading`` degrees."""
    name, labels = first.name, list(labels)
    row = [first, *(first.copy() for _ in labels[1:])]
    for obj, label, x in zip(row, labels, places):
        obj.name = f"{name} {label}"
        obj.location.x = x
        obj.rotation_euler.z = radians(heading)
        if obj != first:
            bpy.context.scene.collection.objects.link(obj)
    bpy.context.view_layer.update()
    return row


def operate(obj: Object, operator: str, *others: Object, **options: object) -> PropertyGroup | None:
    """Call an operator of Sinew on the object, with others selected, too. Returns its last deformer."""
    make_active(obj, *others)
    expect(getattr(bpy.ops.sinew, operator)(**options), f"{obj.name}: {operator}({options})")
    return obj.sinew.deformers[-1] if obj.sinew.deformers else None


def expect(result: set[str], what: str) -> None:
    if result != {"FINISHED"}:
        raise SampleError(f"{what} answered {result}")


def set_parameters(deformer: PropertyGroup, parameters: Mapping[str, float | str]) -> None:
    for name, value in parameters.items():
        setattr(deformer.parameters, name, value)


def add_deformer(obj: Object, method: str, **parameters: float | str) -> PropertyGroup:
    """A Sinew deformer on the object, its parameters set by name."""
    progress(f"posing {obj.name} by {method}")
    deformer = operate(obj, "deformer_add", method=method)
    set_parameters(deformer, parameters)
    return deformer


def add_region(obj: Object, kind: str, group: str, **control: str) -> PropertyGroup:
    """A handle, fixed or support region from a vertex group. The operator also binds. A new empty moves a
    handle unless ``control`` names an object, ``control_object``, and its ``bone``."""
    return operate(obj, "handle_add", kind=kind, vertex_group=group, **control).handles[-1]


def add_cage(obj: Object, method: str, **options: float | str | bool) -> Object:
    """The cage of a new deformer: an automatic one, or with ``source="OBJECT"`` the named object."""
    progress(f"a cage around {obj.name}, {method}")
    return operate(obj, "cage_add", method=method, **options).cage


def subdivide(obj: Object, levels: int = 1, rendered: int = 2) -> None:
    smooth = obj.modifiers.new("Subdivision", "SUBSURF")
    smooth.levels, smooth.render_levels = levels, rendered


def share_cage(cage: Object, obj: Object, method: str) -> Object:
    """A cage of the same mesh around another object, so that both take every pose together."""
    twin = cage.copy()
    twin.name, twin.parent = f"{obj.name} Cage", obj
    twin.matrix_parent_inverse = cage.matrix_parent_inverse
    bpy.context.scene.collection.objects.link(twin)
    bpy.context.view_layer.update()
    return add_cage(obj, method, source="OBJECT", cage=twin.name)


def weigh(obj: Object, rig: Object) -> None:
    """Parent the object to the armature as Ctrl P, With Automatic Weights does."""
    make_active(rig, obj)
    bpy.context.view_layer.update()
    expect(bpy.ops.object.parent_set(type="ARMATURE_AUTO"), "parent_set(type='ARMATURE_AUTO')")


def carry_cage(cage: Object, rig: Object) -> None:
    """Parent the cage to the armature, which has to carry all of it from where it is."""
    bpy.context.view_layer.update()
    place = cage.matrix_world.translation.copy()
    weigh(cage, rig)
    bpy.context.view_layer.update()
    if (cage.matrix_world.translation - place).length > 1e-4:
        raise SampleError("The cage did not stay in its place")
    if any(not vertex.groups for vertex in cage.data.vertices):
        raise SampleError("The armature leaves vertices of the cage behind")


def add_lattice(obj: Object, resolution: Sequence[int], *others: Object, **parameters: float | str) -> Object:
    """The lattice of a new deformer, fitted to the object, and to others."""
    progress(f"a lattice around {obj.name}")
    deformer = operate(obj, "lattice_add", *others, resolution=resolution)
    set_parameters(deformer, parameters)
    return deformer.controls[0].object


def lattice_points(lattice: Object) -> np.ndarray:
    """The points (c, 3) as they are stored, object space."""
    return stored(lattice.data.points, "co_deform").astype(np.float64)


def key(owner: bpy_struct, name: str, values: Mapping[int, object]) -> None:
    """Keyframe a property: its value at each frame."""
    for frame, value in values.items():
        setattr(owner, name, value)
        owner.keyframe_insert(name, frame=frame)


def add_pose(cage: Object, name: str, points: np.ndarray, values: Mapping[int, float]) -> None:
    """Add a shape key with the cage vertices at ``points`` (c, 3); ``values`` is its strength per frame."""
    if cage.data.shape_keys is None:
        cage.shape_key_add(name="Rest")
    pose = cage.shape_key_add(name=name)
    pose.data.foreach_set("co", np.asarray(points, np.float32).ravel())
    key(pose, "value", values)


def blended(move: Move, points: np.ndarray, weights: np.ndarray) -> np.ndarray:
    """Points (n, 3), each moved as far as its weight says."""
    matrix = np.array(move.matrix())
    return points + weights[:, None] * (points @ matrix[:3, :3].T + matrix[:3, 3] - points)


def animate(control: Object, keys: Mapping[int, Move], frame_of: Object | None = None) -> None:
    """Keyframe a control: at each frame its move from where it stands now, in the space of ``frame_of``."""
    bpy.context.view_layer.update()
    rest = control.matrix_world.copy()
    control.rotation_mode = "QUATERNION"
    space = frame_of.matrix_world.copy() if frame_of else Matrix()
    previous = None
    for frame, move in sorted(keys.items()):
        control.matrix_world = space @ move.matrix() @ space.inverted() @ rest
        turn = control.rotation_quaternion.copy()
        if previous is not None:
            turn.make_compatible(previous)  # the short way round
        key(control, "location", {frame: control.location})
        key(control, "rotation_quaternion", {frame: turn})
        previous = turn


def key_turns(joint: PoseBone, keys: Mapping[int, Sequence[float]]) -> None:
    """Keyframe a bone: at each frame its turn in degrees about the axes of the armature."""
    joint.rotation_mode = "QUATERNION"
    axes = joint.bone.matrix_local.to_quaternion()
    turns = {frame: Move(turn=angles).matrix().to_quaternion() for frame, angles in keys.items()}
    key(joint, "rotation_quaternion", {frame: axes.inverted() @ turn @ axes for frame, turn in turns.items()})


def key_angles(joint: PoseBone, keys: Mapping[int, Sequence[float]]) -> None:
    """Keyframe a bone: at each frame its Euler angles in degrees."""
    joint.rotation_mode = "XYZ"
    key(joint, "rotation_euler", {frame: np.radians(angles) for frame, angles in keys.items()})


def vertices(obj: Object) -> np.ndarray:
    """The vertices (n, 3) as they are stored, object space."""
    return stored(obj.data.vertices, "co").astype(np.float64)


def shape(obj: Object) -> np.ndarray:
    """The vertices (n, 3) as the modifiers leave them, object space; points of a lattice or of hair."""
    shown = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    if obj.type == "LATTICE":
        return lattice_points(shown)
    if obj.type == "CURVES":
        return stored(shown.data.points, "position")
    points = stored(shown.to_mesh().vertices, "co")  # also of a curve or text
    shown.to_mesh_clear()
    return points


def shown_mesh(obj: Object) -> Mesh:
    """A copy of the mesh as the modifiers leave it at the current frame."""
    return bpy.data.meshes.new_from_object(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()))


def stored(points: bpy_prop_collection, name: str) -> np.ndarray:
    """Coordinates (n, 3) float32 of vertices or points."""
    flat = np.empty(3 * len(points), np.float32)
    points.foreach_get(name, flat)
    return flat.reshape(-1, 3)


def check_posed(obj: Object, rest_frame: int = 1, pose_frame: int = POSE_FRAME) -> None:
    """Stop the sample unless all deformers are bound without an error and the pose is finite and moves it."""
    for deformer in obj.sinew.deformers:
        if not deformer.is_bound or deformer.status_level in {"ERROR", "WARNING"}:
            why = deformer.status or "not bound"
            raise SampleError(f"{obj.name}: deformer {deformer.name!r} is not well: {why}")
    scene = bpy.context.scene
    shapes = []
    for frame in (rest_frame, pose_frame):
        scene.frame_set(frame)
        shapes.append(shape(obj))
        if not np.isfinite(shapes[-1]).all():
            raise SampleError(f"{obj.name}: frame {frame} is not finite")
    size = np.ptp(shapes[0], axis=0).max()
    scene.frame_set(rest_frame)
    for deformer in obj.sinew.deformers:
        if deformer.cage is not None:  # a cage at rest moves nothing
            posed, deformer.factor = deformer.factor, 0.0
            off = np.abs(shape(obj) - shapes[0]).max() / size
            deformer.factor = posed
            if off > 1e-4:
                raise SampleError(f"{obj.name}: the cage at rest moves it by {off:.3g} of its size")
    travel = np.linalg.norm(shapes[1] - shapes[0], axis=1).max() / size
    if not 0.05 < travel < 3.0:
        raise SampleError(f"{obj.name}: the pose moves vertices by {travel:.3g} of its size")
    how = "; ".join(f"{deformer.method}: {deformer.status}" for deformer in obj.sinew.deformers)
    print(f"> {obj.name}: {how}", flush=True)


def registry() -> ModuleType:
    return import_module("sinew.core.methods")


def native() -> ModuleType:
    found = import_module("sinew.backend").availability()
    if found.module is None:
        raise SampleError(found.remedy)
    return found.module


def bound(obj: Object, method: str, names: Iterable[str]) -> object:
    """A method of handle points, built from a posed object's handles and its parameters of these names."""
    points, parameters = vertices(obj), obj.sinew.active.parameters
    faces = [list(face.vertices) for face in obj.data.polygons]
    groups = [obj.vertex_groups[handle.vertex_group].index for handle in obj.sinew.active.handles]
    rows = [(vertex.index, row.group) for vertex in obj.data.vertices for row in vertex.groups]
    held = [points[[vertex for vertex, of in rows if of == group]] for group in groups]
    made = getattr(native(), method)(
        native().SurfaceMesh(points, faces),
        np.concatenate(held),
        [len(own) for own in held],
        **{name: getattr(parameters, name) for name in names},
    )
    made.bind(points)
    return made

# SPDX-License-Identifier: GPL-3.0-or-later
"""Small scenes, and what Blender shows of them: of Sinew, only its operators run here."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import bmesh
import bpy
import numpy as np
import pytest
from mathutils import Matrix
from mathutils.kdtree import KDTree

FLOAT32 = 4e-6  # a few roundings of coordinates near 1
MATRIX = 1e-5  # a pose that went through location, rotation and scale in float32
CORNERS = [(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)]  # of a cube
SIDES = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def update() -> None:
    """Let Blender evaluate, handlers included."""
    bpy.context.view_layer.update()


def close(seen: np.ndarray, expected: np.ndarray, tolerance: float = FLOAT32) -> bool:
    """Equal up to ``tolerance`` per coordinate, with the same number of points."""
    return seen.shape == expected.shape and bool(np.abs(seen - expected).max() < tolerance)


def push(message: str) -> None:
    """An undo step, as the end of any user operation makes one."""
    update()
    bpy.ops.ed.undo_push(message=message)


def coordinates(elements: bpy.types.bpy_prop_collection, name: str = "co") -> np.ndarray:
    """A vector of each element, (n, 3)."""
    flat = np.empty(len(elements) * 3, dtype=np.float32)
    elements.foreach_get(name, flat)
    return flat.reshape(-1, 3).astype(float)


def points_of(evaluated: bpy.types.Object) -> np.ndarray:
    """Vertices, places along a curve, or the points themselves, object space, (n, 3)."""
    if evaluated.type in ("CURVES", "POINTCLOUD"):
        return coordinates(evaluated.data.attributes["position"].data, "vector")
    if evaluated.type == "LATTICE":
        return coordinates(evaluated.data.points, "co_deform")
    mesh = evaluated.to_mesh()
    if mesh is None:  # an empty curve
        return np.empty((0, 3))
    points = coordinates(mesh.vertices)
    evaluated.to_mesh_clear()
    return points


def evaluated_points(obj: bpy.types.Object) -> np.ndarray:
    """What Blender shows, object space, (n, 3)."""
    update()
    return points_of(obj.evaluated_get(bpy.context.evaluated_depsgraph_get()))


def instances_of(name: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """World matrix and points (object space) of each instance of the object."""
    update()
    return [
        (np.array(instance.matrix_world), points_of(instance.object))
        for instance in bpy.context.evaluated_depsgraph_get().object_instances
        if instance.is_instance and instance.object.name == name
    ]


def base_points(obj: bpy.types.Object) -> np.ndarray:
    """The mesh without modifiers, (n, 3)."""
    return coordinates(obj.data.vertices)


def apply_matrix(matrix: Matrix, points: np.ndarray) -> np.ndarray:
    array = np.array(matrix)
    return points @ array[:3, :3].T + array[:3, 3]


def linked(obj: bpy.types.Object) -> bpy.types.Object:
    bpy.context.scene.collection.objects.link(obj)
    return obj


def new_object(
    name: str, points: Iterable[Sequence[float]], faces: Iterable = (), edges: Iterable = ()
) -> bpy.types.Object:
    """A mesh object in the scene."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(list(points), list(edges), list(faces))
    return linked(bpy.data.objects.new(name, mesh))


def new_empty(name: str, location: Sequence[float] = (0.0, 0.0, 0.0)) -> bpy.types.Object:
    """An object without data in the scene."""
    empty = linked(bpy.data.objects.new(name, None))
    empty.location = location
    update()
    return empty


def reopen(path: Path) -> None:
    """Save the scene as a file, and open that."""
    bpy.ops.wm.save_as_mainfile(filepath=str(path))
    bpy.ops.wm.open_mainfile(filepath=str(path))


@contextmanager
def in_mode(obj: bpy.types.Object, mode: str = "EDIT") -> Iterator[None]:
    """The object is active, in a mode that it leaves in the end."""
    make_active(obj)
    bpy.ops.object.mode_set(mode=mode)
    yield
    bpy.ops.object.mode_set(mode="OBJECT")


def on_all(obj: bpy.types.Object, operator: Callable, **keywords: object) -> None:
    """An operator of Edit Mode, on all points of a mesh, a curve or a lattice."""
    kind = {"CURVE": bpy.ops.curve, "LATTICE": bpy.ops.lattice}.get(obj.type, bpy.ops.mesh)
    with in_mode(obj):
        kind.select_all(action="SELECT")
        assert operator(**keywords) == {"FINISHED"}


def grid_object(name: str = "Plate", cells: int = 10) -> bpy.types.Object:
    """A square of ``cells`` x ``cells`` quads from -1 to 1 in the plane z = 0."""
    line, row = np.linspace(-1.0, 1.0, cells + 1), cells + 1
    corners = [j * row + i for j in range(cells) for i in range(cells)]
    faces = [(a, a + 1, a + row + 1, a + row) for a in corners]
    obj = new_object(name, [(x, y, 0.0) for y in line for x in line], faces)
    make_active(obj)
    return obj


def make_active(obj: bpy.types.Object, *others: bpy.types.Object) -> None:
    """Select these objects and no others; the first one is active."""
    update()
    for each in bpy.context.view_layer.objects:
        each.select_set(each == obj or each in others)
    bpy.context.view_layer.objects.active = obj


def press(obj: bpy.types.Object, operator: str, /, **keywords: object) -> None:
    """A button of ours, with that object active and nothing else selected."""
    make_active(obj)
    assert getattr(bpy.ops.sinew, operator)(**keywords) == {"FINISHED"}


def fails(match: str, act: Callable, /, *arguments: object, **keywords: object) -> None:
    """What ends in an operator says why it does nothing."""
    with pytest.raises(RuntimeError, match=match):
        act(*arguments, **keywords)


def refused(match: str, operator: str, on: bpy.types.Object | None = None, /, **keywords: object) -> None:
    """A button of ours says why it does nothing, with an object active, or with what is."""
    if on is not None:
        make_active(on)
    fails(match, getattr(bpy.ops.sinew, operator), **keywords)


def duplicated(*objects: bpy.types.Object, linked: bool = False) -> bpy.types.Object:
    """The copy of the first of these objects, by Blender's operator; nothing is evaluated yet."""
    make_active(*objects)
    bpy.ops.object.duplicate(linked=linked)
    return bpy.context.object


def subdivided(obj: bpy.types.Object, levels: int = 1, render_levels: int = 1) -> bpy.types.Modifier:
    """Its new Subdivision modifier."""
    modifier = obj.modifiers.new("Subdivision", "SUBSURF")
    modifier.levels, modifier.render_levels = levels, render_levels
    return modifier


def add_key(obj: bpy.types.Object, name: str, by: Matrix) -> bpy.types.ShapeKey:
    """A shape key beside the basis, whose points and handles a matrix moves; it is off."""
    if obj.data.shape_keys is None:
        obj.shape_key_add(name="Basis")
    block = obj.shape_key_add(name=name)
    for point in block.data:
        for place in ("co", "handle_left", "handle_right"):
            if hasattr(point, place):
                setattr(point, place, by @ getattr(point, place))
    block.value = 0.0  # new keys are on from Blender 5.0
    return block


def slope(x: float = 0.0, y: float = 0.0) -> Matrix:
    """It lifts points in proportion to where they are."""
    return Matrix(((1, 0, 0, 0), (0, 1, 0, 0), (x, y, 1, 0), (0, 0, 0, 1)))


def new_nodes(name: str) -> tuple[bpy.types.NodeTree, bpy.types.NodeSocket, bpy.types.NodeSocket]:
    """A group of geometry nodes, the geometry that enters, and the one that leaves."""
    tree = bpy.data.node_groups.new(name, "GeometryNodeTree")
    for way, sockets in (("INPUT", "inputs"), ("OUTPUT", "outputs")):
        if hasattr(tree, "interface"):
            tree.interface.new_socket("Geometry", in_out=way, socket_type="NodeSocketGeometry")
        else:
            getattr(tree, sockets).new("NodeSocketGeometry", "Geometry")
    start, end = tree.nodes.new("NodeGroupInput"), tree.nodes.new("NodeGroupOutput")
    return tree, start.outputs[0], end.inputs[0]


def add_regions(obj: bpy.types.Object, method: str, regions: dict[str, str]):
    """A new deformer with regions: their roles by vertex group."""
    press(obj, "deformer_add", method=method)
    for group, kind in regions.items():
        press(obj, "handle_add", kind=kind, vertex_group=group)
    make_active(obj)
    return obj.sinew.active


def add_group(obj: bpy.types.Object, name: str, where) -> np.ndarray:
    """A vertex group of the vertices for which ``where(point)``; their indices."""
    members = [index for index, point in enumerate(base_points(obj)) if where(point)]
    obj.vertex_groups.new(name=name).add(members, 1.0, "REPLACE")
    return np.array(members)


def painted(mesh: bpy.types.Mesh, group: int) -> np.ndarray:
    """(n,) weights of a vertex group, by its number."""
    weights = np.zeros(len(mesh.vertices))
    for vertex in mesh.vertices:
        for element in vertex.groups:
            if element.group == group:
                weights[vertex.index] = element.weight
    return weights


def members(obj: bpy.types.Object, group: str) -> np.ndarray:
    """The numbers of the vertices that a vertex group holds."""
    return np.flatnonzero(painted(obj.data, obj.vertex_groups[group].index))


def nearest(points: np.ndarray, others: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The number of the one of the others that is nearest to each point, and how far away it is."""
    tree = KDTree(len(others))
    for number, place in enumerate(others):
        tree.insert(place, number)
    tree.balance()
    found = [tree.find(point) for point in points]
    return np.array([number for _, number, _ in found]), np.array([distance for *_, distance in found])


def armature_object(name: str, bones: dict[str, tuple]) -> bpy.types.Object:
    """An armature with bones by name: head, tail, and the name of the parent where there is one."""
    armature = linked(bpy.data.objects.new(name, bpy.data.armatures.new(name)))
    with in_mode(armature):
        made = armature.data.edit_bones
        for bone, (head, tail, *parent) in bones.items():
            new = made.new(bone)
            new.head, new.tail = head, tail
            new.parent = made[parent[0]] if any(parent) else None
    update()
    return armature


def new_armature(**bones: tuple) -> bpy.types.Object:
    """The armature ``Rig``, whose bones turn by Euler angles."""
    armature = armature_object("Rig", bones)
    for bone in armature.pose.bones:
        bone.rotation_mode = "XYZ"
    return armature


def add_armature(obj: bpy.types.Object, split: float = 0.0) -> bpy.types.Object:
    """Two bones along y that carry the halves of the mesh below and above ``split``."""
    middle = (0.0, split, 0.0)
    armature = new_armature(low=((0.0, -1.0, 0.0), middle), high=(middle, (0.0, 1.0, 0.0)))
    add_group(obj, "low", lambda point: point[1] <= split)
    add_group(obj, "high", lambda point: point[1] > split)
    modifier = obj.modifiers.new("Armature", "ARMATURE")
    modifier.object = armature
    make_active(obj)
    return armature


class Rig:
    """A plate, its regions, and its deformer once there is one."""

    def __init__(self, obj: bpy.types.Object, edge: float = 0.75) -> None:
        self.name = obj.name
        self.top = add_group(obj, "Top", lambda point: point[1] > edge)
        self.base = add_group(obj, "Base", lambda point: point[1] < -edge)

    @classmethod
    def plate(cls, cells: int = 10, edge: float = 0.75) -> Rig:
        return cls(grid_object(cells=cells), edge)

    @property
    def obj(self) -> bpy.types.Object:
        """Looked up each time: undo and load make new Python objects."""
        return bpy.data.objects[self.name]

    @classmethod
    def called(cls, name: str) -> Rig:
        """One that is there already."""
        rig = cls.__new__(cls)
        rig.name = name
        return rig

    @property
    def deformer(self):
        return self.obj.sinew.active

    @property
    def control(self) -> bpy.types.Object:
        return self.deformer.handles[0].control

    def bind(self, method: str = "thin_shell", fixed: bool = True, **keywords) -> Rig:
        """Deformer, handle ``Top``, fixed ``Base``, through the operators."""
        make_active(self.obj)
        bpy.ops.sinew.deformer_add(method=method)
        bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Top", **keywords)
        make_active(self.obj)
        if fixed:
            bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Base")
        return self

    def points(self) -> np.ndarray:
        return evaluated_points(self.obj)

    def rest(self) -> np.ndarray:
        return base_points(self.obj)

    def lift(self, height: float = 1.0) -> None:
        """Move the control along the world's z."""
        move_world(self.control, Matrix.Translation((0.0, 0.0, height)))


def move_world(control: bpy.types.Object, motion: Matrix) -> None:
    """Move an object by a world-space motion, on top of where it is."""
    update()
    control.matrix_world = motion @ control.matrix_world
    update()


def key(control: bpy.types.Object, keys: dict[int, dict[str, object]], linear: bool = False) -> None:
    """Properties by frame, as ``{1: {"location": (0, 0, 1)}}``; ``linear`` goes on beyond them, too."""
    for frame, values in keys.items():
        for name, value in values.items():
            setattr(control, name, value)
            control.keyframe_insert(name, frame=frame)
    for curve in curves_of(control.id_data) if linear else ():
        curve.extrapolation = "LINEAR"
        for point in curve.keyframe_points:
            point.interpolation = "LINEAR"


def key_heights(control: bpy.types.Object, heights: dict[int, float], linear: bool = False) -> None:
    """Along its own z, from where it is in x and y."""
    x, y, _z = control.location
    key(control, {frame: {"location": (x, y, height)} for frame, height in heights.items()}, linear)


def curves_of(datablock: bpy.types.ID) -> list[bpy.types.FCurve]:
    """The F-curves of its action, in any version."""
    action = datablock.animation_data.action
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    bags = (bag for layer in action.layers for strip in layer.strips for bag in strip.channelbags)
    return [curve for bag in bags for curve in bag.fcurves]


def change_in_edit_mode(obj: bpy.types.Object, change: Callable[[bmesh.types.BMesh], object]) -> None:
    """As a user does; the object is in Object Mode before and after."""
    make_active(obj)
    bpy.ops.object.mode_set(mode="EDIT")
    edit = bmesh.from_edit_mesh(obj.data)
    for part in (edit.verts, edit.edges, edit.faces):
        part.ensure_lookup_table()
    change(edit)
    if edit.is_valid:  # an operator may have made another one
        bmesh.update_edit_mesh(obj.data)
    bpy.ops.object.mode_set(mode="OBJECT")


def save(path: Path | str, **options: bool) -> str:
    """The file's path."""
    bpy.ops.wm.save_as_mainfile(filepath=str(path), **options)
    return str(path)


def load(path: Path | str) -> None:
    bpy.ops.wm.open_mainfile(filepath=str(path))


def new_file() -> None:
    """Empty, as the tests begin."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)


def storage(owner: object) -> object:
    """Where Blender keeps the properties of a class, as ID properties: a hostile file writes here."""
    system = getattr(owner, "bl_system_properties_get", None)
    return system(do_create=True) if system else owner


def some_motion() -> Matrix:
    """A rigid motion without symmetry."""
    turn = Matrix.Rotation(math.radians(50.0), 4, (0.3, 0.9, -0.2))
    return Matrix.Translation((0.4, -0.2, 0.7)) @ turn


def in_pose_mode(armature: bpy.types.Object, bone: str, mesh: bpy.types.Object | None = None) -> None:
    """The armature active in Pose Mode with one bone selected, and the mesh selected with it."""
    make_active(armature)
    if mesh is not None:
        mesh.select_set(True)
    bpy.ops.object.mode_set(mode="POSE")
    bpy.ops.pose.select_all(action="DESELECT")
    select_bone(armature, bone)


def select_bone(armature: bpy.types.Object, bone: str) -> None:
    armature.data.bones.active = armature.data.bones[bone]
    posed = armature.pose.bones[bone]
    (posed if hasattr(posed, "select") else posed.bone).select = True

# SPDX-License-Identifier: GPL-3.0-or-later
"""Refined meshes: what a Subdivision modifier makes of a mesh, stored, so that only its points move later.

Blender's own modifier makes a refined mesh once, with UV maps, weights, colours and materials. In every
frame the library moves its points; they are those of the modifier, in its order. Main thread only, but for
``surface_of``.
"""

from collections.abc import Iterator
from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from bpy.types import Mesh, Modifier, NodesModifier, Object, Scene
from mathutils.kdtree import KDTree

from ... import compat
from ...backend import RefinedSurface, Subdivision
from ...compat import read_creases, read_edges, read_faces, read_positions, remove_data, write_positions
from ...core.errors import MeshError, SinewError
from ...core.geometry import frames
from ...core.memory import remember
from ...ids import Datablocks, Inputs, Keys
from ...mesh_io import Incoming, read_incoming
from ..state import sessions
from ..state.evaluation import ObjectEvaluation
from ..targets import modified, refined_group
from .shapes import capture, shapes

_ORDER = ".sinew_order"  # an attribute of refined meshes: the library's number of each vertex
_OTHERWISE = "Blender subdivides this mesh in another way - let its own modifier do that"
_OF_THE_MOMENT = (".sinew_", ".select_")  # attributes that refined meshes do without
_SCALARS = {"BOOLEAN": np.bool_, "INT": np.int32, "FLOAT": np.float32}
_UNSEEN = ("select", "hide")
_surfaces: dict[str, RefinedSurface] = remember({})  # by the token of the refined mesh
_refused: dict[str, tuple[str, str]] = remember({})  # by object: for which settings, and why


def subdivision(modifier: Modifier, scene: Scene) -> Subdivision:
    """How a Subdivision modifier refines in viewports, were it switched on there."""
    render = scene.render
    levels = min(modifier.levels, render.simplify_subdivision) if render.use_simplify else modifier.levels
    return Subdivision(
        levels,
        "bilinear" if modifier.subdivision_type == "SIMPLE" else "catmull_clark",
        modifier.use_limit_surface and modifier.subdivision_type != "SIMPLE",
        modifier.boundary_smooth.lower(),
        modifier.use_creases,
    )


def signature(modifier: Modifier, scene: Scene) -> str:
    """All settings of a Subdivision modifier that a refined mesh depends on, for comparison."""
    further = modifier.uv_smooth, modifier.use_custom_normals, modifier.quality
    return f"{subdivision(modifier, scene)} {further}"


def mesh_of(modifier: NodesModifier) -> Mesh | None:
    """The refined mesh that a modifier shows; None before it is made, and if it was deleted."""
    mesh = _mesh(compat.modifier_input(modifier, Inputs.REFINED))
    return mesh if mesh is not None and isinstance(mesh.get(Keys.REFINED_CONTROL), Mesh) else None


def places_of(modifier: NodesModifier) -> Mesh | None:
    """The mesh without faces that says where the vertices of the refined mesh are."""
    return _mesh(compat.modifier_input(modifier, Inputs.REFINED_PLACES))


def _mesh(shown: object) -> Mesh | None:
    return shown.data if isinstance(shown, Object) and shown.type == "MESH" else None


def refusal(obj: Object, wanted: str) -> str:
    """Why there is no refined mesh for these settings, if it was tried; else empty."""
    settings, text = _refused.get(obj.name, ("", ""))
    return text if settings == wanted else ""


def surface_of(mesh: Mesh, how: Subdivision) -> RefinedSurface:
    """What moves the points of a refined mesh, which was made by this subdivision."""
    token = mesh[Keys.REFINED_TOKEN]
    surface = _surfaces.get(token)
    if surface is None:
        order = np.empty(len(mesh.vertices), dtype=np.int32)
        mesh.attributes[_ORDER].data.foreach_get("value", order)
        surface = _surface(mesh[Keys.REFINED_CONTROL], how)
        surface.put_in_order(order)
        _surfaces[token] = surface
    return surface


def make(obj: Object, modifier: NodesModifier) -> None:
    """Make the refined mesh of a modifier from the mesh as it is, unless nothing but points has changed.

    Raises a MeshError where Blender's modifier makes something that the library does not.
    """
    by, scene = refined_group.subdivision_of(obj, modifier), bpy.context.scene
    if by is None:
        raise MeshError("No Subdivision modifier stands right before Fast Subdivision - move it there")
    how = subdivision(by, scene)
    if how.levels == 0:
        remove_mesh(modifier)
        return
    control = capture.mesh_after(obj, obj.modifiers.find(by.name))
    for attribute in [each.name for each in control.attributes if each.name.startswith(_OF_THE_MOMENT)]:
        control.attributes.remove(control.attributes[attribute])
    made, names = [control], _names(obj, control)
    if _is_as_before(modifier, by, control, names, signature(by, scene)):
        remove_data(made)
        _refused.pop(obj.name, None)
        return
    try:
        refined = _subdivided(control, by)
        made.append(refined)
        surface = _surface(control, how)
        order = _order(control, refined, surface, how, by)
        surface.put_in_order(order)
    except SinewError as error:
        remove_data(made)
        _refused[obj.name] = signature(by, scene), str(error)
        raise
    _refused.pop(obj.name, None)
    remove_mesh(modifier)
    refined.name = control.name = Datablocks.REFINED
    refined.attributes.new(_ORDER, "INT", "POINT").data.foreach_set("value", order)
    refined[Keys.REFINED_FOR], refined[Keys.REFINED_TOKEN] = signature(by, scene), shapes.new_key()
    refined[Keys.REFINED_CONTROL], refined[Keys.REFINED_NAMES] = control, names
    _surfaces[refined[Keys.REFINED_TOKEN]] = surface
    places = bpy.data.meshes.new(Datablocks.REFINED)
    places.vertices.add(len(order))
    places[Keys.REFINED_TOKEN] = shapes.new_key()
    for name, mesh in ((Inputs.REFINED, refined), (Inputs.REFINED_PLACES, places)):
        refined_group.connect(modifier, name, bpy.data.objects.new(Datablocks.REFINED, mesh))
    keep_incoming(obj, modifier)


def _is_as_before(modifier: NodesModifier, by: Modifier, control: Mesh, names: str, wanted: str) -> bool:
    """Whether the refined mesh of a modifier was made of such a control mesh, wherever its points were."""
    mesh = mesh_of(modifier)
    if mesh is None or places_of(modifier) is None or (control.has_custom_normals and by.use_custom_normals):
        return False
    kept, points = mesh[Keys.REFINED_CONTROL], read_positions(control)
    if (mesh[Keys.REFINED_FOR], mesh.get(Keys.REFINED_NAMES), len(kept.vertices)) != (
        wanted,
        names,
        len(points),
    ):
        return False
    write_positions(control, read_positions(kept))
    same = control.unit_test_compare(mesh=kept) == "Same"  # in 3.4 it leaves out some of the following
    same = same and all(map(np.array_equal, _parts(control), _parts(kept)))
    write_positions(control, points)
    return same


def _names(obj: Object, control: Mesh) -> str:
    """All names in the control mesh of an object, for comparison. Edit Mode may reorder attributes."""
    uvs = [(layer.name, layer.active_render) for layer in control.uv_layers]
    materials = [material and material.name_full for material in control.materials]
    return repr((obj.vertex_groups.keys(), uvs, materials, sorted(control.attributes.keys())))


def _parts(mesh: Mesh) -> Iterator[Any]:
    """The faces, edges and creases of a mesh, and the settings of these and of itself."""
    yield from (*read_faces(mesh), read_edges(mesh), *(part for pair in read_creases(mesh) for part in pair))
    for elements in ([mesh], mesh.edges, mesh.polygons):
        for setting in elements[0].bl_rna.properties if len(elements) else ():
            dtype = _SCALARS.get(setting.type)
            if dtype is None or setting.is_readonly or setting.is_array or setting.identifier in _UNSEEN:
                continue
            if elements == [mesh]:
                yield getattr(mesh, setting.identifier)
            else:
                values: np.ndarray = np.empty(len(elements), dtype=dtype)
                elements.foreach_get(setting.identifier, values)
                yield values


def remove_mesh(modifier: NodesModifier) -> None:
    """Remove the refined mesh of a modifier. It then shows the control mesh."""
    refined_group.connect(modifier, Inputs.REFINED_POINTS, -1)
    for name in (Inputs.REFINED, Inputs.REFINED_PLACES):
        shown = compat.modifier_input(modifier, name)
        refined_group.connect(modifier, name, None)
        if isinstance(shown, Object) and not _is_shown(shown, name):
            mesh = shown.data
            _surfaces.pop(mesh.get(Keys.REFINED_TOKEN), None)
            control = mesh.get(Keys.REFINED_CONTROL)
            bpy.data.objects.remove(shown)
            remove_data([each for each in (mesh, control) if each is not None])


def _is_shown(shown: Object, name: str) -> bool:
    """Whether a copied object shows this refined mesh, or its places, too. Blender 5 counts users late."""
    return any(
        compat.modifier_input(modifier, name) == shown
        for obj in bpy.data.objects
        for modifier in filter(refined_group.is_refining, obj.modifiers)
    )


def keep_incoming(obj: Object, modifier: NodesModifier) -> bool:
    """Let the refined mesh keep what the first of the deformers right before it has stored of its incoming
    shape. Whether something else was kept.

    Storing costs as much as moving the points, and nothing has to be kept where the mesh itself enters.
    """
    keys, first, is_plain = (
        {deformer.shape("VIEWPORT"): deformer.uid for deformer in obj.sinew.deformers},
        "",
        True,
    )
    for other in obj.modifiers[: obj.modifiers.find(modifier.name)]:
        if other.show_viewport:
            key = keys.get(modified.mark(other), "")
            first, is_plain = key and (first or key), is_plain and bool(key)
    is_plain &= obj.data.shape_keys is None and obj.parent_type not in ("ARMATURE", "LATTICE")
    names = ("", "") if is_plain else modified.attribute_names(first)
    pairs = zip((Inputs.KEPT, Inputs.KEPT_INDEX), names, strict=True)
    changed = [refined_group.connect(modifier, name, value) for name, value in pairs]
    return any(changed)


def read_entering(shared: ObjectEvaluation, key: str, expected: int) -> Incoming:
    """The positions that enter the deformer of this key, from the final mesh, or the mesh itself where that
    enters and the final mesh does not keep it.
    """
    if shared.in_viewport and shared.obj.mode != "EDIT" and keeps_nothing(shared.obj):
        points = read_positions(shared.obj.data)
        return Incoming(points if len(points) == expected else None, len(points))
    return read_incoming(shared.evaluated.data, *modified.attribute_names(key), expected)


def keeps_nothing(obj: Object) -> bool:
    """Whether a refined mesh is shown that keeps nothing of what enters the deformers: the mesh itself."""
    modifier = refined_group.of(obj)
    if modifier is None or not modifier.show_viewport:
        return False
    shown, kept = (compat.modifier_input(modifier, name) for name in (Inputs.REFINED_POINTS, Inputs.KEPT))
    return shown != -1 and not kept


def separate(obj: Object) -> None:
    """Give a copied object places of its own; the refined mesh itself is never changed."""
    for modifier in filter(refined_group.is_refining, obj.modifiers):
        places = places_of(modifier)
        if places is not None:
            own = bpy.data.objects.new(Datablocks.REFINED, places.copy())
            own.data[Keys.REFINED_TOKEN] = shapes.new_key()
            refined_group.connect(modifier, Inputs.REFINED_PLACES, own)
        keep_incoming(obj, modifier)


def _surface(control: Mesh, how: Subdivision) -> RefinedSurface:
    points = read_positions(control).astype(np.float64)
    return RefinedSurface(points, read_faces(control), read_creases(control), how)


def _subdivided(mesh: Mesh, by: Modifier, **changes: str) -> Mesh:
    """A new mesh: what a Subdivision modifier makes of another one, with some of its settings changed."""
    obj = bpy.data.objects.new(Datablocks.REFINED, mesh)
    with sessions.suspended():
        modifier = obj.modifiers.new(by.name, "SUBSURF")
        for setting in by.bl_rna.properties:
            if not setting.is_readonly:
                setattr(modifier, setting.identifier, getattr(by, setting.identifier))
        for name, value in changes.items():
            setattr(modifier, name, value)
        modifier.show_viewport = True
        bpy.context.scene.collection.objects.link(obj)
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        made = modified.new_mesh(obj.evaluated_get(depsgraph), depsgraph)
        bpy.data.objects.remove(obj)
    return made


def _order(
    control: Mesh, refined: Mesh, surface: RefinedSurface, how: Subdivision, by: Modifier
) -> np.ndarray:
    """The library's number of each vertex of a refined mesh, int32 (m,).

    Both refine face after face. The order within a face depends on nothing but its size, so it is found where
    both split one flat polygon of each size.
    """
    theirs, ours = read_faces(refined)[1].reshape(-1, 4), surface.corners.reshape(-1, 4)
    if theirs.shape != ours.shape or len(refined.vertices) != surface.vertex_count:
        raise MeshError(_OTHERWISE)
    counts = read_faces(control)[0]
    parts = counts * 4 ** (how.levels - 1)
    first = np.cumsum(parts) - parts
    mine, start = np.empty_like(theirs), 0
    faces, corners = _pattern(np.unique(counts), how, by)
    for size in np.unique(counts):
        end = start + size * 4 ** (how.levels - 1)
        begins = first[counts == size][:, None]
        parts_of_size = begins + (faces[start:end] - start)
        mine[begins + np.arange(end - start)] = ours[parts_of_size[:, :, None], corners[start:end]]
        start = end
    own = np.arange(surface.control_count)
    order = np.full(len(refined.vertices), -1, dtype=np.int32)
    order[own] = own
    order[theirs] = mine
    # All faces agree on each vertex, and those of the mesh itself are where they were: so both are the same.
    if not np.array_equal(order[theirs], mine) or (order[own] != own).any() or (order < 0).any():
        raise MeshError(_OTHERWISE)
    return order


def _pattern(sizes: np.ndarray, how: Subdivision, by: Modifier) -> tuple[np.ndarray, np.ndarray]:
    """Blender's parts of regular polygons of these sizes: which part each is in the library (p,), and which
    corner of it each corner is (p, 4).
    """
    around = np.concatenate([frames.circle(size) + (3.0 * at, 0.0) for at, size in enumerate(sizes)])
    ends = np.cumsum(sizes)
    flat = bpy.data.meshes.new(Datablocks.REFINED)
    polygons = [list(range(end - size, end)) for size, end in zip(sizes, ends, strict=True)]
    flat.from_pydata([(x, y, 0.0) for x, y in around.tolist()], [], polygons)
    made = [flat]
    try:
        made.append(_subdivided(flat, by, subdivision_type="SIMPLE"))
        theirs = read_positions(made[1])[read_faces(made[1])[1].reshape(-1, 4)]
        surface = _surface(flat, replace(how, scheme="bilinear", limit=False))
        ours = surface.refine(read_positions(flat))[surface.corners.reshape(-1, 4)]
    finally:
        remove_data(made)
    tree = KDTree(len(ours))
    for part, middle in enumerate(ours.mean(axis=1)):
        tree.insert(middle, part)
    tree.balance()
    parts = np.array([tree.find(middle)[1] for middle in theirs.mean(axis=1)])
    apart = np.linalg.norm(theirs[:, :, None] - ours[parts][:, None], axis=3)
    return parts, apart.argmin(axis=2)

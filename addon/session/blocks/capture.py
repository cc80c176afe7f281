# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a mesh of what enters the modifier of a deformer, without changing the object.

A temporary copy of the object, without this modifier and the later ones, is evaluated in the scene. If the
object is in Edit Mode, the edits are written to its mesh first, and the copy gets a mesh of its own.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager

import bpy
from bpy.types import Depsgraph, Mesh, Modifier, Object

from ...core.errors import MeshError
from ...core.point_types import MESH, point_type_with_id
from ...ids import Datablocks, Keys
from ...mesh_io import same_topology, weights_attribute
from ...properties import SinewDeformer
from ..memory import sessions
from . import control_points, shapes, targets, vertex_groups


@contextmanager
def evaluated_mesh(obj: Object, depsgraph: Depsgraph) -> Iterator[Mesh | None]:
    """For a while, the mesh of an object after its modifiers, in object space; None if it has none."""
    evaluated = obj.evaluated_get(depsgraph)
    try:
        yield evaluated.to_mesh()
    finally:
        evaluated.to_mesh_clear()


# So few vertex groups are all stored as attributes, in use or not. If a later bind uses other groups, only
# weights have changed since.
FEW_GROUPS = 8


@contextmanager
def _stand_in(obj: Object, last_modifier: int) -> Iterator[Object]:
    """A copy of the object with its first ``last_modifier`` modifiers. It is removed at the end."""
    with sessions.suspended():
        copy = obj.copy()
        own_data = None
        try:
            copy.sinew.deformers.clear()
            _remove_drivers(copy)
            if obj.mode == "EDIT":
                obj.update_from_editmode()
                own_data = copy.data = obj.data.copy()
            for modifier in list(copy.modifiers)[last_modifier:]:
                copy.modifiers.remove(modifier)
            copy.hide_viewport = False
            bpy.context.scene.collection.objects.link(copy)
            yield copy
        finally:
            bpy.data.objects.remove(copy)
            if own_data is not None:
                bpy.data.batch_remove((own_data,))
            bpy.context.view_layer.update()


def _remove_drivers(copy: Object) -> None:
    """Remove the drivers of settings that the copy no longer has."""
    if copy.animation_data is None:
        return
    for curve in list(copy.animation_data.drivers):
        if curve.data_path.startswith("sinew."):
            copy.animation_data.drivers.remove(curve)


def mesh_after(obj: Object, last_modifier: int) -> Mesh:
    """A new mesh: the object after its first ``last_modifier`` modifiers."""
    with _stand_in(obj, last_modifier) as copy:
        return _new_mesh(copy)


def _new_mesh(obj: Object) -> Mesh:
    if not targets.is_mesh(obj):
        with control_points.showing_points(obj) as points:
            return _new_mesh(points)
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return bpy.data.meshes.new_from_object(
        obj.evaluated_get(depsgraph), preserve_all_data_layers=True, depsgraph=depsgraph
    )


def rest_mesh(obj: Object, deformer: SinewDeformer) -> Mesh:
    """A new mesh: what enters the deformer's modifier now, or would enter one at the end of the stack."""
    with _stand_in(obj, _position(obj, deformer)) as copy:
        return _rest_mesh(obj, deformer, copy)


def rest_meshes(
    obj: Object, deformer: SinewDeformer, entered: Mesh | None = None
) -> tuple[Mesh, Mesh | None]:
    """New meshes: the rest mesh for viewports, and the one for renders, or None if they are the same.

    ``entered``: the rest mesh for viewports, if ``rest_mesh`` has just made it. It is returned, and stays
    the caller's if the one for renders is refused.
    """
    position = _position(obj, deformer)
    if entered is not None and not _differs_in_renders(obj, list(obj.modifiers)[:position]):
        return entered, None
    with _stand_in(obj, position) as copy:
        shown = _rest_mesh(obj, deformer, copy) if entered is None else entered
        if not _differs_in_renders(copy, copy.modifiers):
            return shown, None
        try:
            with _as_rendered(copy):
                rendered = _rest_mesh(obj, deformer, copy)
            _refuse_other_point_type(shown, rendered)
        except MeshError:
            if entered is None:
                bpy.data.meshes.remove(shown)
            raise
    if same_topology(shown, rendered):
        bpy.data.meshes.remove(rendered)
        return shown, None
    return shown, rendered


def _refuse_other_point_type(shown: Mesh, rendered: Mesh) -> None:
    if shown.get(Keys.REST_POINT_TYPE) != rendered.get(Keys.REST_POINT_TYPE):
        bpy.data.meshes.remove(rendered)
        raise MeshError(
            "Modifiers before Sinew make a surface in renders only, or in viewports only - let both agree"
        )


def _with_levels(modifiers: Iterable[Modifier]) -> list[Modifier]:
    """Those that subdivide, with one level for viewports and another for renders."""
    return [modifier for modifier in modifiers if hasattr(modifier, "render_levels")]


def _differs_in_renders(obj: Object, modifiers: Sequence[Modifier]) -> bool:
    """Whether other vertices may come out of these modifiers of an object in renders."""
    if targets.render_resolution(obj.data):
        return True
    render = bpy.context.scene.render
    simplified = render.use_simplify and render.simplify_subdivision != render.simplify_subdivision_render
    return any(modifier.show_viewport != modifier.show_render for modifier in modifiers) or any(
        simplified or modifier.levels != modifier.render_levels for modifier in _with_levels(modifiers)
    )


@contextmanager
def _as_rendered(copy: Object) -> Iterator[None]:
    """For a while, the modifiers of the copy do in viewports what they do in renders."""
    render = bpy.context.scene.render
    simplify, data = render.use_simplify, copy.data
    if targets.render_resolution(data):
        copy.data = data.copy()
        copy.data.resolution_u = targets.render_resolution(data)
    for modifier in copy.modifiers:
        modifier.show_viewport = modifier.show_render
    for modifier in _with_levels(copy.modifiers):
        most = render.simplify_subdivision_render if simplify else modifier.render_levels
        modifier.levels = min(modifier.render_levels, most)
    if simplify:
        render.use_simplify = False
    try:
        yield
    finally:
        if simplify:
            render.use_simplify = True
        if copy.data != data:
            own_data, copy.data = copy.data, data
            bpy.data.batch_remove((own_data,))


def _position(obj: Object, deformer: SinewDeformer) -> int:
    modifier = shapes.find_modifier(obj, deformer)
    return len(obj.modifiers) if modifier is None else list(obj.modifiers).index(modifier)


def _rest_mesh(obj: Object, deformer: SinewDeformer, copy: Object) -> Mesh:
    if not targets.is_mesh(obj):
        mesh = _new_mesh(copy)
        mesh[Keys.REST_POINT_TYPE] = control_points.take_point_type(mesh).id
        mesh[Keys.REST_STRUCTURE] = targets.structure(obj)
        return _as_rest(mesh, [])
    names = [group.name for group in obj.vertex_groups]
    wanted = names if len(names) <= FEW_GROUPS else vertex_groups.groups_in_use(deformer) & set(names)
    painted = {weights_attribute(names.index(name)): name for name in wanted}
    with vertex_groups.keeping_weights(copy, painted):
        mesh = _new_mesh(copy)
    return _as_rest(mesh, names)


def _as_rest(mesh: Mesh, names: list[str]) -> Mesh:
    """Name and mark a mesh as a rest mesh; ``names`` are those of the vertex groups of the object."""
    if len(mesh.vertices) == 0:
        point_type = point_type_with_id(mesh.get(Keys.REST_POINT_TYPE))
        bpy.data.meshes.remove(mesh)
        what = "mesh has no vertices" if point_type is MESH else "object has no points"
        raise MeshError(f"The {what} - add some, or check the modifiers before Sinew")
    mesh.name = Datablocks.REST
    mesh.materials.clear()
    mesh[Keys.REST_TOKEN] = shapes.new_key()
    mesh[Keys.REST_GROUPS] = names
    return mesh

# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes a mesh of what enters the modifier of a deformer, without changing the object.

A temporary copy of the object, without this modifier and the later ones, is evaluated in the scene. If the
object is in Edit Mode, the edits are written to its mesh first, and the copy gets a mesh of its own.
"""

from collections.abc import Iterable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from typing import TypeVar

import bpy
import numpy as np
from bpy.types import ID, Mesh, Modifier, Object

from ....compat import read_edges, read_positions, read_triangles, remove_data, write_positions
from ....core.errors import MeshError
from ....core.point_types import MESH, point_type_with_id
from ....ids import Datablocks, Keys
from ....mesh_io import keep_lost_groups, same_topology, weights_attribute
from ....properties import SinewDeformer
from ...state import sessions
from ...targets import node_group, targets
from ...targets.kinds import kind_of
from .. import vertex_groups
from . import render_settings, shapes
from .carried import AttachedPoints, Surface

# So few vertex groups are all stored as attributes, in use or not. If a later bind uses other groups, only
# weights have changed since.
FEW_GROUPS = 8
_PLACES = ".sinew_place"  # an attribute of temporary meshes


_Made = TypeVar("_Made")
Wanted = Sequence[tuple[Object, SinewDeformer]]  # of what the rest meshes are wanted
_AT_ONCE = 64  # so many objects are evaluated together: each evaluation looks at the whole scene


@contextmanager
def _stand_ins(objects: Iterable[tuple[Object, int]]) -> Iterator[list[Object]]:
    """A copy of each object that shows as many of its first modifiers or deformers. Removed at the end."""
    copies: list[Object] = []
    own_data: list[ID] = []
    with sessions.suspended():
        try:
            for obj, count in objects:
                copy = obj.copy()
                copies.append(copy)
                copy.sinew.deformers.clear()
                _remove_drivers(copy)
                if obj.mode == "EDIT":
                    obj.update_from_editmode()
                kind_of(obj).keep_first(copy, obj, count)
                if copy.data != obj.data:
                    own_data.append(copy.data)
                copy.hide_viewport = False
                bpy.context.scene.collection.objects.link(copy)
            yield copies
        finally:
            for copy in copies:
                bpy.data.objects.remove(copy)
            remove_data(own_data)
            sessions.evaluate_at_end()  # it takes long on a heavy mesh, so further changes wait for it


def _remove_drivers(copy: Object) -> None:
    """Remove the drivers of settings that the copy no longer has."""
    if copy.animation_data is None:
        return
    for curve in list(copy.animation_data.drivers):
        if curve.data_path.startswith("sinew."):
            copy.animation_data.drivers.remove(curve)


def mesh_after(obj: Object, last_modifier: int) -> Mesh:
    """A new mesh: the object after its first ``last_modifier`` modifiers."""
    with _stand_ins([(obj, last_modifier)]) as copies:
        return _new_meshes(copies)[0]


def mesh_with_places(obj: Object) -> tuple[Mesh, np.ndarray | None]:
    """A new mesh: the object after all modifiers; and where its vertices are in the mesh itself, float32
    (m, 3), or in between. None if the modifiers make vertices anew.
    """
    with _stand_ins([(obj, len(obj.modifiers))]) as (copy,):
        own = copy.data = obj.data.copy()
        try:
            places = own.attributes.new(_PLACES, "FLOAT_VECTOR", "POINT")
            places.data.foreach_set("vector", read_positions(obj.data).ravel())
            (mesh,) = _new_meshes([copy])
        finally:
            copy.data = obj.data
            remove_data((own,))
    carried = mesh.attributes.get(_PLACES)
    if carried is None or carried.domain != "POINT":
        return mesh, None
    flat = np.empty(len(mesh.vertices) * 3, dtype=np.float32)
    carried.data.foreach_get("vector", flat)
    return mesh, flat.reshape(-1, 3)


def _new_meshes(objects: Iterable[Object]) -> list[Mesh]:
    """New meshes of what objects are now, by one evaluation."""
    with ExitStack() as stack:
        shown = [stack.enter_context(kind_of(obj).showing_points(obj)) for obj in objects]
        bpy.context.view_layer.update()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        return [kind_of(obj).new_mesh(obj.evaluated_get(depsgraph), depsgraph) for obj in shown]


def rest_mesh(obj: Object, deformer: SinewDeformer) -> Mesh:
    """A new mesh: what enters the deformer's modifier now, or would enter one at the end of the stack."""
    with _stand_ins([(obj, kind_of(obj).position(obj, deformer))]) as copies:
        return _made(_rest_meshes([(obj, deformer)], copies)[0])


def rest_meshes(
    obj: Object, deformer: SinewDeformer, entered: Mesh | None = None
) -> tuple[Mesh, Mesh | None]:
    """New meshes: the rest mesh for viewports, and the one for renders, or None if they are the same.

    ``entered``: the rest mesh for viewports, if ``rest_mesh`` has just made it. It is returned, and stays
    the caller's if the one for renders is refused.
    """
    if entered is not None and not differs_in_renders(obj, deformer):
        return entered, None
    return _made(_rest_meshes_of([(obj, deformer)], [entered])[0])


def all_rest_meshes(wanted: Wanted) -> Iterator[tuple[Mesh, Mesh | None] | MeshError]:
    """What ``rest_meshes`` makes, or its error, for several deformers by few evaluations of the scene.

    One after the other would take two evaluations each, of all objects of the scene.
    """
    for first in range(0, len(wanted), _AT_ONCE):
        some = wanted[first : first + _AT_ONCE]
        yield from _rest_meshes_of(some, [None] * len(some))


def _made(found: _Made | MeshError) -> _Made:
    """What was made. Raises the error in place of it."""
    if isinstance(found, MeshError):
        raise found
    return found


def _rest_meshes_of(
    wanted: Wanted, entered: Sequence[Mesh | None]
) -> list[tuple[Mesh, Mesh | None] | MeshError]:
    """For each what ``rest_meshes`` makes, or its error."""
    with _stand_ins((obj, kind_of(obj).position(obj, deformer)) for obj, deformer in wanted) as copies:
        shown = [mesh for mesh in entered if mesh is not None]
        if shown:
            bpy.context.view_layer.update()
        else:
            shown = _rest_meshes(wanted, copies)
        depsgraph = bpy.context.view_layer.depsgraph  # to ask for another evaluates again
        evaluated = [copy.evaluated_get(depsgraph) for copy in copies]
        differing = [
            i
            for i, copy in enumerate(evaluated)
            if isinstance(shown[i], Mesh) and _differs_in_renders(copy, copy.modifiers)
        ]
        rendered: dict[int, Mesh | MeshError] = {}
        if differing:
            others = [copies[i] for i in differing]
            made = _rendered_meshes([wanted[i] for i in differing], others, [shown[i] for i in differing])
            rendered = dict(zip(differing, made, strict=True))
    return [_paired(mesh, rendered.get(i), entered[i] is None) for i, mesh in enumerate(shown)]


def _paired(
    shown: Mesh | MeshError, rendered: Mesh | MeshError | None, is_ours: bool
) -> tuple[Mesh, Mesh | None] | MeshError:
    """The rest meshes for viewports and for renders. What is not needed is removed.

    ``is_ours``: whether the one for viewports is to be removed, too, if the other is refused.
    """
    if isinstance(shown, MeshError):
        return shown
    if isinstance(rendered, Mesh) and not _same_point_type(shown, rendered):
        bpy.data.meshes.remove(rendered)
        rendered = MeshError(
            "Modifiers before Sinew make a surface in renders only, or in viewports only - let both agree"
        )
    if isinstance(rendered, MeshError):
        if is_ours:
            bpy.data.meshes.remove(shown)
        return rendered
    if rendered is not None and same_topology(shown, rendered):
        bpy.data.meshes.remove(rendered)
        rendered = None
    return shown, rendered


def _same_point_type(shown: Mesh, rendered: Mesh) -> bool:
    return shown.get(Keys.REST_POINT_TYPE) == rendered.get(Keys.REST_POINT_TYPE)


def differs_in_renders(obj: Object, deformer: SinewDeformer) -> bool:
    """Whether other vertices may enter the deformer in renders."""
    return _differs_in_renders(obj, kind_of(obj).modifiers_before(obj, deformer))


def render_signature(obj: Object, deformer: SinewDeformer) -> tuple:
    """The settings that decide what enters the deformer in renders alone. For comparison."""
    kind = kind_of(obj)
    if not kind.RENDERS_MAY_DIFFER:
        return ()
    return render_settings.signature(obj, kind.modifiers_before(obj, deformer))


def _differs_in_renders(obj: Object, modifiers: Sequence[Modifier]) -> bool:
    """Whether other vertices may come out of these modifiers of an object in renders."""
    return kind_of(obj).RENDERS_MAY_DIFFER and render_settings.differ(obj, modifiers)


def _rendered_meshes(
    wanted: Wanted, copies: Sequence[Object], shown: Sequence[Mesh]
) -> list[Mesh | MeshError]:
    """The rest meshes for renders of copies, or why there is none.

    Deformers before ours show other vertices in renders, but not here. So they are switched off, and what
    they have made of the mesh for viewports, which is ``shown``, carries the one for renders along.
    """
    ours = [modifier for copy in copies for modifier in copy.modifiers if node_group.is_ours(modifier)]
    for modifier in ours:
        modifier.show_viewport = modifier.show_render = False
    before: Sequence[Mesh | MeshError] = _rest_meshes(wanted, copies) if ours else shown
    with render_settings.applied(copies):
        made = _rest_meshes(wanted, copies)
    for plain, rendered, mesh in zip(before, made, shown, strict=True):
        if isinstance(plain, Mesh) and isinstance(rendered, Mesh) and plain != mesh:
            write_positions(rendered, carried(rendered, plain, read_positions(mesh)))
    if ours:
        bpy.data.batch_remove([mesh for mesh in before if isinstance(mesh, Mesh)])
    return made


def carried(mesh: Mesh, beside: Mesh, places: np.ndarray) -> np.ndarray:
    """Where the vertices of a mesh are, float32 (k, 3), if those of the one ``beside`` it are at ``places``.

    ``places`` are (n, 3). Both meshes are of the same shape, such as those for viewports and for renders.
    """
    before = read_positions(beside)
    if before.shape != places.shape or np.array_equal(before, places):
        return read_positions(mesh)
    return _attached(mesh, beside).at(places).astype(np.float32)


def carry_lost_groups(mesh: Mesh, beside: Mesh, wanted: set[str]) -> None:
    """Let a rest mesh take over the weights of deleted groups from the one ``beside`` it.

    Both are of the same shape, as for ``carried``.
    """
    keep_lost_groups(
        mesh, beside, wanted, lambda weights: _attached(mesh, beside).blended(weights).astype(np.float32)
    )


def _attached(mesh: Mesh, beside: Mesh) -> AttachedPoints:
    """The vertices of a mesh on the surface of one ``beside`` it."""
    places, points = (np.nan_to_num(read_positions(each).astype(np.float64)) for each in (beside, mesh))
    return AttachedPoints(points, Surface(places, read_triangles(beside), read_edges(beside)))


def viewport_points(obj: Object) -> AttachedPoints | None:
    """The points that viewports show of an object, on what renders show of it; None if that is the same.

    Deformers are left out: their shapes for viewports do not fit what renders show.
    """
    if not _differs_in_renders(obj, obj.modifiers):
        return None
    with _stand_ins([(obj, len(obj.modifiers))]) as (copy,):
        for modifier in copy.modifiers:
            if node_group.is_ours(modifier):
                modifier.show_viewport = modifier.show_render = False
        shown = _new_mesh(copy)
        with render_settings.applied([copy]):
            rendered = _new_mesh(copy)
    same = same_topology(shown, rendered)
    found = None if same or not len(rendered.vertices) else _attached(shown, rendered)
    bpy.data.batch_remove([shown, rendered])
    return found


def _new_mesh(obj: Object) -> Mesh:
    """What an object is as a mesh now, as ``points_shown`` reads it."""
    if targets.is_cloud(obj):
        return _new_meshes([obj])[0]
    bpy.context.view_layer.update()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    return bpy.data.meshes.new_from_object(obj.evaluated_get(depsgraph), depsgraph=depsgraph)


def _rest_meshes(wanted: Wanted, copies: Iterable[Object]) -> list[Mesh | MeshError]:
    """The rest meshes that the copies show now, or why there is none."""
    with ExitStack() as stack:
        for (obj, deformer), copy in zip(wanted, copies, strict=True):
            names = [group.name for group in obj.vertex_groups]
            few = len(names) <= FEW_GROUPS
            kept = names if few else vertex_groups.groups_in_use(deformer) & set(names)
            if kind_of(obj).READS_ALL_WEIGHTS:
                continue
            painted = {weights_attribute(names.index(name)): name for name in kept}
            stack.enter_context(vertex_groups.keeping_weights(copy, painted))
        meshes = _new_meshes(copies)
    return [_as_rest(mesh, obj) for mesh, (obj, _) in zip(meshes, wanted, strict=True)]


def _as_rest(mesh: Mesh, obj: Object) -> Mesh | MeshError:
    """A new mesh of an object, named and marked as a rest mesh; or why it can be none."""
    if not targets.is_mesh(obj):
        mesh[Keys.REST_POINT_TYPE] = kind_of(obj).take_point_type(mesh).id
        mesh[Keys.REST_STRUCTURE] = targets.structure(obj)
    if len(mesh.vertices) == 0:
        point_type = point_type_with_id(mesh.get(Keys.REST_POINT_TYPE))
        bpy.data.meshes.remove(mesh)
        what = "mesh has no vertices" if point_type is MESH else "object has no points"
        return MeshError(f"The {what} - add some, or check the modifiers before Sinew")
    mesh.name = Datablocks.REST
    mesh.materials.clear()
    mesh[Keys.REST_TOKEN] = shapes.new_key()
    mesh[Keys.REST_GROUPS] = [group.name for group in obj.vertex_groups]
    return mesh

# SPDX-License-Identifier: GPL-3.0-or-later
"""Makes and removes objects whose vertices move the points of control grids. Main thread only."""

from collections.abc import Iterator

import bpy
from bpy.types import Object, PropertyGroup

from ....core.errors import OptionError
from ....core.labels import label_of, names_of
from ....core.methods import METHODS, GridPoints, Method, Parameter
from ....properties import SinewDeformer, deformers_of
from ...controls import kinds
from ...datablocks import grids
from ...results import result
from ...state import sessions


def has_grid(deformer: SinewDeformer) -> bool:
    """Whether the method has control grids. Those of a base method have to be made while it works alone."""
    return _grid_of(deformer.definition) is not None


def with_grids() -> str:
    """The names of the methods that have a control grid."""
    return names_of(method for method in METHODS if _grid_of(method))


@sessions.suspended()
def new_grid(obj: Object, deformer: SinewDeformer) -> Object:
    """A mesh object with the control grids of the rest shape, whose vertices move their points from now on.

    If the deformer has one already, that gets a new mesh, and moves nothing at first.
    """
    name = _grid_of(deformer.definition)
    if name is None:
        raise OptionError(f"{label_of(deformer.definition)} has no control grid - {with_grids()} has one")
    values = deformer.parameters
    known = getattr(values, name)
    if known is not None and not grids.is_grid(known):
        known = None
    if known is not None and known.mode == "EDIT":
        raise OptionError(f"{known.name} is in Edit Mode - leave it first")
    found = result.rest_grids(deformer)
    if not found:
        raise OptionError("The control grid is not known yet - add regions, and bind")
    mesh = grids.make_mesh(f"{obj.name} Grid", found)
    if known is None:
        known = bpy.data.objects.new(mesh.name, mesh)
        known.show_in_front = True
        known.hide_render = True
        known.parent = obj
    else:
        old, known.data = known.data, mesh
        if old.users == 0:
            bpy.data.meshes.remove(old)
    if not known.users_scene:
        for collection in obj.users_collection or (bpy.context.scene.collection,):
            collection.objects.link(known)
    setattr(values, name, known)
    kinds.keep_evaluated(obj)
    bpy.context.view_layer.update()
    return known


def release_grids(obj: Object, deformer: SinewDeformer) -> None:
    """Remove the objects that ``new_grid`` made for a deformer, unless another deformer uses them."""
    for values, name in _all(deformer):
        grid = getattr(values, name)
        setattr(values, name, None)
        if not grids.is_grid(grid) or grid.parent != obj or grid.library is not None or _is_used(grid):
            continue
        mesh = grid.data
        bpy.data.objects.remove(grid)
        if mesh.users == 0:
            bpy.data.meshes.remove(mesh)


def _grid_of(method: Method) -> str | None:
    """The parameter of the method that is a grid, if it has one."""
    grids_of = (parameter.id for parameter in method.references if _is_grid(parameter))
    return next(grids_of, None)


def _is_grid(parameter: Parameter) -> bool:
    return isinstance(parameter, GridPoints)


def _all(deformer: SinewDeformer) -> Iterator[tuple[PropertyGroup, str]]:
    """The parameters of all methods that are grids, each as a name in its property group."""
    for method in METHODS:
        for parameter in method.references:
            if _is_grid(parameter):
                yield getattr(deformer, method.id), parameter.id


def _is_used(grid: Object) -> bool:
    return any(
        getattr(values, name) == grid
        for obj in bpy.data.objects
        for deformer in deformers_of(obj)
        for values, name in _all(deformer)
    )

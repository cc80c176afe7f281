# SPDX-License-Identifier: GPL-3.0-or-later
"""Parameters whose value lies in another datablock: curves that an artist draws, objects, and UV maps.

No property of Blender holds a curve, so each curve is held by the single node of a node tree of its own. A
parameter without a tree has its default curve.
"""

from collections.abc import Iterator

import bpy
import numpy as np
from bpy.types import CurveMapping, NodeTree, Object, PropertyGroup, ShaderNodeFloatCurve

from ...backend import AxisBox, Shape
from ...compat import read_faces, read_positions
from ...core.errors import OptionError
from ...core.geometry import frames
from ...core.methods import METHODS, Box, Curve, GridPoints, MeshObject, MeshShape, Parameter, Pointer, UvMap
from ...ids import Datablocks, Keys
from ...mesh_io import RestShape, read_rest
from ...properties import SinewDeformer
from . import grids

_NODE = "ShaderNodeFloatCurve"


def curve_node(values: PropertyGroup, parameter: Curve) -> ShaderNodeFloatCurve | None:
    """The node whose ``mapping`` is the curve; None if the parameter has its default curve.

    ``values`` are the parameters of a method, as in ``SinewDeformer.methods``.
    """
    tree = getattr(values, parameter.id)
    nodes = tree.nodes if isinstance(tree, NodeTree) else ()
    return next((node for node in nodes if node.bl_idname == _NODE), None)


def edit_curve(values: PropertyGroup, parameter: Curve) -> CurveMapping:
    """A curve that can be changed, at first the default one. A script that changes it must tag its tree."""
    node = curve_node(values, parameter)
    if node is None:
        tree = bpy.data.node_groups.new(Datablocks.CURVE, "ShaderNodeTree")
        tree[Keys.CURVE] = parameter.id
        node = tree.nodes.new(_NODE)
        _draw(node.mapping, parameter.default)
        setattr(values, parameter.id, tree)
    return node.mapping


def reset_curve(values: PropertyGroup, name: str) -> None:
    """Give the parameter of this name its default curve again."""
    tree = getattr(values, name)
    setattr(values, name, None)
    if tree is not None and tree.users == 0 and tree.library is None:
        bpy.data.node_groups.remove(tree)


def unshare_curves(deformer: SinewDeformer) -> None:
    """Give a copied deformer curves of its own."""
    for values, name in _drawn(deformer):
        setattr(values, name, getattr(values, name).copy())


def release_curves(deformer: SinewDeformer) -> None:
    """Remove the curves that only this deformer uses."""
    for values, name in _drawn(deformer):
        reset_curve(values, name)


def _drawn(deformer: SinewDeformer) -> Iterator[tuple[PropertyGroup, str]]:
    """The curves of all methods that an artist has drawn."""
    for method in METHODS:
        for parameter in method.references:
            values = getattr(deformer, method.id)
            if isinstance(parameter, Curve) and getattr(values, parameter.id) is not None:
                yield values, parameter.id


def pointed(deformer: SinewDeformer) -> Iterator[tuple[Object, bool]]:
    """The objects that parameters refer to, and whether their shapes count."""
    for values, parameter in _referring(deformer):
        obj = getattr(values, parameter.id)
        if isinstance(parameter, Pointer) and obj is not None:
            yield obj, isinstance(parameter, (GridPoints, MeshObject))


def has_mesh_shape(settings: SinewDeformer) -> bool:
    """Whether a parameter of its methods names another shape of the mesh."""
    return any(
        isinstance(parameter, MeshShape) and getattr(values, parameter.id) is not None
        for values, parameter in _referring(settings)
    )


def uv_maps(settings: SinewDeformer) -> dict[str, Parameter]:
    """The UV maps that parameters name, each with one of these parameters."""
    return {
        getattr(values, parameter.id): parameter
        for values, parameter in _referring(settings)
        if isinstance(parameter, UvMap) and getattr(values, parameter.id)
    }


def _referring(settings: SinewDeformer) -> Iterator[tuple[PropertyGroup, Parameter]]:
    for method, values in settings.methods:
        for parameter in method.references:
            yield values, parameter


def box(values: PropertyGroup, parameter: Box, rest: RestShape, of_boxes: bool) -> object:
    """The frame (3, 4) of a cube from -1 to 1; or what the box is around, None for all points and handles.

    ``of_boxes``: it is one along the axes.
    """
    chosen = value(values, parameter)
    if isinstance(chosen, np.ndarray):
        return chosen
    if of_boxes:
        return AxisBox(rest.points, rest.frame)
    return Shape(rest.points, (rest.counts, rest.corners)) if len(rest.counts) else None


def compared(values: PropertyGroup, parameter: Parameter) -> object:
    """The value of a parameter in a form that can be compared."""
    if isinstance(parameter, Curve):
        return _points(values, parameter)
    if isinstance(parameter, UvMap):
        return getattr(values, parameter.id)
    if isinstance(parameter, MeshShape):
        obj = _unevaluated(values, parameter)
        return obj and (obj.name_full, obj.data.name_full, len(obj.data.vertices), len(obj.data.loops))
    found = value(values, parameter)
    if isinstance(found, Shape):
        return tuple(part.tobytes() for part in (found.points, *found.faces))
    return None if found is None else found.tobytes()


def placed(settings: SinewDeformer) -> list[object]:
    """The same for all parameters, but quicker: the points of curves, and the matrices of objects.

    The shape of an object is only read where it counts.
    """
    return [
        _matrix(values, parameter)
        if isinstance(parameter, Pointer) and not isinstance(parameter, MeshObject)
        else compared(values, parameter)
        for values, parameter in _referring(settings)
    ]


def value(values: PropertyGroup, parameter: Parameter) -> np.ndarray | Shape | None:
    """The value in the form that the native module takes: see ``Curve``, ``Pointer`` and its kinds."""
    if isinstance(parameter, Curve):
        return _samples(values, parameter)
    obj = getattr(values, parameter.id)
    if obj is None:
        return None
    target = np.array(values.id_data.matrix_world, dtype=np.float64)
    if isinstance(parameter, GridPoints):
        return grids.moves(obj, target)
    frame = (frames.inverse(target, "The mesh object") @ np.array(obj.matrix_world, dtype=np.float64))[:3]
    if not isinstance(parameter, MeshObject):
        return frame
    mesh = obj.original.data
    points = read_positions(mesh).astype(np.float64) @ frame[:, :3].T + frame[:, 3]
    counts, corners = read_faces(mesh)
    return Shape(np.ascontiguousarray(points), (counts, frames.corners_after(frame, counts, corners)))


def mesh_shape(values: PropertyGroup, parameter: MeshShape, rest: RestShape) -> Shape | None:
    """The mesh that the parameter refers to, at rest. It has to have the faces of ``rest``."""
    obj = _unevaluated(values, parameter)
    if obj is None:
        return None
    found = read_rest(obj.data)
    counts = [f"{len(shape.points):,} vertices and {len(shape.counts):,} faces" for shape in (found, rest)]
    if counts[0] != counts[1]:
        raise OptionError(
            f"{parameter.label}: {obj.name} has {counts[0]}, and this mesh {counts[1]} - choose a copy of "
            "this mesh that was only reshaped"
        )
    faces = rest.counts, rest.corners
    if frames.turned_faces(faces, (found.counts, found.corners)) is None:
        raise OptionError(
            f"{parameter.label}: the faces of {obj.name} have other vertices than those of this mesh - "
            "choose a copy of this mesh that was only reshaped"
        )
    if len(found.not_finite):
        raise OptionError(
            f"{parameter.label}: {len(found.not_finite):,} vertices of {obj.name} are not finite, the first "
            f"is {found.not_finite[0]} - mend that mesh"
        )
    return Shape(found.points, faces)


def _unevaluated(values: PropertyGroup, parameter: MeshShape) -> Object | None:
    """The object that a parameter refers to, without its modifiers also where ``values`` are evaluated."""
    obj = getattr(values, parameter.id)
    return obj and obj.original


def _matrix(values: PropertyGroup, parameter: Parameter) -> object:
    obj = getattr(values, parameter.id)
    if obj is None:
        return None
    world = obj.matrix_world.copy().freeze()
    if not isinstance(parameter, GridPoints):
        return world
    try:
        found = grids.read(obj)
    except OptionError as error:
        return str(error)  # the solve raises it
    return None if found is None else (world, hash(found[0].tobytes()))


def _draw(mapping: CurveMapping, points: tuple[tuple[float, float], ...]) -> None:
    """Draw straight lines between ``points``. A new curve has two points already."""
    drawn = mapping.curves[0].points
    for _more in points[2:]:
        drawn.new(0.5, 0.5)
    for point, place in zip(drawn, points, strict=True):
        point.location, point.handle_type = place, "VECTOR"
    mapping.update()


def _points(values: PropertyGroup, parameter: Curve) -> tuple:
    node = curve_node(values, parameter)
    if node is None:
        return parameter.default
    mapping = node.mapping
    drawn = tuple((*point.location, point.handle_type) for point in mapping.curves[0].points)
    clip = (mapping.use_clip, mapping.clip_min_y, mapping.clip_max_y)
    return (drawn, mapping.extend, clip)


def _samples(values: PropertyGroup, parameter: Curve) -> np.ndarray:
    node = curve_node(values, parameter)
    if node is None:
        return parameter.native_default
    steps = np.linspace(0.0, 1.0, parameter.samples)
    mapping = node.mapping
    mapping.initialize()
    found = np.array([mapping.evaluate(mapping.curves[0], step) for step in steps])
    if not np.isfinite(found).all():
        raise OptionError(f"{parameter.label} is not a number everywhere - draw its curve again")
    return found

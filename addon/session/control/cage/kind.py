# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage moves the shape: an ordinary mesh object around it, as its own modifiers leave it. See ``kinds``.

The rest cage is kept as a hidden mesh in the frame of the target, so everything done to the cage later is a
pose, in Edit Mode too.
"""

from collections.abc import Iterator

import bmesh
import bpy
import numpy as np
from bpy.types import Depsgraph, Mesh, Object
from mathutils import Matrix

from ....backend import Cage, CageReport, Recipe, Shape
from ....core.elements import NO_ELEMENTS, Elements, Owner
from ....core.errors import CageError
from ....core.geometry import frames
from ....core.methods import Method
from ....core.status import Level, Remedy, Status
from ....ids import Datablocks, Keys
from ....mesh_io import RestShape, read_rest
from ....properties import SinewDeformer, StoredCage
from ...blocks import shapes
from ...blocks.keeper import Link
from ...blocks.vertex_groups import read_weights
from ...memory.evaluation import ControlState, Evaluation
from ...memory.sessions import Bound
from .. import objects, placement
from ..bind_input import BindInput, options
from ..influence import Influence

MISSING = "No cage yet - Add Cage takes the other selected mesh"

MARKS_REGIONS = False

_POSE = "cage"  # the key of its last pose among the session's poses


def name(_method: Method) -> str:
    """The coordinates of a cage are tried one after the other, so they are not its name."""
    return "Cage"


def is_set(settings: SinewDeformer) -> bool:
    """A cage was chosen, now or at bind."""
    return settings.cage is not None or isinstance(settings.cage_rest, Mesh)


def key(settings: SinewDeformer) -> tuple:
    """Which rest cage."""
    rest = settings.cage_rest
    return (rest.get(Keys.REST_TOKEN, "") if isinstance(rest, Mesh) else "",)


def request(settings: SinewDeformer, mesh: Mesh, rest: RestShape, key: tuple, base_count: int) -> BindInput:
    """Arrays for the native module, or the reason why there are none."""
    if not isinstance(settings.cage_rest, Mesh):
        raise CageError("The cage is not bound yet - press Bind", remedy=Remedy.BIND)
    read_weights(rest, mesh, settings)
    cage = read_rest(settings.cage_rest)
    if not len(cage.points):
        raise CageError("The cage has no vertices - add some, then Set Rest Cage", remedy=Remedy.CAGE_REST)
    if len(cage.not_finite):
        raise CageError(
            "Vertices of the cage are nowhere - move or delete them, then Set Rest Cage",
            Elements(Owner.CONTROL, "vertex", cage.not_finite),
            Remedy.CAGE_REST,
        )
    return BindInput(
        key=key,
        recipe=Recipe(
            settings.definition,
            Shape(rest.points, (rest.counts, rest.corners)),
            options(settings, rest),
            Cage(cage.points, (cage.counts, cage.corners)),
        ),
        rest=rest,
        on_base=len(rest.points) == base_count,
        control=f"a cage of {len(cage.points):,}",
    )


def notes(report: CageReport, request: BindInput) -> tuple[Status, ...]:
    """Points that the cage does not hold; its faces that cross."""
    found, count = [], len(report.outside)
    if count:
        one, several = request.rest.point_type.nouns
        text = f"1 {one} lies outside the cage" if count == 1 else f"{count:,} {several} lie outside the cage"
        elements = Elements(Owner.TARGET, "vertex", report.outside) if request.on_base else NO_ELEMENTS
        found.append(Status(Level.WARNING, text, elements))
    if len(report.crossing):
        text = f"{len(report.crossing):,} faces of the cage cross each other"
        found.append(Status(Level.WARNING, text, Elements(Owner.CONTROL, "face", report.crossing)))
    return tuple(found)


def selectable(elements: Elements, _request: BindInput) -> Elements:
    """Those of the cage and of the target are told apart already."""
    return elements


def object_with(deformer: SinewDeformer, elements: Elements) -> Object:
    """The cage, where it has its ``elements`` still; else the reason why they cannot be selected."""
    cage, rest = deformer.cage, deformer.cage_rest
    if cage is None:
        raise CageError("The cage is not in this view layer - nothing to select")
    if isinstance(rest, Mesh) and len(cage.data.vertices) != len(rest.vertices):
        raise CageError(
            "The cage has other vertices than its rest - turn off its modifiers, then Set Rest Cage"
        )
    return cage


def read(deformer: SinewDeformer, depsgraph: Depsgraph) -> ControlState:
    """The place of the cage, with its vertices."""
    return [placement.read_place(deformer.cage, depsgraph, by_shape=True)]


def pose(evaluation: Evaluation, bound: Bound) -> tuple[np.ndarray, dict[str, np.ndarray]] | None:
    """The cage's vertices (c, 3) in the frame of the target; without a cage as they were last, if known."""
    held, (place,) = evaluation.session.poses, evaluation.control
    if place is None or evaluation.deformer.cage_missing:
        return (held[_POSE], {}) if _POSE in held else None
    vertices, expected = place.vertices, len(bound.factor.recipe.control.points)
    if len(vertices) != expected:
        raise CageError(
            f"The cage has {len(vertices):,} vertices, at bind it had {expected:,} - Set Rest Cage takes it "
            "as it is now",
            remedy=Remedy.CAGE_REST,
        )
    world = np.array(evaluation.evaluated.matrix_world, dtype=np.float64)
    relative = frames.inverse(world, "The mesh object") @ place.matrix()
    with np.errstate(invalid="ignore"):  # said below
        posed = frames.transformed(relative, vertices.astype(np.float64))
    lost = np.flatnonzero(~frames.are_valid(posed))
    if len(lost):
        elements = Elements(Owner.CONTROL, "vertex", lost)
        raise CageError("Vertices of the cage are nowhere - undo, or move them", elements)
    held[_POSE] = posed
    return posed, {}


def is_stale(deformer: SinewDeformer) -> bool:
    """The cage gained or lost vertices since it was bound."""
    if deformer.cage_missing or not isinstance(deformer.cage_rest, Mesh):
        return False
    found = placement.read_vertices(deformer.cage, bpy.context.evaluated_depsgraph_get())
    return len(found) != len(deformer.cage_rest.vertices)


def set_rest(obj: Object, deformer: SinewDeformer) -> None:
    """The cage rests where it is, unless it has a rest already."""
    if deformer.cage is not None and not isinstance(deformer.cage_rest, Mesh):
        take_rest(obj, deformer)


def take_rest(obj: Object, deformer: SinewDeformer) -> None:
    """The cage rests as it is now. Makes a datablock: for operators."""
    cage = deformer.cage
    if cage is None:
        raise CageError(MISSING)
    cage.update_from_editmode()
    depsgraph = bpy.context.evaluated_depsgraph_get()
    evaluated = cage.evaluated_get(depsgraph)
    mesh = bpy.data.meshes.new_from_object(evaluated, depsgraph=depsgraph)
    relative = frames.inverse(np.array(obj.matrix_world, dtype=np.float64), obj.name)
    mesh.transform(Matrix((relative @ np.array(evaluated.matrix_world, dtype=np.float64)).tolist()))
    mesh.name = Datablocks.REST
    mesh.materials.clear()
    mesh[Keys.REST_TOKEN] = shapes.new_key()
    objects.hold_rest(StoredCage(deformer), mesh)


def forget_rest(deformer: SinewDeformer) -> None:
    """Forget how the cage rested."""
    objects.forget_rest((StoredCage(deformer),))


def links(deformer: SinewDeformer) -> Iterator[Link]:
    """The cage, with its shape."""
    return objects.links((StoredCage(deformer),))


def lost(deformer: SinewDeformer) -> tuple[str, ...]:
    """The cage was deleted."""
    is_lost = deformer.is_bound and deformer.cage_missing
    return ("The cage was deleted, and the last shape stays - pick another",) if is_lost else ()


def release(_obj: Object, deformer: SinewDeformer) -> None:
    """Remove the cage made for a deformer, unless another deformer uses it."""
    objects.release((StoredCage(deformer),))


def selected(deformer: SinewDeformer) -> tuple[int, ...]:
    """The vertices selected on the cage, in Edit Mode or before it was left."""
    cage = deformer.cage
    if cage is None or cage.type != "MESH":
        return ()
    if cage.mode == "EDIT":
        return tuple(vertex.index for vertex in bmesh.from_edit_mesh(cage.data).verts if vertex.select)
    chosen = np.empty(len(cage.data.vertices), dtype=bool)
    cage.data.vertices.foreach_get("select", chosen)
    return tuple(np.flatnonzero(chosen).tolist())


def influence(deformer: SinewDeformer, bound: Bound) -> Influence:
    """How far each vertex goes with those selected on the cage.

    Modifiers of the cage keep the numbers of its own vertices, or add others after them.
    """
    factor = bound.factor
    vertices = tuple(v for v in selected(deformer) if v < len(factor.recipe.control.points))
    return Influence(vertices, factor.influence(vertices), factor.report.outside)

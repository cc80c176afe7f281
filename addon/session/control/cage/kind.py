# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage moves the shape: an ordinary mesh object around it, after its own modifiers. See ``kinds``.

The rest cage is stored as a hidden mesh in the frame of the target. So whatever is done to the cage later is
a pose, also in Edit Mode.
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
from ....core.status import Level, Remedy, Status
from ....ids import Datablocks, Keys
from ....mesh_io import RestShape
from ....properties import SinewDeformer, StoredCage
from ...blocks import libraries, rest_frame, shapes
from ...blocks.keeper import Link
from ...blocks.vertex_groups import read_weights
from ...memory.evaluation import ControlState, Evaluation
from ...memory.sessions import Bound
from .. import objects, placement
from ..bind_input import BindInput, options, unpainted
from ..influence import Influence

MISSING = "No cage yet - Add Cage takes the other selected mesh"

MARKS_REGIONS = False

_POSE = "cage"  # the key of the last pose of the cage in ``Session.poses``


def is_set(settings: SinewDeformer) -> bool:
    """Whether there is a cage, or there was one at bind."""
    return settings.cage is not None or isinstance(settings.cage_rest, Mesh)


def key(settings: SinewDeformer) -> tuple:
    """The token of the rest cage."""
    rest = settings.cage_rest
    return (rest.get(Keys.REST_TOKEN, "") if isinstance(rest, Mesh) else "",)


def request(settings: SinewDeformer, mesh: Mesh, rest: RestShape, key: tuple, base_count: int) -> BindInput:
    """The arrays for the native module. Raises a ``SinewError`` if the cage cannot be bound."""
    if not isinstance(settings.cage_rest, Mesh):
        raise CageError("The cage is not bound yet - press Rebind", remedy=Remedy.BIND)
    read_weights(rest, mesh, settings)
    cage = rest_frame.read(settings, settings.cage_rest)
    if not len(cage.points):
        raise CageError("The cage has no vertices - add some, then Set Rest Cage", remedy=Remedy.CAGE_REST)
    if len(cage.not_finite):
        raise _invalid(cage.not_finite, "move or delete them, then Set Rest Cage", Remedy.CAGE_REST)
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
        unpainted=unpainted(settings, rest),
    )


def notes(report: CageReport, request: BindInput) -> tuple[Status, ...]:
    """Warnings about points outside the cage, and about faces of the cage that cross each other."""
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
    """The same elements: they name their owner, the cage or the target, already."""
    return elements


def object_with(deformer: SinewDeformer, elements: Elements) -> Object:
    """The cage. Raises a ``CageError`` if it no longer has the ``elements`` of its rest."""
    cage, rest = deformer.cage, deformer.cage_rest
    if cage is None:
        raise CageError("The cage is not in this view layer - nothing to select")
    _refuse_other_type(cage)
    if isinstance(rest, Mesh) and len(cage.data.vertices) != len(rest.vertices):
        raise CageError(
            "The cage has other vertices than its rest - turn off its modifiers, then Set Rest Cage"
        )
    return cage


def _invalid(vertices: np.ndarray, advice: str, remedy: Remedy = Remedy.NONE) -> CageError:
    """The refusal of a cage with such vertices."""
    nouns = "1 cage vertex has" if len(vertices) == 1 else f"{len(vertices):,} cage vertices have"
    text = f"{nouns} invalid coordinates (NaN or infinite) - {advice}"
    return CageError(text, Elements(Owner.CONTROL, "vertex", vertices), remedy)


def read_state(deformer: SinewDeformer, depsgraph: Depsgraph) -> ControlState:
    """The place of the cage and its vertices."""
    return [placement.read_place(deformer.cage, depsgraph, by_shape=True)]


def pose(evaluation: Evaluation, bound: Bound) -> tuple[np.ndarray, dict[str, np.ndarray]] | None:
    """The vertices of the cage (c, 3) in the frame of the target; without a cage the last known ones."""
    held, (place,) = evaluation.session.poses, evaluation.control
    cage = evaluation.deformer.cage
    if place is None and cage is not None and not libraries.is_lost(cage):
        _refuse_other_type(cage)
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
    with np.errstate(invalid="ignore"):  # refused below
        posed = frames.transformed(relative, vertices.astype(np.float64))
    lost = np.flatnonzero(~frames.are_valid(posed))
    if len(lost):
        raise _invalid(lost, "undo, or move them")
    held[_POSE] = posed
    return posed, {}


def is_stale(deformer: SinewDeformer) -> bool:
    """Whether the cage has gained or lost vertices since it was bound."""
    if deformer.cage_missing or not isinstance(deformer.cage_rest, Mesh):
        return False
    depsgraph = bpy.context.evaluated_depsgraph_get()
    place = placement.read_place(deformer.cage, depsgraph, by_shape=True)
    return place is not None and len(place.vertices) != len(deformer.cage_rest.vertices)


def set_rest(obj: Object, deformer: SinewDeformer) -> None:
    """Let the cage rest where it is, unless it has a rest already."""
    if deformer.cage is not None and not libraries.is_lost(deformer.cage):
        _refuse_other_type(deformer.cage)
    if deformer.cage is not None and not isinstance(deformer.cage_rest, Mesh):
        take_rest(obj, deformer)


def take_rest(obj: Object, deformer: SinewDeformer) -> None:
    """Let the cage rest as it is now. This makes a datablock, so handlers may not call it."""
    cage = deformer.cage
    if cage is None:
        raise CageError(MISSING)
    if libraries.is_lost(cage):
        raise CageError(libraries.explain(cage))
    _refuse_other_type(cage)
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


def take_along(_deformer: SinewDeformer, by: np.ndarray, held: dict[str, np.ndarray]) -> None:
    """The last pose follows; the rest of the cage is a stored rest shape, and follows by itself."""
    if _POSE in held:
        held[_POSE] = frames.transformed(by, held[_POSE])


def keep_pose(_deformer: SinewDeformer, _held: dict[str, np.ndarray]) -> None:
    """Nothing: without its cage, the last shape stays as the file has stored it."""


def forget_rest(deformer: SinewDeformer) -> None:
    """Forget the rest of the cage."""
    objects.forget_rest((StoredCage(deformer),))


def use(obj: Object, deformer: SinewDeformer, control: Object, owned: bool) -> None:
    """Use a mesh object as the cage. It is drawn as wire, and rests where it is at the bind."""
    if control == obj:
        raise CageError(f"{obj.name} cannot be its own cage - choose another mesh")
    _refuse_other_type(control)
    if _leads_to(control, obj):
        raise CageError(
            f"{control.name} follows {obj.name} itself - choose a cage that does not depend on it"
        )
    deformer.cage, deformer.owns_cage = control, owned
    if control.library is None:
        control.display_type = "WIRE"
        control.hide_render = True


def _refuse_other_type(cage: Object) -> None:
    if cage.type != "MESH":
        raise CageError(f"{cage.name} is no mesh - a cage is a closed mesh around the target")


def _leads_to(cage: Object, obj: Object) -> bool:
    """Whether ``obj`` is the cage of a deformer of the cage, or of a cage further along."""
    waiting, known = [cage], set()
    while waiting:
        for deformer in waiting.pop().sinew.deformers:
            if deformer.cage == obj:
                return True
            if deformer.cage is not None and deformer.cage not in known:
                known.add(deformer.cage)
                waiting.append(deformer.cage)
    return False


def links(deformer: SinewDeformer) -> Iterator[Link]:
    """The cage, whose vertices count too."""
    return objects.links((StoredCage(deformer),))


def lost(deformer: SinewDeformer) -> tuple[str, ...]:
    """A line in the panel if the cage was deleted."""
    if deformer.cage is not None and libraries.is_lost(deformer.cage):
        return (libraries.explain(deformer.cage),)
    is_lost = deformer.is_bound and deformer.cage_missing
    return ("The cage was deleted, and the last shape stays - pick another",) if is_lost else ()


def release(_obj: Object, deformer: SinewDeformer) -> None:
    """Remove the cage that was made for a deformer, unless another deformer uses it."""
    objects.release((StoredCage(deformer),))


def selected(deformer: SinewDeformer) -> tuple[int, ...]:
    """The selected vertices of the cage, in Edit Mode or as they were when it was left."""
    cage = deformer.cage
    if cage is None or cage.type != "MESH":
        return ()
    if cage.mode == "EDIT":
        return tuple(vertex.index for vertex in bmesh.from_edit_mesh(cage.data).verts if vertex.select)
    chosen = np.empty(len(cage.data.vertices), dtype=bool)
    cage.data.vertices.foreach_get("select", chosen)
    return tuple(np.flatnonzero(chosen).tolist())


def influence(deformer: SinewDeformer, bound: Bound) -> Influence:
    """How far each point follows the selected vertices of the cage.

    Modifiers of the cage keep the indices of its own vertices, and number those that they add after them.
    """
    factor = bound.factor
    vertices = tuple(v for v in selected(deformer) if v < len(factor.recipe.control.points))
    return Influence(vertices, factor.influence(vertices), factor.report.outside)

# SPDX-License-Identifier: GPL-3.0-or-later
"""What kinds of control have in common that are whole objects, such as a cage. See ``kinds``.

The rest of such an object is stored as a hidden mesh in the frame of the target. So whatever is done to the
object later is a pose, also in Edit Mode.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any

import bpy
import numpy as np
from bpy.types import Depsgraph, Mesh, Object
from mathutils import Matrix

from ...backend import ControlPoints, Recipe, Shape
from ...compat import remove_data
from ...core.elements import Elements, Owner
from ...core.errors import ConstraintError, SinewError
from ...core.geometry import frames
from ...core.status import Remedy, Status
from ...ids import Datablocks, Keys
from ...mesh_io import RestShape
from ...properties import SinewControl, SinewDeformer, SinewHandle, StoredCage, deformers_of
from ..datablocks import libraries, own_shape, rest_frame
from ..datablocks.evaluation_driver import Link
from ..datablocks.shapes import shapes
from ..datablocks.vertex_groups import read_weights
from ..state.evaluation import ControlState, Evaluation, Place
from ..state.sessions import Bound
from . import movers, placement
from .bind_input import BindInput, options, unpainted
from .influence import Influence

UNPOSED = 1e-5  # of the size of a control; its points are stored in single precision
# An object, the mesh that it had at bind, and whether it was made for the deformer.
Row = SinewControl | StoredCage


class ObjectKind:
    """An object whose points, after its own modifiers, move the target.

    ``ControlKind`` says what each function without a docstring does. Here no part of the object has weights.
    """

    MARKS_REGIONS = False
    MISSING: str
    NOUN: str  # what the object is called
    POINT, POINTS = "vertex", "vertices"  # what its points are called
    TYPE = "MESH"  # the type of the object, by Blender's name
    WANTED: str  # tells what a fitting object is
    REST_BUTTON, REST_REMEDY = "Rebind", Remedy.BIND  # what takes its rest anew
    ERROR: type[SinewError] = ConstraintError
    row: Callable[[SinewDeformer], Row]  # the place of the object in the settings
    bound_to: Callable[[RestShape], ControlPoints]  # what is bound, for the rest in the target's frame

    def read_points(self, control: Object, depsgraph: Depsgraph) -> np.ndarray:
        """The points of the object, float32 (c, 3) in its own frame."""
        return placement.read_vertices(control, depsgraph)

    def make_rest(self, control: Object, depsgraph: Depsgraph) -> Mesh:
        """A new mesh of the points, in the frame of the object."""
        return bpy.data.meshes.new_from_object(control.evaluated_get(depsgraph), depsgraph=depsgraph)

    def is_set(self, settings: SinewDeformer) -> bool:
        row = self.row(settings)
        return row.object is not None or row.rest is not None

    def key(self, settings: SinewDeformer) -> tuple:
        rest = self.row(settings).rest
        return ("" if rest is None else rest.get(Keys.REST_TOKEN, ""),)

    def request(
        self, settings: SinewDeformer, mesh: Mesh, rest: RestShape, key: tuple, base_count: int
    ) -> BindInput:
        stored = self.row(settings).rest
        if stored is None:
            raise self.ERROR(f"The {self.NOUN} is not bound yet - press Rebind", remedy=Remedy.BIND)
        read_weights(rest, mesh, settings)
        found = rest_frame.read(settings, stored)
        then = f"then {self.REST_BUTTON}"
        if not len(found.points):
            text = f"The {self.NOUN} has no {self.POINTS} - add some, {then}"
            raise self.ERROR(text, remedy=self.REST_REMEDY)
        if len(found.not_finite):
            raise self._invalid(found.not_finite, f"move or delete them, {then}", self.REST_REMEDY)
        target, given = Shape(rest.points, (rest.counts, rest.corners)), options(settings, rest)
        return BindInput(
            key=key,
            recipe=Recipe(settings.definition, target, given, self.bound_to(found)),
            rest=rest,
            on_base=len(rest.points) == base_count,
            control=self.in_words(found),
            unpainted=unpainted(settings, rest),
        )

    def in_words(self, rest: RestShape) -> str:
        """What the panel calls an object that rests so."""
        return f"a {self.NOUN} of {len(rest.points):,} {self.POINTS}"

    def notes(self, _report: Any, _request: BindInput) -> tuple[Status, ...]:
        return ()

    def selectable(self, elements: Elements, _request: BindInput) -> Elements:
        return elements

    def read_state(self, deformer: SinewDeformer, depsgraph: Depsgraph) -> ControlState:
        return [self.place(deformer, depsgraph)]

    def place(self, deformer: SinewDeformer, depsgraph: Depsgraph) -> Place | None:
        """Where the object is, with its points; None for no object, or one of another type."""
        control = self.row(deformer).object
        if control is None or control.type != self.TYPE:
            return None
        return placement.read_place(
            control, depsgraph, read_points=self.read_points, expected=self.expected(self.row(deformer))
        )

    def expected(self, row: Row) -> int:
        """How many points the object of a row had at bind."""
        return -1 if row.rest is None else self.point_count(row.rest)

    def point_count(self, rest: Mesh) -> int:
        """How many points an object with this rest mesh had at bind."""
        return len(rest.vertices)

    def pose(
        self, evaluation: Evaluation, bound: Bound, incoming: np.ndarray | None
    ) -> tuple[np.ndarray, dict[str, np.ndarray]] | None:
        """The points (c, 3) in the frame of the target; without the object the last known ones."""
        held, (place,) = evaluation.session.poses, evaluation.control
        row = self.row(evaluation.deformer)
        if place is None and row.object is not None and not libraries.is_lost(row.object):
            self.refuse_other_type(row.object)
        if place is None or row.missing:
            return (held[self.NOUN], {}) if self.NOUN in held else None
        points, expected = place.vertices, len(bound.factor.recipe.control.points)
        if len(points) != expected:
            raise self.ERROR(
                f"The {self.NOUN} has {len(points):,} {self.POINTS}, at bind it had {expected:,} - "
                f"{self.REST_BUTTON} takes it as it is now",
                remedy=self.REST_REMEDY,
            )
        world = np.array(evaluation.evaluated.matrix_world, dtype=np.float64)
        relative = frames.inverse(world, "The mesh object") @ place.matrix()
        with np.errstate(invalid="ignore"):  # refused below
            posed = frames.transformed(relative, points.astype(np.float64))
        lost = np.flatnonzero(~frames.are_valid(posed))
        if len(lost):
            raise self._invalid(lost, "undo, or move them")
        held[self.NOUN] = posed
        return posed, {}

    def _invalid(self, points: np.ndarray, advice: str, remedy: Remedy = Remedy.NONE) -> SinewError:
        """The refusal of an object with such points."""
        one = f"1 {self.NOUN} {self.POINT} has"
        nouns = one if len(points) == 1 else f"{len(points):,} {self.NOUN} {self.POINTS} have"
        text = f"{nouns} invalid coordinates (NaN or infinite) - {advice}"
        return self.ERROR(text, Elements(Owner.CONTROL, "vertex", points), remedy)

    def refuse_other_type(self, control: Object) -> None:
        """Raises a ``SinewError`` unless the object is of the type that is needed."""
        if control.type != self.TYPE:
            raise self.ERROR(f"{control.name} is no {self.TYPE.lower()} - {self.WANTED}")

    def is_stale(self, deformer: SinewDeformer, depsgraph: Depsgraph) -> bool:
        row = self.row(deformer)
        if row.missing or row.rest is None:
            return False
        place = self.place(deformer, depsgraph)
        return place is not None and len(place.vertices) != len(row.rest.vertices)

    def set_rest(self, obj: Object, deformer: SinewDeformer, renew: bool) -> None:
        row = self.row(deformer)
        if row.object is not None and not libraries.is_lost(row.object):
            self.refuse_other_type(row.object)
        stale = renew and self.is_stale(deformer, bpy.context.evaluated_depsgraph_get())
        if row.object is not None and (row.rest is None or stale):
            self.take_rest(obj, deformer)

    def take_rest(self, obj: Object, deformer: SinewDeformer) -> None:
        row = self.row(deformer)
        if row.object is None:
            raise self.ERROR(self.MISSING)
        row.rest = self.rest_of(obj, row.object, row.rest)

    def rest_of(self, obj: Object, control: Object, held: Mesh | None) -> Mesh:
        """The rest mesh of an object as it is now, in the datablock ``held`` if that can hold it."""
        if libraries.is_lost(control):
            raise self.ERROR(libraries.explain(control))
        self.refuse_other_type(control)
        control.update_from_editmode()
        depsgraph = bpy.context.evaluated_depsgraph_get()
        return stored_rest(obj, control, self.make_rest(control, depsgraph), held)

    def transform_rest(self, _deformer: SinewDeformer, by: np.ndarray, held: dict[str, np.ndarray]) -> None:
        """The last pose follows; the rest is a stored rest shape, and follows by itself."""
        if self.NOUN in held:
            held[self.NOUN] = frames.transformed(by, held[self.NOUN])

    def keep_pose(self, _deformer: SinewDeformer, _held: dict[str, np.ndarray]) -> None:
        """Nothing: without the object, the last shape stays as the file has stored it."""

    def forget_rest(self, deformer: SinewDeformer) -> None:
        forget_row_rest(self.row(deformer))

    def rows(self, settings: SinewDeformer) -> Sequence[Row]:
        """The places of the objects in the settings."""
        return [self.row(settings)]

    def reset(self, obj: Object, deformer: SinewDeformer, wanted: Callable[[Link], bool]) -> list[Link]:
        found = []
        for row in self.rows(deformer):
            control = row.object
            if control is None or row.rest is None or control.library is not None:
                continue
            if wanted(Link(control)):
                self.reset_row(obj, deformer, row)
                found.append(Link(control))
        return found

    def reset_row(self, obj: Object, deformer: SinewDeformer, row: Any) -> None:
        """Put one object back to its rest."""
        reset_object(obj, deformer, row.object, row.rest)

    def not_at_rest(self, obj: Object, deformer: SinewDeformer, depsgraph: Depsgraph) -> list[Link]:
        found = []
        for row, place in zip(self.rows(deformer), self.read_state(deformer, depsgraph), strict=True):
            if place is not None and row.rest is not None and is_posed(obj, deformer, place, row.rest):
                found.append(Link(row.object))
        return found

    def refuse_use(self, obj: Object, control: Object) -> None:
        """Raises a ``SinewError`` unless the control can move the object."""
        if control == obj:
            other = f"choose another {self.TYPE.lower()}"
            raise self.ERROR(f"{control.name} cannot be its own {self.NOUN} - {other}")
        self.refuse_other_type(control)
        if _leads_to(control, obj):
            raise self.ERROR(
                f"{control.name} follows {obj.name} itself - choose a {self.NOUN} that does not depend on it"
            )

    def use(self, obj: Object, deformer: SinewDeformer, control: Object, owned: bool) -> None:
        self.refuse_use(obj, control)
        row = self.row(deformer)
        row.object, row.owned = control, owned

    def links(self, deformer: SinewDeformer) -> Iterator[Link]:
        control = self.row(deformer).object
        if control is not None:
            yield Link(control, by_shape=True)

    def lost(self, deformer: SinewDeformer) -> tuple[str, ...]:
        row = self.row(deformer)
        if row.object is not None and libraries.is_lost(row.object):
            return (libraries.explain(row.object),)
        text = f"The {self.NOUN} was deleted, and the last shape stays - pick another"
        return (text,) if deformer.is_bound and row.missing else ()

    def release(self, _obj: Object, deformer: SinewDeformer) -> None:
        release((self.row(deformer),))

    def selected(self, _deformer: SinewDeformer) -> tuple[int, ...]:
        return ()

    def influence(self, _deformer: SinewDeformer, _bound: Bound) -> Influence | None:
        return None


def _leads_to(control: Object, obj: Object) -> bool:
    """Whether ``obj`` controls a deformer of ``control``, or of a control further along."""
    waiting, known = [control], {control}
    while waiting:
        for deformer in waiting.pop().sinew.deformers:
            for row in deformer.all_controls:
                if row.object == obj:
                    return True
                if row.object is not None and row.object not in known:
                    known.add(row.object)
                    waiting.append(row.object)
    return False


def stored_rest(obj: Object, control: Object, mesh: Mesh, held: Mesh | None) -> Mesh:
    """A new ``mesh`` of a control, in its frame, as a rest mesh; in the datablock ``held`` if possible."""
    depsgraph = bpy.context.evaluated_depsgraph_get()
    relative = frames.inverse(np.array(obj.matrix_world, dtype=np.float64), obj.name)
    world = np.array(control.evaluated_get(depsgraph).matrix_world, dtype=np.float64)
    own_shape.note(mesh, control)
    rest_frame.transform(mesh, relative @ world)
    mesh.name = Datablocks.REST
    mesh.materials.clear()
    mesh[Keys.REST_TOKEN] = shapes.new_key()
    return shapes.put_mesh(held, mesh)


def reset_object(obj: Object, settings: SinewDeformer, control: Object, rest: Mesh) -> None:
    """Put a control of ``obj`` back to its place, points and shape keys at rest.

    Files of earlier builds do not tell these. Then the object stays in its place, and the points of a mesh
    or a lattice go to those of its rest mesh.
    """
    world, place = np.array(obj.matrix_world, dtype=np.float64), own_shape.place_of(rest)
    if place is None:
        own = frames.inverse(np.array(control.matrix_world, dtype=np.float64), control.name)
        points = frames.transformed(own @ world, rest_frame.read(settings, rest).points)
        own_shape.put_points(control, points.astype(np.float32).ravel())
        return
    movers.move_to(control, "", Matrix((world @ rest_frame.matrix(settings) @ place).tolist()))
    own_shape.put_back(control, rest)


def is_posed(obj: Object, settings: SinewDeformer, place: Place, rest: Mesh) -> bool:
    """Whether the points of a control at a place are elsewhere than in its rest mesh.

    A path that a rest mesh holds after these points counts, too.
    """
    found = rest_frame.read(settings, rest).points
    if len(place.vertices) > len(found):
        return True
    relative = frames.inverse(np.array(obj.matrix_world, dtype=np.float64), obj.name) @ place.matrix()
    now, then = frames.transformed(relative, place.vertices.astype(np.float64)), found[: len(place.vertices)]
    return not np.abs(now - then).max(initial=0.0) <= UNPOSED * np.ptp(found, axis=0).max(initial=0.0)


def forget_row_rest(row: Row | SinewHandle) -> None:
    """Remove the rest mesh of a row, unless another row uses it."""
    mesh, row.rest = row.rest, None
    shapes.free_meshes(mesh)


def release(rows: Iterable[Row]) -> None:
    """Remove the objects that were made for a deformer, unless another deformer uses them."""
    for row in rows:
        forget_row_rest(row)
        obj, row.object = row.object, None
        if obj is None or not row.owned or obj.library is not None or deformers_of(obj) or _is_used(obj):
            continue
        data = obj.data
        bpy.data.objects.remove(obj)
        if data is not None and data.users == 0:
            remove_data((data,))


def _is_used(control: Object) -> bool:
    return any(
        row.object == control
        for obj in bpy.data.objects
        for deformer in deformers_of(obj)
        for row in deformer.all_controls
    )

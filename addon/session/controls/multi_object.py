# SPDX-License-Identifier: GPL-3.0-or-later
"""What kinds of control have in common that are several objects, such as curves. See ``kinds``.

Each object has a row in the list of controls, and a hidden rest mesh as ``objects`` describes it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import bpy
import numpy as np
from bpy.types import Depsgraph, Mesh, Object

from ...backend import ControlPoints, Recipe, Shape
from ...core.elements import NO_ELEMENTS, Elements
from ...core.geometry import frames
from ...core.status import Remedy
from ...ids import Keys
from ...mesh_io import RestShape
from ...properties import SinewControl, SinewDeformer
from ..datablocks import libraries, rest_frame
from ..datablocks.evaluation_driver import Link
from ..datablocks.vertex_groups import read_weights
from ..state.evaluation import ControlState, Evaluation, Place
from ..state.sessions import Bound
from . import objects, placement
from .bind_input import BindInput, options, unpainted
from .objects import ObjectKind


@dataclass(frozen=True)
class Part:
    """One of several controls at rest: its points (c, 3) in the frame of the target, and its own values."""

    points: np.ndarray
    own: dict[str, object]


class SeveralKind(ObjectKind):
    """Several objects whose points move the target. ``ObjectKind`` says what each function does."""

    KIND: str  # the name of its folder
    TYPES: tuple[str, ...]  # of the objects, by Blender's names; any type if this is empty

    def rows(self, settings: SinewDeformer) -> list[SinewControl]:
        """The rows of this kind in the list of controls."""
        return [row for row in settings.controls if row.kind == self.KIND]

    def used(self, settings: SinewDeformer) -> list[SinewControl]:
        """Those that are in use."""
        return [row for row in self.rows(settings) if row.enabled and _is_set(row)]

    def part(self, settings: SinewDeformer, row: SinewControl, rest: RestShape) -> Part:
        """What is bound of a row, for its ``rest`` in the frame of the target."""
        raise TypeError(f"{type(self).__name__} has no parts")

    def merged(self, parts: Sequence[Part]) -> ControlPoints:
        """What is bound of all rows."""
        values = {name: [part.own[name] for part in parts] for name in parts[0].own}
        return ControlPoints(np.concatenate([part.points for part in parts]), values)

    def posed(self, evaluation: Evaluation, row: SinewControl, points: np.ndarray) -> np.ndarray:
        """What moves the target, for the points (c, 3) of a row in the frame of the target."""
        return points

    def wrong(self, row: SinewControl, points: np.ndarray) -> str:
        """What is wrong with the points (c, 3) of an object at rest; empty if nothing is."""
        return ""

    def is_set(self, settings: SinewDeformer) -> bool:
        return bool(self.used(settings))

    def key(self, settings: SinewDeformer) -> tuple:
        return tuple(
            (
                "" if row.rest is None else row.rest.get(Keys.REST_TOKEN, ""),
                row.domain is not None and row.has_domain,
                *(
                    getattr(row, parameter.id)
                    for parameter in settings.definition.control_parameters
                    if parameter.rebinds
                ),
            )
            for row in self.used(settings)
        )

    def request(
        self, settings: SinewDeformer, mesh: Mesh, rest: RestShape, key: tuple, base_count: int
    ) -> BindInput:
        read_weights(rest, mesh, settings)
        parts, names = [], []
        for row in self.used(settings):
            if row.rest is None:
                raise self.ERROR(f"{label_of(row)} is not bound yet - press Rebind", remedy=Remedy.BIND)
            found = rest_frame.read(settings, row.rest)
            text = self.wrong(row, found.points)
            if len(found.not_finite):
                text = (
                    f"{label_of(row)} has invalid coordinates (NaN or infinite) - correct them, then Rebind"
                )
            if text:
                raise self.ERROR(text)
            parts.append(self.part(settings, row, found))
            names.append(label_of(row))
        if not parts:
            raise self.ERROR(self.MISSING)
        target = Shape(rest.points, (rest.counts, rest.corners))
        return BindInput(
            key=key,
            recipe=Recipe(settings.definition, target, options(settings, rest), self.merged(parts)),
            rest=rest,
            on_base=len(rest.points) == base_count,
            control=f"1 {self.NOUN}" if len(parts) == 1 else f"{len(parts):,} {self.NOUN}s",
            names=tuple(names),
            unpainted=unpainted(settings, rest),
        )

    def selectable(self, elements: Elements, _request: BindInput) -> Elements:
        """Only those of the target: the native module numbers controls, and cannot name their points."""
        return elements if elements.element == "vertex" else NO_ELEMENTS

    def object_with(self, deformer: SinewDeformer, _elements: Elements) -> Object:
        """Always raises: errors name the objects, and none of their points."""
        raise self.ERROR(f"The {self.POINTS} of a {self.NOUN} cannot be selected")

    def read_state(self, deformer: SinewDeformer, depsgraph: Depsgraph) -> ControlState:
        return [self.place_of(row, depsgraph) for row in self.rows(deformer)]

    def place_of(self, row: SinewControl, depsgraph: Depsgraph) -> Place | None:
        """Where the object of a row is; None for no object, or one of another type."""
        control = row.object
        if control is None or (self.TYPES and control.type not in self.TYPES):
            return None
        return placement.read_place(
            control, depsgraph, read_points=self.read_points, expected=self.expected(row)
        )

    def pose(
        self, evaluation: Evaluation, bound: Bound, incoming: np.ndarray | None
    ) -> tuple[np.ndarray, dict[str, np.ndarray]] | None:
        """The points of all rows; of a lost object the last known ones."""
        held, found = evaluation.session.poses, []
        settings = evaluation.settings.controls
        world = np.array(evaluation.evaluated.matrix_world, dtype=np.float64)
        to_target = frames.inverse(world, "The mesh object")
        indices = [i for i, row in enumerate(evaluation.deformer.controls) if row.kind == self.KIND]
        for index, place in zip(indices, evaluation.control, strict=True):
            row = evaluation.deformer.controls[index]
            if not (settings[index].enabled and _is_set(row)):
                continue
            key = row.rest.get(Keys.REST_TOKEN, "") if row.rest is not None else ""
            if place is None and row.object is not None and not libraries.is_lost(row.object):
                self.refuse_other_type(row.object)
            if place is None or row.missing:
                if key not in held:
                    return None
                points = held[key]
            else:
                points = self._points(row, place, to_target)
                held[key] = points
            found.append(self.posed(evaluation, settings[index], points))
        return np.concatenate(found), {}

    def _points(self, row: SinewControl, place: Place, to_target: np.ndarray) -> np.ndarray:
        """The points of a row in the frame of the target. Raises a ``SinewError`` if they do not fit."""
        expected = 0 if row.rest is None else self.point_count(row.rest)
        if len(place.vertices) != expected:
            raise self.ERROR(
                f"{label_of(row)} has {len(place.vertices):,} {self.POINTS}, at bind it had {expected:,} - "
                f"{self.REST_BUTTON} takes it as it is now",
                remedy=self.REST_REMEDY,
            )
        with np.errstate(invalid="ignore"):  # refused below
            posed = frames.transformed(to_target @ place.matrix(), place.vertices.astype(np.float64))
        if not frames.are_valid(posed).all():
            raise self.ERROR(
                f"{label_of(row)} has invalid coordinates (NaN or infinite) - undo, or correct them"
            )
        return posed

    def refuse_other_type(self, control: Object) -> None:
        if self.TYPES and control.type not in self.TYPES:
            raise self.ERROR(f"{control.name} is no {self.NOUN} - {self.WANTED}")

    def is_stale(self, deformer: SinewDeformer, depsgraph: Depsgraph) -> bool:
        return any(self._is_row_stale(row, depsgraph) for row in self.used(deformer))

    def _is_row_stale(self, row: SinewControl, depsgraph: Depsgraph) -> bool:
        if row.missing or row.rest is None:
            return False
        place = self.place_of(row, depsgraph)
        return place is not None and len(place.vertices) != self.point_count(row.rest)

    def set_rest(self, obj: Object, deformer: SinewDeformer, renew: bool) -> None:
        depsgraph = bpy.context.evaluated_depsgraph_get()
        for row in self.rows(deformer):
            if row.object is None or libraries.is_lost(row.object):
                continue
            self.refuse_other_type(row.object)
            if row.rest is None or self._is_row_stale(row, depsgraph):
                self.take_row_rest(obj, row)

    def take_rest(self, obj: Object, deformer: SinewDeformer) -> None:
        for row in self.rows(deformer):
            if row.object is not None:
                self.take_row_rest(obj, row)

    def take_row_rest(self, obj: Object, row: SinewControl) -> None:
        """Let one object rest as it is now."""
        row.rest = self.rest_of(obj, row.object, row.rest)

    def transform_rest(self, deformer: SinewDeformer, by: np.ndarray, held: dict[str, np.ndarray]) -> None:
        """The last poses follow; the rest meshes follow by themselves."""
        for row in self.rows(deformer):
            key = "" if row.rest is None else row.rest.get(Keys.REST_TOKEN, "")
            if key in held:
                held[key] = frames.transformed(by, held[key])

    def forget_rest(self, deformer: SinewDeformer) -> None:
        for row in self.rows(deformer):
            objects.forget_row_rest(row)
            row.has_domain = False

    def use(self, obj: Object, deformer: SinewDeformer, control: Object, owned: bool) -> None:
        """Add a row for an object that has none yet."""
        self.refuse_use(obj, control)
        if any(row.object == control for row in self.rows(deformer)):
            raise self.ERROR(f"{control.name} is a {self.NOUN} of {deformer.name} already")
        row = deformer.controls.add()
        row.kind, row.name = self.KIND, control.name
        row.object, row.owned = control, owned
        deformer.active_control = len(deformer.controls) - 1

    def links(self, deformer: SinewDeformer) -> Iterator[Link]:
        for row in self.rows(deformer):
            if row.object is not None:
                yield Link(row.object, by_shape=True)

    def lost(self, deformer: SinewDeformer) -> tuple[str, ...]:
        lines = []
        for row in self.rows(deformer):
            if row.object is not None and libraries.is_lost(row.object):
                lines.append(libraries.explain(row.object))
            elif deformer.is_bound and row.missing:
                lines.append(f"{label_of(row)} was deleted, and its last shape stays - pick another")
        return tuple(dict.fromkeys(lines))

    def release(self, _obj: Object, deformer: SinewDeformer) -> None:
        objects.release(self.rows(deformer))


def _is_set(row: SinewControl) -> bool:
    return row.object is not None or row.rest is not None


def label_of(row: SinewControl) -> str:
    """The name of the object of a row, also after the object was deleted."""
    return row.name if row.object is None else row.object.name

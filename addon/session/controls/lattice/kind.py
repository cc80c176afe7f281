# SPDX-License-Identifier: GPL-3.0-or-later
"""A lattice moves the shape: a Blender lattice object, or a mesh of hexahedra. See ``kinds``."""

from dataclasses import replace
from typing import Any

import bpy
import numpy as np
from bpy.types import Depsgraph, Lattice, Mesh, Object

from ....backend import ControlPoints, Faces, Refusal
from ....compat import read_faces, read_lattice
from ....core.elements import Elements
from ....core.errors import ConstraintError
from ....core.status import Level, Remedy, Status, warnings_of
from ....ids import Keys
from ....mesh_io import RestShape
from ....properties import SinewControl, SinewDeformer
from ...state.evaluation import NO_VERTICES, Evaluation, Place
from ...state.sessions import Bound
from .. import placement
from ..bind_input import BindInput
from ..objects import ObjectKind

KIND_NAME = "lattice"
_BLENDER = "blender"  # the value of "basis" with which the types of the lattice count
_INTERPOLATION = {  # by Blender's names
    "KEY_LINEAR": "linear",
    "KEY_CARDINAL": "cardinal",
    "KEY_CATMULL_ROM": "catmull_rom",
    "KEY_BSPLINE": "bspline",
}


class _NoRow:
    """What there is before a lattice is chosen. It keeps nothing."""

    rest = None
    owned = False
    missing = True

    def __init__(self) -> None:
        self.__dict__["object"] = None

    def __setattr__(self, _name: str, _value: Any) -> None:
        """A lattice that is not there forgets nothing."""


_NO_ROW = _NoRow()


class LatticeKind(ObjectKind):
    """The points of a lattice object, or the corners of the hexahedra of a mesh object.

    The rest is stored as a mesh. That of a lattice object has no faces, and remembers the rows of points. If
    an axis has one point only, an origin and the ends of the axes follow.
    """

    MISSING = "No lattice yet - Put in a Box fits one to the selection"
    NOUN = "lattice"
    POINT, POINTS = "point", "points"
    TYPES = ("LATTICE", "MESH")
    WANTED = "a lattice is a lattice object, or a mesh of hexahedra"
    REST_BUTTON, REST_REMEDY = "New Rest", Remedy.LATTICE_REST
    ERROR = ConstraintError

    def row(self, settings: SinewDeformer) -> SinewControl | Any:
        return next((row for row in settings.controls if row.kind == KIND_NAME), _NO_ROW)

    def use(self, obj: Object, deformer: SinewDeformer, control: Object, owned: bool) -> None:
        is_new = self.row(deformer) is _NO_ROW
        if is_new:
            deformer.controls.add().kind = KIND_NAME
        try:
            super().use(obj, deformer, control, owned)
        except ConstraintError:
            if is_new:
                deformer.controls.remove(len(deformer.controls) - 1)
            raise
        row = self.row(deformer)
        row.name = control.name
        if control.library is None and control.type == "MESH":
            control.display_type = "WIRE"
            control.hide_render = True

    def refuse_other_type(self, control: Object) -> None:
        if control.type not in self.TYPES:
            raise self.ERROR(f"{control.name} is no lattice - {self.WANTED}")

    def place(self, deformer: SinewDeformer, depsgraph: Depsgraph) -> Place | None:
        control = self.row(deformer).object
        if control is None or control.type not in self.TYPES:
            return None
        return placement.read_place(
            control, depsgraph, read_points=self.read_points, expected=self.expected(self.row(deformer))
        )

    def read_points(self, control: Object, depsgraph: Depsgraph) -> np.ndarray:
        if control.type == "MESH":
            return super().read_points(control, depsgraph)
        points = read_lattice(control.evaluated_get(depsgraph).data)
        return points if len(points) else NO_VERTICES

    def make_rest(self, control: Object, depsgraph: Depsgraph) -> Mesh:
        if control.type == "MESH":
            return super().make_rest(control, depsgraph)
        mesh = bpy.data.meshes.new(control.name)
        points = self.read_points(control, depsgraph)
        if 1 in _resolution(control.data):  # points do not tell the directions of such axes
            points = np.concatenate((points, np.zeros((1, 3)), np.eye(3))).astype(np.float32)
        mesh.vertices.add(len(points))
        mesh.vertices.foreach_set("co", points.ravel())
        return mesh

    def take_rest(self, obj: Object, deformer: SinewDeformer) -> None:
        super().take_rest(obj, deformer)
        row = self.row(deformer)
        for key in (Keys.REST_LATTICE, Keys.REST_INTERPOLATION):
            row.rest.pop(key, None)
        if row.object.type == "LATTICE":
            row.rest[Keys.REST_LATTICE] = _resolution(row.object.data)
            row.rest[Keys.REST_INTERPOLATION] = " ".join(_types(row.object.data))

    def bound_to(self, rest: RestShape) -> ControlPoints:
        return ControlPoints(rest.points)

    def key(self, settings: SinewDeformer) -> tuple:
        """Blender's types of interpolation count where the method asks for them."""
        return (*super().key(settings), *self._types_in_use(settings))

    def _types_in_use(self, settings: SinewDeformer) -> tuple[str, ...]:
        control = self.row(settings).object
        if control is None or control.type != "LATTICE" or settings.parameters.basis != _BLENDER:
            return ()
        return _types(control.data)

    def request(
        self, settings: SinewDeformer, mesh: Mesh, rest: RestShape, key: tuple, base_count: int
    ) -> BindInput:
        found = super().request(settings, mesh, rest, key, base_count)
        stored = self.row(settings).rest
        points = found.recipe.control.points
        described, refusal = _described(stored), Refusal(self.ERROR, self.REST_REMEDY)
        if described is None:
            faces = Faces(*read_faces(stored), closed=False)
            lattice = ControlPoints(points, faces=faces, refusal=refusal)
        else:
            resolution, types = described
            u, v, w = (_INTERPOLATION[name] for name in self._types_in_use(settings) or types)
            count = int(np.prod(resolution))
            axes = points[count + 1 :] - points[count] if len(points) > count else None
            own = {"resolution": resolution, "interpolation": (u, v, w), "axes": axes}
            lattice = ControlPoints(points[:count], own, refusal=refusal)
        return replace(found, recipe=replace(found.recipe, control=lattice), control=_in_words(lattice))

    def notes(self, report: Any, request: BindInput) -> tuple[Status, ...]:
        lines = warnings_of(report.remarks)
        if len(report.outside) and len(request.rest.points):
            lines.append(Status(Level.INFO, *request.outside(report.outside, self.NOUN)))
        return tuple(lines)

    def pose(
        self, evaluation: Evaluation, bound: Bound, incoming: np.ndarray | None
    ) -> tuple[np.ndarray, dict[str, np.ndarray]] | None:
        control = self.row(evaluation.deformer).object
        lattice = bound.factor.recipe.control
        if control is not None and control.type == "LATTICE" and lattice.faces is None:
            now, then = _resolution(control.data), lattice.own["resolution"]
            if now != then:
                raise self.ERROR(
                    f"The lattice has {_by(now)} points, at bind it had {_by(then)} - "
                    f"{self.REST_BUTTON} takes it as it is now",
                    remedy=self.REST_REMEDY,
                )
        return super().pose(evaluation, bound, incoming)

    def is_stale(self, deformer: SinewDeformer, depsgraph: Depsgraph) -> bool:
        row = self.row(deformer)
        described = None if row.rest is None else _described(row.rest)
        if described is not None and row.object is not None and row.object.type == "LATTICE":
            return _resolution(row.object.data) != described[0]
        return super().is_stale(deformer, depsgraph)

    def object_with(self, deformer: SinewDeformer, _elements: Elements) -> Object:
        """The lattice. Raises a ``ConstraintError`` if it no longer has the points of its rest."""
        row = self.row(deformer)
        if row.object is None:
            raise self.ERROR("The lattice is not in this view layer - nothing to select")
        self.refuse_other_type(row.object)
        if self.is_stale(deformer, bpy.context.evaluated_depsgraph_get()):
            raise self.ERROR(f"The lattice has other points than its rest - press {self.REST_BUTTON}")
        return row.object


def _resolution(lattice: Lattice) -> tuple[int, int, int]:
    return lattice.points_u, lattice.points_v, lattice.points_w


def _types(lattice: Lattice) -> tuple[str, str, str]:
    return lattice.interpolation_type_u, lattice.interpolation_type_v, lattice.interpolation_type_w


def _described(rest: Mesh) -> tuple[tuple[int, int, int], tuple[str, str, str]] | None:
    """The resolution and the types of interpolation of the lattice that rests so; None for hexahedra."""
    resolution, types = rest.get(Keys.REST_LATTICE), rest.get(Keys.REST_INTERPOLATION)
    return None if resolution is None else (tuple(resolution), tuple(types.split()))


def _by(resolution: tuple[int, int, int]) -> str:
    return " x ".join(map(str, resolution))


def _in_words(lattice: ControlPoints) -> str:
    if lattice.faces is None:
        return f"a lattice of {_by(lattice.own['resolution'])}"
    return f"a lattice of {len(lattice.points):,} points"


KIND = LatticeKind()

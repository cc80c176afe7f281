# SPDX-License-Identifier: GPL-3.0-or-later
"""A cage moves the shape: an ordinary mesh object around it, after its own modifiers. See ``kinds``."""

from dataclasses import replace

import bmesh
import numpy as np
from bpy.types import Mesh, Object

from ....backend import CageReport, ControlPoints, Faces, Refusal
from ....compat import read_creases
from ....core.elements import Elements, Owner
from ....core.errors import CageError
from ....core.status import Level, Remedy, Status
from ....mesh_io import RestShape
from ....properties import SinewDeformer, StoredCage
from ...state.sessions import Bound
from ..bind_input import BindInput
from ..influence import Influence
from ..objects import ObjectKind


class CageKind(ObjectKind):
    """A closed mesh around the target, or a flat one around flat art. It is drawn as wire."""

    MISSING = "No cage yet - Wrap in a Cage takes the other selected mesh"
    NOUN = "cage"
    WANTED = "a cage is a closed mesh around the target, or a flat one around flat art"
    REST_BUTTON, REST_REMEDY = "New Rest", Remedy.CAGE_REST
    ERROR = CageError

    def row(self, settings: SinewDeformer) -> StoredCage:
        return StoredCage(settings)

    def bound_to(self, rest: RestShape) -> ControlPoints:
        refusal = Refusal(self.ERROR, self.REST_REMEDY, Remedy.FLIP_CAGE)
        return ControlPoints(rest.points, faces=Faces(rest.counts, rest.corners), refusal=refusal)

    def request(
        self, settings: SinewDeformer, mesh: Mesh, rest: RestShape, key: tuple, base_count: int
    ) -> BindInput:
        """With the creases of a smooth cage."""
        found = super().request(settings, mesh, rest, key, base_count)
        control = found.recipe.control
        if found.recipe.options.get("smooth", "off") == "off" or not isinstance(control, ControlPoints):
            return found
        pairs = zip(("creases", "corners"), read_creases(self.row(settings).rest), strict=True)
        own = {name: (where, 10.0 * crease**2) for name, (where, crease) in pairs if len(where)}
        return replace(found, recipe=replace(found.recipe, control=replace(control, own=own)))

    def in_words(self, rest: RestShape) -> str:
        faces = "1 face" if len(rest.counts) == 1 else f"{len(rest.counts):,} faces"
        return f"a {self.NOUN} of {faces} ({len(rest.points):,} {self.POINTS})"

    def notes(self, report: CageReport, request: BindInput) -> tuple[Status, ...]:
        """Warnings about points outside the cage, and about faces of the cage that cross each other."""
        found = []
        if len(report.outside):
            found.append(Status(Level.WARNING, *request.outside(report.outside, self.NOUN)))
        if len(report.crossing):
            text = f"{len(report.crossing):,} faces of the cage cross each other"
            found.append(Status(Level.WARNING, text, Elements(Owner.CONTROL, "face", report.crossing)))
        return tuple(found)

    def object_with(self, deformer: SinewDeformer, _elements: Elements) -> Object:
        """The cage. Raises a ``CageError`` if it no longer has the elements of its rest."""
        cage, rest = deformer.cage, deformer.cage_rest
        if cage is None:
            raise CageError("The cage is not in this view layer - nothing to select")
        self.refuse_other_type(cage)
        if isinstance(rest, Mesh) and len(cage.data.vertices) != len(rest.vertices):
            raise CageError(
                "The cage has other vertices than its rest - turn off its modifiers, then New Rest"
            )
        return cage

    def use(self, obj: Object, deformer: SinewDeformer, control: Object, owned: bool) -> None:
        super().use(obj, deformer, control, owned)
        if control.library is None:
            control.display_type = "WIRE"
            control.hide_render = True

    def selected(self, deformer: SinewDeformer) -> tuple[int, ...]:
        cage = deformer.cage
        if cage is None or cage.type != "MESH":
            return ()
        if cage.mode == "EDIT":
            return tuple(vertex.index for vertex in bmesh.from_edit_mesh(cage.data).verts if vertex.select)
        chosen = np.empty(len(cage.data.vertices), dtype=bool)
        cage.data.vertices.foreach_get("select", chosen)
        return tuple(np.flatnonzero(chosen).tolist())

    def influence(self, deformer: SinewDeformer, bound: Bound) -> Influence:
        """How far each point follows the selected vertices of the cage.

        Modifiers of the cage keep the indices of its own vertices, and number those that they add after them.
        """
        factor = bound.factor
        vertices = tuple(v for v in self.selected(deformer) if v < len(factor.recipe.control.points))
        return Influence(vertices, factor.influence(vertices), factor.report.outside)


KIND = CageKind()

# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves a shape, by the kind of control that a method asks for: one folder per kind."""

from collections.abc import Iterable, Iterator
from importlib import import_module
from pathlib import Path
from typing import Any, Protocol, cast

import numpy as np
from bpy.types import Depsgraph, Mesh, Object

from ...core.elements import Elements, Owner
from ...core.methods import METHODS, Control, Method
from ...core.status import Status
from ...mesh_io import RestShape
from ...properties import SinewDeformer
from ..blocks.keeper import Link, pointer_links, write_driver
from ..blocks.owners import owners
from ..memory.evaluation import ControlState, Evaluation
from ..memory.sessions import Bound
from .bind_input import BindInput, option_values
from .influence import Influence


class ControlKind(Protocol):
    """A kind of control, as the module ``kind`` of its folder.

    Only ``set_rest``, ``take_rest``, ``forget_rest`` and ``release`` make or remove datablocks: they are for
    operators, scripts and timers.
    """

    MISSING: str  # what to do where nothing moves the mesh yet
    MARKS_REGIONS: bool  # it moves regions of a mesh that are vertex groups

    def name(self, method: Method) -> str:
        """What a new deformer is called."""

    def is_set(self, settings: SinewDeformer) -> bool:
        """Something moves the mesh."""

    def key(self, settings: SinewDeformer) -> tuple:
        """The control's part of what a factor depends on."""

    def request(
        self, settings: SinewDeformer, mesh: Mesh, rest: RestShape, key: tuple, base_count: int
    ) -> BindInput:
        """Arrays for the native module, or the reason why there are none."""

    def notes(self, report: Any, request: BindInput) -> tuple[Status, ...]:
        """What the report of a bind tells the artist."""

    def read(self, deformer: SinewDeformer, depsgraph: Depsgraph) -> ControlState:
        """Where the control is. Called once per evaluation, so ``pose`` takes it from there."""

    def pose(self, evaluation: Evaluation, bound: Bound) -> tuple[np.ndarray, dict[str, np.ndarray]] | None:
        """Where the control is, as ``Factor.solve`` takes it, and further keywords of it.

        None where nobody knows: then the last shape stays.
        """

    def selectable(self, elements: Elements, request: BindInput) -> Elements:
        """Elements that can be selected, for those that an error of the bind names."""

    def object_with(self, deformer: SinewDeformer, elements: Elements) -> Object:
        """The control that has these elements; where they cannot be selected, the reason is raised."""

    def links(self, deformer: SinewDeformer) -> Iterable[Link]:
        """The objects and bones that Blender has to evaluate for the deformer."""

    def is_stale(self, deformer: SinewDeformer) -> bool:
        """The control has other vertices than at rest."""

    def set_rest(self, obj: Object, deformer: SinewDeformer) -> None:
        """A control that has no rest yet rests where it is."""

    def take_rest(self, obj: Object, deformer: SinewDeformer) -> None:
        """The control rests as it is now."""

    def forget_rest(self, deformer: SinewDeformer) -> None:
        """The control has no rest: the next bind takes it as it is then."""

    def lost(self, deformer: SinewDeformer) -> tuple[str, ...]:
        """What the artist is told of controls that are gone."""

    def release(self, obj: Object, deformer: SinewDeformer) -> None:
        """Remove what was made for the deformer, unless others use it."""

    def selected(self, deformer: SinewDeformer) -> tuple[int, ...]:
        """The vertices of the control that are selected."""

    def influence(self, deformer: SinewDeformer, bound: Bound) -> Influence | None:
        """How far the target's points go with the selected vertices; None without weights."""


_KINDS: dict[Control, ControlKind] = {
    control: cast(ControlKind, import_module(f".{control.name.lower()}.kind", __package__))
    for control in Control
    if (Path(__file__).parent / control.name.lower() / "kind.py").is_file()
}


def every_kind() -> Iterable[ControlKind]:
    """All kinds, in the order of ``Control``."""
    return _KINDS.values()


def kind_in_use(settings: SinewDeformer) -> ControlKind:
    """The kind that the method in use asks for."""
    return kind_of_method(settings.definition)


def kind_of_method(method: Method) -> ControlKind:
    """The kind that a method asks for."""
    return _KINDS[method.control]


def methods_of(kind: ControlKind) -> tuple[Method, ...]:
    """The methods that ask for a kind."""
    return tuple(method for method in METHODS if _KINDS.get(method.control) is kind)


def marks_regions(method: Method) -> bool:
    """The method moves regions of a mesh that are vertex groups."""
    return kind_of_method(method).MARKS_REGIONS


def lost_controls(deformer: SinewDeformer) -> tuple[str, ...]:
    """What the artist is told of controls that are gone."""
    return kind_in_use(deformer).lost(deformer)


def object_with(deformer: SinewDeformer, elements: Elements) -> Object:
    """The object whose ``elements`` they are; where they cannot be selected, the reason is raised."""
    if elements.owner is Owner.TARGET:
        return deformer.id_data
    return kind_in_use(deformer).object_with(deformer, elements)


def posed_by(control: Object) -> Object | None:
    """The object that this control, or one of its bones, moves."""
    for obj in owners():
        if any(link.object == control for link in _links(obj)):
            return obj
    return None


def keep_evaluated(obj: Object) -> None:
    """Let Blender evaluate what the object follows, hidden and unlinked objects too."""
    write_driver(obj, list(dict.fromkeys((*_links(obj), *pointer_links(obj)))))


def _links(obj: Object) -> Iterator[Link]:
    for kind in every_kind():
        for deformer in obj.sinew.deformers:
            yield from kind.links(deformer)


def bind_key(settings: SinewDeformer, token: str) -> tuple:
    """What a factor depends on. Equal keys, equal factors; so undo, load and copies need no bookkeeping."""
    return token, settings.definition.id, option_values(settings), kind_in_use(settings).key(settings)

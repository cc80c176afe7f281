# SPDX-License-Identifier: GPL-3.0-or-later
"""The kinds of control that methods ask for, such as handles or a cage: one folder per kind."""

from collections.abc import Callable, Iterable, Iterator
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
from ..datablocks import libraries
from ..datablocks.evaluation_driver import Link, pointer_links, write_driver
from ..datablocks.owners import owners
from ..state.evaluation import ControlState, Evaluation
from ..state.sessions import Bound
from .bind_input import BindInput, option_values
from .influence import Influence


class ControlKind(Protocol):
    """What the module ``kind`` in the folder of each kind of control implements, or its ``KIND``.

    Only ``set_rest``, ``take_rest``, ``forget_rest`` and ``release`` make or remove datablocks. So operators,
    scripts and timers may call them, and handlers may not.
    """

    MISSING: str  # tells the artist what to do while nothing moves the mesh
    MARKS_REGIONS: bool  # whether it moves regions of a mesh, which are vertex groups

    def is_set(self, settings: SinewDeformer) -> bool:
        """Whether something moves the mesh."""

    def key(self, settings: SinewDeformer) -> tuple:
        """What a factor depends on, as far as the control is concerned. For comparison."""

    def request(
        self, settings: SinewDeformer, mesh: Mesh, rest: RestShape, key: tuple, base_count: int
    ) -> BindInput:
        """The arrays for the native module. Raises a ``SinewError`` if it cannot be bound."""

    def notes(self, report: Any, request: BindInput) -> tuple[Status, ...]:
        """The lines in the panel about the report of a bind. Its type is the one that the recipe reports."""

    def read_state(self, deformer: SinewDeformer, depsgraph: Depsgraph) -> ControlState:
        """Where the control is. Called once per evaluation: ``pose`` gets it as ``evaluation.control``."""

    def pose(
        self, evaluation: Evaluation, bound: Bound, incoming: np.ndarray | None
    ) -> tuple[np.ndarray, dict[str, np.ndarray]] | None:
        """Where the control is, in the form that ``Factor.solve`` takes, and further keywords for it.

        ``incoming`` float32 (n, 3) is what enters; None if that is the rest shape, or unknown.
        None if the control is lost and its last place is unknown. Then the last shape stays.
        """

    def selectable(self, elements: Elements, request: BindInput) -> Elements:
        """The elements that an error of a bind names, as elements that can be selected."""

    def object_with(self, deformer: SinewDeformer, elements: Elements) -> Object:
        """The control that has these elements. Raises a ``SinewError`` if they cannot be selected."""

    def use(self, obj: Object, deformer: SinewDeformer, control: Object, owned: bool) -> None:
        """Let an object control the deformer; raises a ``SinewError`` if it cannot. The bind comes later.

        ``owned``: the object was made for the deformer, and is removed with it.
        """

    def links(self, deformer: SinewDeformer) -> Iterable[Link]:
        """The objects and bones that Blender must evaluate for the deformer."""

    def is_stale(self, deformer: SinewDeformer, depsgraph: Depsgraph) -> bool:
        """Whether a control has gained or lost points since it was bound."""

    def set_rest(self, obj: Object, deformer: SinewDeformer, renew: bool) -> None:
        """Let controls that have no rest yet rest where they are.

        With ``renew``, also those that have gained or lost points. Kinds without a button of their own for
        that do it in any case.
        """

    def take_rest(self, obj: Object, deformer: SinewDeformer) -> None:
        """Let the control rest as it is now."""

    def transform_rest(self, deformer: SinewDeformer, by: np.ndarray, held: dict[str, np.ndarray]) -> None:
        """Apply has changed the object space of the target by an affine map ``by`` (4, 4).

        The rest, unless it is a stored rest mesh, and the poses in ``held`` and in the settings follow.
        """

    def keep_pose(self, deformer: SinewDeformer, held: dict[str, np.ndarray]) -> None:
        """Store the poses ``held`` of controls from libraries: the next time, these may be missing."""

    def forget_rest(self, deformer: SinewDeformer) -> None:
        """Forget how the control rested: at the next bind it rests as it is then."""

    def reset(self, obj: Object, deformer: SinewDeformer, wanted: Callable[[Link], bool]) -> list[Link]:
        """Put the controls that are wanted back to where they rest, as far as they move by themselves.

        Returns these. The depsgraph is up to date.
        """

    def not_at_rest(self, obj: Object, deformer: SinewDeformer, depsgraph: Depsgraph) -> list[Link]:
        """The controls that are not at rest, among those that are there and have a rest."""

    def lost(self, deformer: SinewDeformer) -> tuple[str, ...]:
        """The lines in the panel about controls that were deleted."""

    def release(self, obj: Object, deformer: SinewDeformer) -> None:
        """Remove what was made for the deformer, unless another deformer uses it."""

    def selected(self, deformer: SinewDeformer) -> tuple[int, ...]:
        """The selected vertices of the control."""

    def influence(self, deformer: SinewDeformer, bound: Bound) -> Influence | None:
        """How far each point of the target follows the selected vertices; None if the kind has no weights."""


def _kind(control: Control) -> ControlKind:
    module = import_module(f".{control.name.lower()}.kind", __package__)
    return cast(ControlKind, getattr(module, "KIND", module))


_KINDS: dict[Control, ControlKind] = {
    control: _kind(control)
    for control in Control
    if (Path(__file__).parent / control.name.lower() / "kind.py").is_file()
}


def every_kind() -> Iterable[ControlKind]:
    """All kinds, in the order of ``Control``."""
    return _KINDS.values()


def kind_in_use(settings: SinewDeformer) -> ControlKind:
    """The kind of control that the method in use asks for."""
    return kind_of_method(settings.definition)


def kind_of_method(method: Method) -> ControlKind:
    """The kind of control that a method asks for."""
    return _KINDS[method.control]


def methods_of(kind: ControlKind) -> tuple[Method, ...]:
    """The methods that ask for a kind of control."""
    return tuple(method for method in METHODS if _KINDS.get(method.control) is kind)


def marks_regions(method: Method) -> bool:
    """Whether the method moves regions of a mesh, which are vertex groups."""
    return kind_of_method(method).MARKS_REGIONS


def lost_controls(deformer: SinewDeformer) -> tuple[str, ...]:
    """The lines in the panel about controls that were deleted."""
    return kind_in_use(deformer).lost(deformer)


def missing_control(deformer: SinewDeformer) -> str:
    """What to say if a control is missing with its library; empty if none is."""
    controls = (link.object for link in kind_in_use(deformer).links(deformer))
    return next((libraries.explain(control) for control in controls if libraries.is_lost(control)), "")


def object_with(deformer: SinewDeformer, elements: Elements) -> Object:
    """The object that has these elements. Raises a ``SinewError`` if they cannot be selected."""
    if elements.owner is Owner.TARGET:
        return deformer.id_data
    return kind_in_use(deformer).object_with(deformer, elements)


def posed_by(control: Object, preferred: str = "") -> Object | None:
    """An object that is moved by this control, or by one of its bones: the one of this name, or the first."""
    found = [
        obj for obj in owners() if any(link.object == control for link in (*_links(obj), *pointer_links(obj)))
    ]
    return next((obj for obj in found if obj.name == preferred), found[0] if found else None)


def keep_evaluated(obj: Object) -> None:
    """Make Blender evaluate the controls of an object, also hidden ones and those in no scene."""
    write_driver(obj, list(dict.fromkeys((*_links(obj), *pointer_links(obj)))))


def _links(obj: Object) -> Iterator[Link]:
    for kind in every_kind():
        for deformer in obj.sinew.deformers:
            yield from kind.links(deformer)


def bind_key(settings: SinewDeformer, token: str) -> tuple:
    """What a factor depends on. Equal keys, equal factors: so undo, load and copies need no bookkeeping."""
    return token, settings.definition.id, option_values(settings), kind_in_use(settings).key(settings)

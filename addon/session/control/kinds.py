# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves a shape, by the kind of control that a method asks for: one folder per kind."""

from typing import Protocol

import numpy as np
from bpy.types import Depsgraph, Mesh, Object

from ...core.methods import Control, Method
from ...core.status import Status
from ...mesh_io import RestShape
from ...properties import SinewDeformer
from ..memory.evaluation import Evaluation
from ..memory.sessions import Bound
from .bind_input import BindInput, option_values
from .cage import kind as cage
from .handles import kind as handles


class ControlKind(Protocol):
    """A kind of control. Nothing here but ``set_rest`` makes or removes datablocks."""

    MISSING: str  # what to do where nothing moves the mesh yet

    @staticmethod
    def is_set(settings: SinewDeformer) -> bool:
        """Something moves the mesh."""

    @staticmethod
    def key(settings: SinewDeformer) -> tuple:
        """The control's part of what a factor depends on."""

    @staticmethod
    def request(
        settings: SinewDeformer, mesh: Mesh, rest: RestShape, key: tuple, base_count: int
    ) -> BindInput:
        """Arrays for the native module, or the reason why there are none."""

    @staticmethod
    def notes(report: object, request: BindInput) -> tuple[Status, ...]:
        """What the report of a bind tells the artist."""

    @staticmethod
    def pose(evaluation: Evaluation, bound: Bound) -> tuple[np.ndarray, dict[str, object]] | None:
        """Where the control is, as ``Factor.solve`` takes it, and further keywords of it.

        None where nobody knows: then the last shape stays.
        """

    @staticmethod
    def placed(deformer: SinewDeformer, depsgraph: Depsgraph) -> list[object]:
        """Where the control is, to compare: the quick form."""

    @staticmethod
    def set_rest(obj: Object, deformer: SinewDeformer) -> None:
        """A control that has no rest yet rests where it is. For operators."""


_KINDS: dict[Control, ControlKind] = {Control.HANDLES: handles, Control.CAGE: cage}


def kind_in_use(settings: SinewDeformer) -> ControlKind:
    """The kind that the method in use asks for."""
    return kind_of_method(settings.definition)


def kind_of_method(method: Method) -> ControlKind:
    """The kind that a method asks for."""
    return _KINDS[method.control]


def bind_key(settings: SinewDeformer, token: str) -> tuple:
    """What a factor depends on. Equal keys, equal factors; so undo, load and copies need no bookkeeping."""
    return token, settings.definition.id, option_values(settings), kind_in_use(settings).key(settings)

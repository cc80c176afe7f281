# SPDX-License-Identifier: GPL-3.0-or-later
"""What moves a shape, by the kind of control that a method asks for: one module a kind, equal functions."""

from typing import Protocol

import numpy as np
from bpy.types import Depsgraph, Mesh, Object

from ..core.methods import Control, Method
from ..core.status import Status
from ..mesh_io import RestShape
from ..properties import SinewDeformer
from . import by_cage, by_handles
from .request import BindInput, option_values
from .state import Bound
from .turn import Turn


class Steering(Protocol):
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
    def pose(turn: Turn, bound: Bound) -> tuple[np.ndarray, dict[str, object]] | None:
        """Where the control is, as ``Factor.solve`` takes it, and further keywords of it.

        None where nobody knows: then the last shape stays.
        """

    @staticmethod
    def placed(deformer: SinewDeformer, depsgraph: Depsgraph) -> list[object]:
        """Where the control is, to compare: the quick form."""

    @staticmethod
    def set_rest(obj: Object, deformer: SinewDeformer) -> None:
        """A control that has no rest yet rests where it is. For operators."""


_KINDS: dict[Control, Steering] = {Control.HANDLES: by_handles, Control.CAGE: by_cage}


def of(settings: SinewDeformer) -> Steering:
    """The kind that the method in use asks for."""
    return of_method(settings.definition)


def of_method(method: Method) -> Steering:
    """The kind that a method asks for."""
    return _KINDS[method.control]


def bind_key(settings: SinewDeformer, token: str) -> tuple:
    """What a factor depends on. Equal keys, equal factors; so undo, load and copies need no bookkeeping."""
    return token, settings.definition.id, option_values(settings), of(settings).key(settings)

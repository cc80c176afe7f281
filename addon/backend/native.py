# SPDX-License-Identifier: GPL-3.0-or-later
"""Native calls with their errors translated. No other room names a native class."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import lru_cache

import numpy as np

from ..core.errors import (
    BackendMissingError,
    CancelledError,
    ConstraintError,
    MeshError,
    OptionError,
    SinewError,
    SolverError,
)
from ..core.methods import Method
from .loader import Availability, load

Progress = Callable[[float, str], bool]

_TRANSLATION = {
    "InvalidMesh": MeshError,
    "InvalidConstraint": ConstraintError,
    "InvalidOption": OptionError,
    "FactorizationFailed": SolverError,
    "Cancelled": CancelledError,
}


@lru_cache(maxsize=1)
def availability() -> Availability:
    """The native module or its remedy. A loaded module stays until Blender ends."""
    return load()


def _module():
    found = availability()
    if found.module is None:
        raise BackendMissingError(found.remedy)
    return found.module


@contextmanager
def _translated(native) -> Iterator[None]:
    try:
        yield
    except native.Error as error:
        kind = _TRANSLATION.get(type(error).__name__, SinewError)
        raise kind(str(error), tuple(error.elements), error.element_kind) from error
    except MemoryError as error:
        raise SolverError("Not enough memory to bind this mesh - use fewer vertices") from error


class Factor:
    """A bound method: solve as often as you like. Safe to use from several threads."""

    def __init__(self, native, solver, report) -> None:
        self._native = native
        self._solver = solver
        self.report = report

    def solve(self, poses: np.ndarray, **options) -> tuple[np.ndarray, object]:
        """Positions (n, 3) float64 and a report for ``poses`` (k, 3, 4)."""
        with _translated(self._native):
            return self._solver.solve(poses, **options)


def build_factor(
    method: Method,
    points: np.ndarray,
    faces: tuple[np.ndarray, np.ndarray],
    options: dict[str, object],
    handles: Sequence[np.ndarray],
    weights: Sequence[object],
    continuity: Sequence[float] | None = None,
    progress: Progress | None = None,
) -> Factor:
    """Assemble and factorise.

    ``points`` (n, 3) float64, ``faces`` (counts, corners). Needs no bpy: any thread will do.
    """
    native = _module()
    with _translated(native):
        mesh = native.SurfaceMesh(points, faces)
        solver = getattr(native, method.native)(mesh, **options)
        boundary = {} if continuity is None else {"continuity": continuity}
        report = solver.set_handles(handles, weights=weights, progress=progress, **boundary)
        return Factor(native, solver, report)

# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of the matrix: every method of the registry that regions steer, and peers; functions of a case."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import ModuleType

import numpy as np

from .cases import Case

Solve = Callable[[Case], np.ndarray]  # the deformed points (n, 3)

# Choices of a method whose values the tutorial treats as methods of their own: each gets a row.
SPLIT = {"laplacian_editing": "transforms", "multiresolution": "details"}


def registry_rows(methods: ModuleType, native: ModuleType) -> Iterator[tuple[str, Solve]]:
    """A row per method that regions steer, of surfaces or of space, with its defaults, in the menu's order.

    ``methods`` is the add-on's ``core.methods``, ``native`` the compiled module. So a method that the
    registry gains is in the matrix. One that edits animations is left out: on a still mesh it is another row.
    """
    for method in methods.METHODS:
        if method.keyed or method.control is not methods.Control.HANDLES:
            continue
        if method.is_space:
            yield method.label, space_solve(methods, native, method.id)
            continue
        choice = next((p for p in method.parameters if p.id == SPLIT.get(method.id)), None)
        if choice is None:
            yield method.label, native_solve(methods, native, method.id)
            continue
        for identifier, label, _about in choice.items:
            options = {choice.id: identifier}
            yield f"{method.label}: {label}", native_solve(methods, native, method.id, **options)


def native_solve(methods: ModuleType, native: ModuleType, name: str, **options: object) -> Solve:
    """A method of the registry with its defaults but for ``options``; around its default base, if any."""
    method = methods.BY_ID[name]

    def solve(case: Case) -> np.ndarray:
        mesh = native.SurfaceMesh(case.points, case.triangles)
        made = _made(methods, native, method, mesh, options)
        made.set_handles(list(case.handles))
        return made.solve(case.poses, **_values(method, False, options))[0]

    return solve


def space_solve(methods: ModuleType, native: ModuleType, name: str) -> Solve:
    """A space method that the vertices of the handles move, with its defaults."""
    method = methods.BY_ID[name]

    def solve(case: Case) -> np.ndarray:
        parts = [case.points[handle] for handle in case.handles]
        given = {"counts": [len(part) for part in parts]} if method.poses_maps else {}
        options = _values(method, True, {}) | given
        places = np.concatenate(parts)
        if method.wraps:
            base = methods.wrapped(method)[0]
            options["base"] = getattr(native, base.native)(places, **(_values(base, True, {}) | given))
            options["mesh"] = native.SurfaceMesh(case.points, case.triangles)
        made = getattr(native, method.native)(places, **options)
        made.bind(case.points)
        if method.poses_maps:
            parts = np.split(made.control, [4])
        posed = [part @ pose[:, :3].T + pose[:, 3] for part, pose in zip(parts, case.poses)]
        return made.warp(np.concatenate(posed))

    return solve


def _made(
    methods: ModuleType, native: ModuleType, method, mesh: object, options: dict[str, object]
) -> object:
    bases = methods.wrapped(method)
    around = [_made(methods, native, bases[0], mesh, {})] if bases else []
    return getattr(native, method.native)(mesh, *around, **_values(method, True, options))


def _values(method, rebinds: bool, options: dict[str, object]) -> dict[str, object]:
    """What the native constructor takes, or ``solve``: the defaults of the row but for ``options``."""
    return {
        parameter.id: options.get(parameter.id, parameter.native_default)
        for parameter in method.parameters
        if parameter.rebinds == rebinds
    }


def igl_arap(iterations: int = 200) -> Solve | None:
    """The as-rigid-as-possible surface of libigl, from rest; None where the package ``igl`` is missing."""
    try:
        import igl
    except ImportError:
        return None

    def solve(case: Case) -> np.ndarray:
        held = np.sort(case.held)
        data = igl.ARAPData()
        data.energy = igl.ARAP_ENERGY_TYPE_SPOKES
        data.max_iter = iterations
        faces = case.triangles.astype(np.int64)
        igl.arap_precomputation(case.points, faces, 3, held.astype(np.int32), data)
        return igl.arap_solve(np.ascontiguousarray(case.targets[held]), data, case.points.copy())

    return solve

# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of the matrix: methods that handles steer, and peers. A row is a function of a case."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from types import ModuleType

import numpy as np

from .cases import Case

Solve = Callable[[Case], np.ndarray]  # the deformed points (n, 3)

# Choices of a method whose values the tutorial treats as methods of their own: each gets a row.
SPLIT = {"laplacian_editing": "transforms", "multiresolution": "details"}


def registry_rows(methods: ModuleType, native: ModuleType) -> Iterator[tuple[str, Solve]]:
    """A row per surface method that handles steer, and per space method that takes their poses.

    Each has its defaults, in the menu's order.

    ``methods`` is the add-on's ``core.methods``, ``native`` the compiled module. So a method that the
    registry gains is in the matrix. One that edits animations is left out: on a still mesh it is another row.
    """
    for method in methods.METHODS:
        if method.keyed or method.control is not methods.Control.HANDLES:
            continue
        if method.is_space and not hasattr(getattr(native, method.native), "warp_poses"):
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
        if method.is_space:
            held = [case.points[handle] for handle in case.handles]
            around = getattr(native, method.native)(
                mesh, np.concatenate(held), [len(own) for own in held], **_values(method, True, options)
            )
            around.bind(case.points)
            return around.warp_poses(case.poses)
        made = _made(methods, native, method, mesh, options)
        made.set_handles(list(case.handles))
        return made.solve(case.poses, **_values(method, False, options))[0]

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

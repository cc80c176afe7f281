# SPDX-License-Identifier: GPL-3.0-or-later
"""The rows of the matrix: every method of the registry that handles or a lattice steer, and peers.

A row is a function of a case.
"""

from collections.abc import Callable, Iterator
from types import ModuleType

import numpy as np

from .cases import Case

Solve = Callable[[Case], np.ndarray]  # the deformed points (n, 3)

# Choices of a method whose values the tutorial treats as methods of their own: each gets a row.
SPLIT = {"laplacian_editing": "transforms", "multiresolution": "details"}


def registry_rows(methods: ModuleType, native: ModuleType) -> Iterator[tuple[str, Solve]]:
    """A row per method that handles or a lattice steer, with its defaults, in the menu's order.

    ``methods`` is the add-on's ``core.methods``, ``native`` the compiled module. So a method that the
    registry gains is in the matrix, by its name in the literature. One that edits animations is left out:
    on a still mesh it is another row.
    """
    for method in methods.METHODS:
        if method.keyed or method.control not in (methods.Control.HANDLES, methods.Control.LATTICE):
            continue
        choices = [p for p in method.parameters if p.id == SPLIT.get(method.id)]
        for choice in choices:
            for identifier, label, _about in choice.items:
                options = {choice.id: identifier}
                yield f"{method.known_as}: {label}", native_solve(methods, native, method.id, **options)
        if not choices:
            yield method.known_as, native_solve(methods, native, method.id)


def native_solve(methods: ModuleType, native: ModuleType, name: str, **options: object) -> Solve:
    """A method of the registry with its defaults but for ``options``; around its default base, if any."""
    method = methods.BY_ID[name]

    def solve(case: Case) -> np.ndarray:
        if method.control is methods.Control.LATTICE:
            return _by_lattice(native, method, case, options)
        if method.is_space:
            return _by_points(methods, native, method, case, options)
        mesh = native.SurfaceMesh(case.points, case.triangles)
        made = _made(methods, native, method, mesh, options)
        made.set_handles(list(case.handles))
        return made.solve(case.poses, **_values(method, False, options))[0]

    return solve


def _by_points(methods: ModuleType, native: ModuleType, method, case: Case, options: dict) -> np.ndarray:
    """The vertices of both handles are the points that move space."""
    held = [case.points[handle] for handle in case.handles]
    points, counts = np.concatenate(held), [len(own) for own in held]
    mesh = native.SurfaceMesh(case.points, case.triangles)
    make, values = getattr(native, method.native), _values(method, True, options)
    if method.posed is methods.Posed.POSES:
        around = make(mesh, points, counts, **values)
        around.bind(case.points)
        return around.warp_poses(case.poses)
    is_control = method.posed is methods.Posed.CONTROL
    given = {"counts": counts} if is_control else {}
    if method.wraps:
        base = methods.wrapped(method)[0]
        inner = getattr(native, base.native)(points, **_values(base, True, {}), **given)
        values |= {"mesh": mesh, "base": inner}
    made = make(points, **values, **given)
    made.bind(case.points)
    controls = np.split(made.control, len(held)) if is_control else held
    posed = [own @ pose[:, :3].T + pose[:, 3] for own, pose in zip(controls, case.poses)]
    return made.warp(np.concatenate(posed))


def _by_lattice(native: ModuleType, method, case: Case, options: dict[str, object]) -> np.ndarray:
    """A lattice around the shape, as an artist poses it: each point follows the handles by how near they are.
    Its cells are about as long as wide, with 12 along the longest side."""
    low, high = case.points.min(axis=0), case.points.max(axis=0)
    sides = np.maximum(high - low, 0.05 * np.ptp(case.points))
    counts = np.maximum(np.round(12 * sides / sides.max()).astype(int) + 1, 4)
    lines = [np.linspace(m - 0.51 * s, m + 0.51 * s, n) for m, s, n in zip(0.5 * (low + high), sides, counts)]
    w, v, u = np.meshgrid(*lines[::-1], indexing="ij")
    rest = np.stack((u, v, w), axis=-1).reshape(-1, 3)
    arms = (rest[:, None] - case.points[handle][None, ::17] for handle in case.handles)
    near, far = (np.maximum(np.linalg.norm(arm, axis=2).min(axis=1) - 0.1, 0) for arm in arms)
    share = (near / np.maximum(near + far, 1e-9))[:, None]
    first, second = (rest @ pose[:, :3].T + pose[:, 3] for pose in case.poses)
    made = getattr(native, method.native)(rest, resolution=counts, **_values(method, True, options))
    made.bind(case.points)
    return made.warp((1.0 - share) * first + share * second)


def _made(methods: ModuleType, native: ModuleType, method, mesh: object, options: dict) -> object:
    bases = methods.wrapped(method)
    around = [_made(methods, native, bases[0], mesh, {})] if bases else []
    return getattr(native, method.native)(mesh, *around, **_values(method, True, options))


def _values(method, rebinds: bool, options: dict[str, object]) -> dict[str, object]:
    """What the native constructor takes, or ``solve``: the defaults of the row but for ``options``."""
    taken = [parameter for parameter in method.parameters if parameter.rebinds == rebinds]
    return {each.id: options.get(each.id, each.native_default) for each in taken}


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

# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind, solve and memory of the thin shell next to CHOLMOD.

Both get the same matrix: the bi-Laplacian of a bar at its free vertices. Of Sinew the whole call is timed,
with the assembly of the energy and the report; of CHOLMOD, only the factorisation or the triangular solves.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import scipy.sparse as sparse
import sinew_peers
from cases import Case, bar
from record import Row
from timing import compare, require_equal, rounds
from works import WITH_PEERS

import sinew_native


def matrix(case: Case) -> tuple[sparse.csc_matrix, np.ndarray]:
    """The whole matrix, and a mask of the free vertices."""
    free = np.ones(case.vertex_count, bool)
    free[np.concatenate(case.handles)] = False
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    return sparse.csc_matrix(sinew_native.laplacian_power(mesh, 2)), free


def cholmod(case: Case) -> "sinew_peers.Cholmod":
    A, free = matrix(case)
    return sinew_peers.Cholmod(sparse.tril(A[free][:, free], format="csc"))


def bind(size: int, threads: Sequence[int]) -> list[Row]:
    case = bar("bend 90", size)
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    shells: list[sinew_native.ThinShell] = []

    def fresh() -> None:
        shells[:] = [sinew_native.ThinShell(mesh, affine_basis=False)]

    peer = cholmod(case).factorize if size <= WITH_PEERS[-1] else None
    ours = lambda: shells[0].set_handles(case.handles)  # noqa: E731
    rows = compare(ours, peer, threads, before=fresh, budget=6.0, least=rounds(size))
    return [{"vertices": case.vertex_count, **row} for row in rows]


def solve(size: int, threads: Sequence[int]) -> list[Row]:
    """CHOLMOD keeps its workspace and its result from one solve to the next."""
    case = bar("bend 90", size)
    shell = sinew_native.ThinShell(sinew_native.SurfaceMesh(case.points, case.faces), affine_basis=False)
    shell.set_handles(case.handles)
    peer = None
    if size <= WITH_PEERS[-1]:
        A, free = matrix(case)
        moved = np.zeros_like(case.points)
        for vertices, pose in zip(case.handles, case.poses):
            moved[vertices] = (case.points_posed(pose) - case.points)[vertices]
        right_side = np.asfortranarray(-(A[free][:, ~free] @ moved[~free]))
        factor = cholmod(case)
        factor.factorize()
        peer = lambda: factor.solve(right_side)  # noqa: E731
        peer()
        # The condition number of the largest matrix costs half of the digits.
        most = 1e-5 * np.ptp(case.points)
        require_equal(shell.solve(case.poses)[0][free], case.points[free] + factor.solution, most)
    rows = compare(lambda: shell.solve(case.poses), peer, threads, least=rounds(size))
    return [{"vertices": case.vertex_count, **row} for row in rows]


def memory(size: int, _threads: Sequence[int]) -> list[Row]:
    """The growth of this process by the mesh and the bound shell, next to the bytes of CHOLMOD's factor."""
    case = bar("bend 90", size)
    before = _resident()
    shell = sinew_native.ThinShell(sinew_native.SurfaceMesh(case.points, case.faces))
    shell.set_handles(case.handles)
    row: Row = {"vertices": case.vertex_count, "unit": "bytes", "ours": _resident() - before}
    if size <= WITH_PEERS[-1]:
        factor = cholmod(case)
        factor.factorize()
        row["peer"] = factor.bytes
    return [row]


def _resident() -> int:
    """The memory of this process in bytes, from the kernel."""
    status = Path("/proc/self/status").read_text(encoding="utf-8")
    return 1024 * next(int(line.split()[1]) for line in status.splitlines() if line.startswith("VmRSS:"))

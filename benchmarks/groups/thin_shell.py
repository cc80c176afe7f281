# SPDX-License-Identifier: GPL-3.0-or-later
"""Bind, solve and affine basis of the thin shell, next to CHOLMOD, Eigen's LDLT and memory bandwidth.

All solvers get the same matrix: the bi-Laplacian of a bar at its free vertices. Of Sinew the whole call is
timed, with the assembly of the energy and the report; of a peer, only the factorisation or the triangular
solves.
"""

import numpy as np
import scipy.sparse as sparse
import sinew_peers
from cases import Case, bar, quartered
from record import Row
from timing import Work, alternate, rounds

import sinew_native

from . import Options, Task

LARGEST_LDLT = 200_000  # half a million vertices take a minute


def plan(options: Options) -> list[Task]:
    tasks = []
    for size in (*options.sizes, *options.own_sizes):
        keywords = {"size": size, "threads": options.threads, "peers": size in options.sizes}
        tasks.append(Task("thin_shell", ("bind",), {"part": "bind", **keywords}))
        if keywords["peers"] and size <= LARGEST_LDLT:
            tasks.append(Task("thin_shell", ("bind_ldlt",), {"part": "ldlt", **keywords}))
        tasks.append(Task("thin_shell", ("solve", "solve_bound"), {"part": "solve", **keywords}))
        tasks.append(Task("thin_shell", ("basis_bound",), {"part": "basis", **keywords}))
    return tasks


def measure(part: str, size: int, threads: list[int], peers: bool) -> list[Row]:
    rows = {"bind": _bind, "ldlt": _ldlt, "solve": _solve, "basis": _basis}[part](size, threads, peers)
    return [{"size": size, "unit": "s", **row} for row in rows]


def lower_matrix(case: Case) -> tuple[sparse.csc_matrix, np.ndarray]:
    """The lower triangle of the matrix at the free vertices, and a mask of these vertices."""
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    free = np.ones(case.vertex_count, bool)
    free[np.concatenate(case.handles)] = False
    A = sparse.csc_matrix(sinew_native.laplacian_power(mesh, 2))
    return sparse.tril(A[free][:, free], format="csc"), free


def cholmod(lower: sparse.csc_matrix, ordering: str = "amd") -> "sinew_peers.Cholmod":
    lower.sort_indices()
    return sinew_peers.Cholmod(lower.indptr, lower.indices, lower.data, ordering)


class Binder:
    """Binds a new thin shell in each turn."""

    def __init__(self, case: Case, threads: int) -> None:
        self._mesh = sinew_native.SurfaceMesh(case.points, case.faces)
        self._handles, self._threads = case.handles, threads

    def work(self) -> Work:
        return Work(self._bind, self._prepare, repeatable=False)

    def _prepare(self) -> None:
        sinew_native.limit_threads(self._threads)
        self._shell = sinew_native.ThinShell(self._mesh, affine_basis=False)

    def _bind(self) -> None:
        self.report = self._shell.set_handles(self._handles)


def _bind(size: int, threads: list[int], peers: bool) -> list[Row]:
    case = bar("bend 90", size)
    binders = {count: Binder(case, count) for count in threads}
    works = {count: binder.work() for count, binder in binders.items()}
    if peers:
        peer = cholmod(lower_matrix(case)[0])
        works["peer"] = Work(peer.factorize, repeatable=False)
    alternate(works, budget=6.0, least=rounds(size))
    return [
        {
            "work": "bind",
            "threads": count,
            "vertices": case.vertex_count,
            "ours": works[count].best,
            "ours_median": works[count].median,
            "factor_bytes": binders[count].report.factor_bytes,
            **({"peer": works["peer"].best, "peer_median": works["peer"].median} if peers else {}),
            **({"peer_factor_bytes": peer.bytes} if peers else {}),
        }
        for count in threads
    ]


def _ldlt(size: int, threads: list[int], peers: bool) -> list[Row]:
    case = bar("bend 90", size)
    works = {count: Binder(case, count).work() for count in threads}
    works["peer"] = Work(sinew_peers.EigenLdlt(lower_matrix(case)[0]).factorize, repeatable=False)
    alternate(works, least=1 if size > 100_000 else 3)
    return [
        {
            "work": "bind_ldlt",
            "threads": count,
            "vertices": case.vertex_count,
            "ours": works[count].best,
            "peer": works["peer"].best,
        }
        for count in threads
    ]


def _solve(size: int, threads: list[int], peers: bool) -> list[Row]:
    """CHOLMOD keeps its workspace and its result from one solve to the next."""
    case = bar("bend 90", size)
    mesh = sinew_native.SurfaceMesh(case.points, case.faces)
    shell = sinew_native.ThinShell(mesh, affine_basis=False)
    report = shell.set_handles(case.handles)
    works = {
        count: Work(lambda: shell.solve(case.poses), lambda count=count: sinew_native.limit_threads(count))
        for count in threads
    }
    factor_bytes = report.factor_bytes
    if peers:
        lower, free = lower_matrix(case)
        moved = np.zeros_like(case.points)
        for vertices, pose in zip(case.handles, case.poses):
            moved[vertices] = (case.points_posed(pose) - case.points)[vertices]
        A = sparse.csc_matrix(sinew_native.laplacian_power(mesh, 2))
        rhs = np.asfortranarray(-(A[free][:, ~free] @ moved[~free]))
        both = {"peer": cholmod(lower), "peer_metis": cholmod(lower, "metis")}
        for name, peer in both.items():
            peer.factorize()
            works[name] = Work(lambda peer=peer: peer.solve(rhs))
        factor_bytes = both["peer"].value_bytes
    alternate(works, least=rounds(size))
    if peers:
        _require_equal(shell.solve(case.poses)[0][free], case.points[free] + both["peer"].solution, case)
    rows = []
    for count in threads:
        bound = 2 * factor_bytes / sinew_peers.read_bandwidth(factor_bytes, count)
        row = {"threads": count, "vertices": case.vertex_count, "ours": works[count].best}
        row["ours_median"] = works[count].median
        rows.append({"work": "solve_bound", **row, "peer": bound, "bytes": 2 * factor_bytes})
        if peers:
            row |= {"peer": works["peer"].best, "peer_metis": works["peer_metis"].best}
        rows.append({"work": "solve", **row})
    return rows


def _require_equal(ours: np.ndarray, peers: np.ndarray, case: Case) -> None:
    """Stop if the results differ. The condition number of the largest matrix costs half of the digits."""
    worst = np.abs(ours - peers).max() / np.ptp(case.points)
    if not worst < 1e-5:
        raise SystemExit(f"ThinShell and CHOLMOD differ by {worst:.1e} of the size")


def _basis(size: int, threads: list[int], peers: bool) -> list[Row]:
    """The bound is the time to read the basis and the rest points and to write the result, once each."""
    case = quartered(bar("bend 90", size))
    shell = sinew_native.ThinShell(sinew_native.SurfaceMesh(case.points, case.faces))
    shell.set_handles(case.handles)
    moved = sinew_native.AffineBasis(shell).matrix.nbytes + 2 * case.points.nbytes
    works = {
        count: Work(lambda: shell.solve(case.poses), lambda count=count: sinew_native.limit_threads(count))
        for count in threads
    }
    alternate(works, budget=2.0)
    return [
        {
            "work": "basis_bound",
            "threads": count,
            "vertices": case.vertex_count,
            "ours": works[count].best,
            "ours_median": works[count].median,
            "peer": moved / sinew_peers.read_bandwidth(moved, count),
            "bytes": moved,
        }
        for count in threads
    ]

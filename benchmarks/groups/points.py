# SPDX-License-Identifier: GPL-3.0-or-later
"""Space methods on handle points next to SciPy's radial basis functions and to the loop of a paper.

The centres and points of ``Rbf`` are random in a cube, whose values SciPy interpolates by the same kernel and
polynomials. A compact kernel reaches some 20 centres, which SciPy finds by a k-d tree; there the corners of
the cube are centres, too, so that its diagonal is the size that the radius is a share of. The incremental fit
gets handles on two spheres: 10,000 points, half of which are turned. Its peer solves the dense system of all
of them.
"""

import numpy as np
import sinew_peers
from record import Row
from scipy.interpolate import RBFInterpolator
from scipy.sparse import csr_matrix
from scipy.sparse.linalg import splu
from scipy.spatial import cKDTree
from timing import Work, alternate

import sinew_native

from . import Options, Task

WORKS = ("rbf", "rbf_compact", "rbf_basis", "rbf_incremental", "mls_frame")


def plan(options: Options) -> list[Task]:
    tasks = []
    for work in WORKS:
        names = {
            "rbf": ("rbf_bind", "rbf_evaluate"),
            "rbf_compact": ("rbf_compact_bind", "rbf_compact_frame", "rbf_compact_all"),
            "rbf_incremental": ("rbf_incremental", "rbf_incremental_error"),
        }
        share = 100 if options.smallest else 10 if options.quick else 1
        keywords = {"work": work, "share": share, "threads": options.threads}
        tasks.append(Task("points", names.get(work, (work,)), keywords))
    return tasks


def measure(work: str, share: int, threads: list[int]) -> list[Row]:
    works = {
        "rbf": _rbf,
        "rbf_compact": _compact,
        "rbf_basis": _basis,
        "rbf_incremental": _incremental,
        "mls_frame": _mls,
    }
    return works[work](share, threads)


def _rbf(share: int, threads: list[int]) -> list[Row]:
    """A tenth of the points is enough for SciPy, which takes the same time for each."""
    random = np.random.default_rng(1)
    count = 1_000_000 // share
    centres, points = random.uniform(0.0, 1.0, (1000, 3)), random.uniform(0.0, 1.0, (count, 3))
    moves = random.uniform(-0.1, 0.1, centres.shape)
    some = points[::10].copy()
    rbf = sinew_native.Rbf(centres)
    rbf.bind(points)
    out = np.zeros((count, 3), np.float32)
    peers: dict[str, object] = {}

    def bind(count: int) -> Work:
        return Work(
            lambda: sinew_native.Rbf(centres).bind(points), lambda: sinew_native.limit_threads(count), False
        )

    def frame(count: int) -> Work:
        return Work(
            lambda: rbf.warp(centres + moves, out=out), lambda: sinew_native.limit_threads(count), False
        )

    def fit() -> None:
        peers["fit"] = RBFInterpolator(centres, moves, kernel="cubic", degree=2)

    def evaluate() -> None:
        peers["moves"] = peers["fit"](some)

    works: dict[object, Work] = {("bind", count): bind(count) for count in threads}
    works["fit"] = Work(fit, repeatable=False)
    works |= {("frame", count): frame(count) for count in threads}
    works["evaluate"] = Work(evaluate, repeatable=False)
    alternate(works, budget=20.0)
    _require_equal(out[::10] - some, peers["moves"])
    case = f"1,000 centres, {count:,} points"
    common = {"size": count, "vertices": count, "case": case, "unit": "s"}
    return [
        {"work": name, **common, "threads": count, "ours": works[ours, count].best, "peer": scale * peer.best}
        for name, ours, peer, scale in (
            ("rbf_bind", "bind", works["fit"], 1),
            ("rbf_evaluate", "frame", works["evaluate"], count / len(some)),
        )
        for count in threads
    ]


def _compact(share: int, threads: list[int]) -> list[Row]:
    return [
        row
        for centres in ((1000,) if share > 1 else (1000, 3000, 10_000))
        for row in _compact_of(centres, 100_000 // share, threads)
    ]


def _compact_of(centre_count: int, count: int, threads: list[int]) -> list[Row]:
    """SciPy solves the same sparse system, and finds the centres near each point by its k-d tree."""
    random = np.random.default_rng(5)
    centres, points = random.uniform(0.0, 1.0, (centre_count, 3)), random.uniform(0.0, 1.0, (count, 3))
    centres[:8] = np.stack(np.meshgrid((0, 1), (0, 1), (0, 1)), -1).reshape(-1, 3)
    moves = random.uniform(-0.1, 0.1, centres.shape)
    reach = (20 / centre_count / (4 / 3 * np.pi)) ** (1 / 3)
    options = {"kernel": "wendland_c2", "degree": -1, "radius": reach / 3**0.5}
    near = sinew_native.Rbf(centres, **options)
    near.bind(points)
    everywhere = sinew_native.Rbf(centres, kernel="biharmonic", degree=0)
    everywhere.bind(points)
    out, all_out = np.zeros((count, 3), np.float32), np.zeros((count, 3), np.float32)
    found: dict[str, object] = {}

    def values(of: np.ndarray) -> csr_matrix:
        pairs = cKDTree(of).sparse_distance_matrix(cKDTree(centres), reach, output_type="coo_matrix")
        r = pairs.data / reach
        return csr_matrix(((1 - r) ** 4 * (4 * r + 1), (pairs.row, pairs.col)), shape=(len(of), centre_count))

    def factor() -> None:
        found["factor"] = splu(values(centres).tocsc())

    def evaluate() -> None:
        found["moves"] = values(points) @ found["factor"].solve(moves)

    calls = {
        "bind": lambda: sinew_native.Rbf(centres, **options).bind(points),
        "frame": lambda: near.warp(centres + moves, out=out),
        "all": lambda: everywhere.warp(centres + moves, out=all_out),
    }
    works: dict[object, Work] = {
        (name, number): Work(call, lambda number=number: sinew_native.limit_threads(number), False)
        for number in threads
        for name, call in calls.items()
    }
    works |= {"factor": Work(factor, repeatable=False), "evaluate": Work(evaluate, repeatable=False)}
    alternate(works, budget=10.0)
    _require_equal(out - points, found["moves"])
    case = f"{centre_count:,} centres, {count:,} points"
    common = {"size": centre_count, "vertices": count, "case": case, "unit": "s"}
    return [
        {
            "work": f"rbf_compact_{name}",
            **common,
            "threads": number,
            "ours": works[ours, number].best,
            "peer": works[peer or ("all", number)].best,
        }
        for name, ours, peer in (
            ("bind", "bind", "factor"),
            ("frame", "frame", "evaluate"),
            ("all", "frame", None),
        )
        for number in threads
    ]


def _require_equal(ours: np.ndarray, peers: np.ndarray) -> None:
    """Stop if the results differ, since a wrong result must not be timed. Ours have single precision."""
    worst = np.abs(ours - peers).max()
    if not worst < 1e-5:
        raise SystemExit(f"the moves of Sinew and of its peer differ by {worst:.1e}")


def sphere(count: int, centre: float) -> np.ndarray:
    """Points evenly on a sphere of radius 1."""
    k = np.arange(count) + 0.5
    z, angle = 1 - 2 * k / count, np.pi * (1 + 5**0.5) * k
    around = np.sqrt(1 - z * z)
    return np.stack((around * np.cos(angle) + centre, around * np.sin(angle), z), -1)


def _basis(share: int, threads: list[int]) -> list[Row]:
    count = 1_000_000 // share
    parts = [sphere(80, 4.0 * place) for place in range(4)]
    points = np.random.default_rng(2).uniform((-1, -1, -1), (13, 1, 1), (count, 3))
    rbf = sinew_native.Rbf(np.concatenate(parts), [len(part) for part in parts])
    rbf.bind(points)
    posed = rbf.control + np.repeat([[0, 0, 0], [0, 0.2, 0], [0, 0, 0], [0.1, 0, 0.3]], 4, axis=0)
    out = np.zeros((count, 3), np.float32)
    works = {
        number: Work(
            lambda: rbf.warp(posed, out=out), lambda number=number: sinew_native.limit_threads(number)
        )
        for number in threads
    }
    alternate(works)
    common = {"work": "rbf_basis", "size": count, "vertices": count, "unit": "s"}
    return [
        {
            **common,
            "case": f"4 handles, {count:,} points",
            "threads": number,
            "ours": works[number].best,
            "ours_median": works[number].median,
            "peer": count / 30e6,
        }
        for number in threads
    ]


def _incremental(share: int, threads: list[int]) -> list[Row]:
    each = 5000 // min(share, 10)
    parts = [sphere(each, 0.0), sphere(each, 4.0)]
    handles = np.concatenate(parts)
    few = np.random.default_rng(3).uniform(-1, 5, (1000, 3))
    corner, size = handles.min(axis=0), np.ptp(handles, axis=0).max()
    scaled = (handles - corner) / size
    turn = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    moves = np.zeros_like(handles)
    moves[each:] = (parts[1] - (4, 0, 0)) @ turn.T + (4.2, 0.1, 0) - parts[1]

    def dense() -> None:
        """The saddle point system of cubes of distances and quadratics, in the unit box."""
        x, y, z = scaled.T
        P = np.stack((np.ones_like(x), x, y, z, x * x, y * y, z * z, x * y, y * z, z * x), -1)
        square = np.add.outer((scaled**2).sum(1), (scaled**2).sum(1)) - 2 * scaled @ scaled.T
        A = np.zeros((len(x) + 10, len(x) + 10))
        A[:-10, :-10] = np.maximum(square, 0) ** 1.5
        A[:-10, -10:], A[-10:, :-10] = P, P.T
        np.linalg.solve(A, np.concatenate((moves, np.zeros((10, 3)))))

    found: dict[str, object] = {}

    def ours() -> None:
        found["rbf"] = sinew_native.Rbf(handles, [each, each], tolerance=1e-3, precision="double")
        found["report"] = found["rbf"].bind(few)

    works = {
        number: Work(ours, lambda number=number: sinew_native.limit_threads(number), False)
        for number in threads
    }
    works["peer"] = Work(dense, repeatable=False)
    alternate(works, budget=1.0, least=1 if share == 1 else 3, most=3)
    rbf = found["rbf"]
    rbf.bind(handles)
    posed = rbf.control.copy()
    posed[4:] = (posed[4:] - (4, 0, 0)) @ turn.T + (4.2, 0.1, 0)
    longest = np.linalg.norm(posed - rbf.control, axis=1).max()
    off = np.linalg.norm(rbf.warp(posed) - handles - moves, axis=1).max()
    case = f"{len(handles):,} handle points, {len(rbf.centres)} centres"
    common = {"size": len(handles), "vertices": len(handles), "case": case}
    rows = [
        {
            "work": "rbf_incremental",
            **common,
            "unit": "s",
            "threads": number,
            "ours": works[number].best,
            "peer": works["peer"].best,
        }
        for number in threads
    ]
    error = {"work": "rbf_incremental_error", **common, "unit": "of the longest move"}
    return [*rows, {**error, "ours": off / longest, "peer": 1e-3}]


def _mls(share: int, threads: list[int]) -> list[Row]:
    random = np.random.default_rng(4)
    count = 100_000 // share
    handles, points = random.uniform(-1, 1, (50, 3)), random.uniform(-1.2, 1.2, (count, 3))
    posed = handles + random.uniform(-0.2, 0.2, handles.shape)
    mls = sinew_native.Mls(handles, alpha=1.0)
    mls.bind(points)
    out, peers = np.zeros((count, 3), np.float32), np.zeros((count, 3))
    works = {
        number: Work(
            lambda: mls.warp(posed, out=out), lambda number=number: sinew_native.limit_threads(number)
        )
        for number in threads
    }
    works["peer"] = Work(lambda: sinew_peers.rigid_mls(handles, posed, points, peers), repeatable=False)
    alternate(works)
    _require_equal(out, peers)
    common = {"work": "mls_frame", "size": count, "vertices": count, "unit": "s"}
    return [
        {
            **common,
            "case": f"{count:,} points, 50 handles",
            "threads": number,
            "ours": works[number].best,
            "ours_median": works[number].median,
            "peer": works["peer"].best,
        }
        for number in threads
    ]

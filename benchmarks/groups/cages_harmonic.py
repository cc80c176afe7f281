# SPDX-License-Identifier: GPL-3.0-or-later
"""Harmonic coordinates next to Blender's Mesh Deform, exact positive mean values next to sampled ones.

Both methods bind the same points to the same cage. The error is the largest error of a weight. On a cube it
is measured against trilinear functions, which are harmonic there; on cages of 150 faces (a ball, the
automatic cage of a cow, an uneven ring) against Sinew's weights at the finest quality. The time of Mesh
Deform depends on how much of its box a cage fills. At precision 6 it needs more than 16 GB for the cube, so
this case is left out. On large cages Sinew's lattice is compared with its boundary elements, each in a
process of its own.
"""

import itertools
import json
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from cases import read_mesh
from record import Row
from timing import Work, alternate

import sinew_native

from . import Options, Task

HERE = Path(__file__).resolve().parents[1]
sys.path.append(str(HERE.parent / "tools"))

from workshop import debian, shell  # noqa: E402

POINTS = 10_000
LONGEST = 900.0  # seconds: precision 6 takes minutes
RAYS = 4096
MANY_RAYS = 1_000_000  # for the reference, which is the mean over eight rotations of the cage


def plan(options: Options) -> list[Task]:
    if options.smallest:
        small, large = [SMALLEST], [SMALLEST_LARGE]
    elif options.quick:
        small, large = [], []
    else:
        small, large = list(QUALITIES), [case for case in LARGE if case != SMALLEST_LARGE]
    tasks = []
    for case in small:
        works = tuple(f"harmonic_{prefix}{number}" for number in QUALITIES[case] for prefix in ("", "error_"))
        reference = "fine" if options.smallest else "finest"
        tasks.append(Task("cages_harmonic", works, {"case": case, "reference": reference}))
    for case in large:
        works = ("harmonic_large", "harmonic_large_peak")
        tasks.append(Task("cages_harmonic", works, {"case": case}))
    for threads in options.threads:
        works = ("positive_rays", "positive_point", "positive_error")
        keywords = {"threads": threads, "rays": RAYS if options.smallest else MANY_RAYS}
        tasks.append(Task("cages_harmonic", works, {"case": "positive", **keywords}))
    return tasks


def measure(case: str, threads: int = 0, reference: str = "finest", rays: int = MANY_RAYS) -> list[Row]:
    if case in LARGE:
        found = _large(case)
    else:
        found = _positive(threads, rays) if threads else _harmonic(case, reference)
    return [{"size": POINTS, "vertices": POINTS, "case": case, **row} for row in found]


def cube() -> tuple[np.ndarray, np.ndarray]:
    points = np.array(list(itertools.product((0.0, 1.0), repeat=3)))[:, ::-1]
    faces = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    return points, np.array(faces)


def ring(around: int, across: int) -> tuple[np.ndarray, np.ndarray]:
    """An uneven torus of triangles."""
    u, v = np.meshgrid(np.arange(around), np.arange(across), indexing="ij")
    a, b = 2 * np.pi * u / around, 2 * np.pi * (v + 0.5 * (u % 2)) / across
    thickness = 0.35 + 0.1 * np.sin(3.0 * a)
    height = 0.3 * np.cos(2.0 * a) + thickness * np.sin(b)
    radius = 1.0 + thickness * np.cos(b)
    points = np.stack((radius * np.cos(a), radius * np.sin(a), height), -1).reshape(-1, 3)
    number = np.arange(around * across).reshape(around, across)
    after = np.roll(number, -1, 1)
    p, q, r, s = number, np.roll(number, -1, 0), np.roll(after, -1, 0), after
    first = np.stack((p, q, r), -1)
    second = np.stack((p, r, s), -1)
    return points, np.concatenate((first.reshape(-1, 3), second.reshape(-1, 3)))


def ball(around: int, down: int) -> tuple[np.ndarray, np.ndarray]:
    """A sphere of 2 * around * (down - 1) triangles."""
    theta, phi = np.pi * np.arange(1, down) / down, 2.0 * np.pi * np.arange(around) / around
    rings = np.stack(
        np.broadcast_arrays(
            np.sin(theta)[:, None] * np.cos(phi), np.sin(theta)[:, None] * np.sin(phi), np.cos(theta)[:, None]
        ),
        -1,
    )
    points = np.vstack(((0.0, 0.0, 1.0), rings.reshape(-1, 3), (0.0, 0.0, -1.0)))
    number = 1 + np.arange(around * (down - 1)).reshape(down - 1, around)
    after = np.roll(number, -1, 1)
    p, q, r, s = number[:-1], number[1:], after[1:], after[:-1]
    top = np.stack((np.zeros(around, int), number[0], after[0]), -1)
    end = np.stack((np.full(around, len(points) - 1), after[-1], number[-1]), -1)
    return points, np.concatenate(
        [top, *(np.stack(t, -1).reshape(-1, 3) for t in ((p, q, r), (p, r, s))), end]
    )


def cow() -> tuple[np.ndarray, np.ndarray]:
    return read_mesh(HERE.parent / "blend_samples" / "models" / "spot.obj")


def around_cow() -> tuple[np.ndarray, np.ndarray]:
    return sinew_native.automatic_cage(sinew_native.SurfaceMesh(*cow()), 150)[:2]


CAGES = {
    "cube": cube,
    "ball of 150 faces": lambda: ball(15, 6),
    "cow, 150 faces": around_cow,
    "ring of 150 faces": lambda: ring(15, 5),
}
QUALITIES = {  # of Sinew, by the precision of Mesh Deform that it is compared with
    "cube": {5: "fast"},
    "ball of 150 faces": {5: "fast", 6: "fine"},
    "cow, 150 faces": {5: "fast", 6: "medium"},
    "ring of 150 faces": {5: "fast", 6: "medium"},
}
LARGE = {"320 faces": (20, 8), "2000 faces": (50, 20), "5000 faces": (100, 25)}
SMALLEST, SMALLEST_LARGE = "ring of 150 faces", "320 faces"


def inside(case: str, count: int = POINTS) -> np.ndarray:
    random = np.random.default_rng(0)
    if case == "cube":
        return random.uniform(0.01, 0.99, (count, 3))
    if case.startswith("ball"):
        direction = random.standard_normal((count, 3))
        direction /= np.linalg.norm(direction, axis=1)[:, None]
        return 0.8 * np.cbrt(random.uniform(0.0, 1.0, (count, 1))) * direction
    if case.startswith("cow"):
        points, faces = cow()
        corners = points[faces[random.integers(0, len(faces), count)]]
        return np.einsum("nk,nkx->nx", random.dirichlet(np.ones(corners.shape[1]), count), corners)
    a, b = random.uniform(0.0, 2.0 * np.pi, (2, count))
    thickness = 0.7 * (0.35 + 0.1 * np.sin(3.0 * a)) * np.sqrt(random.uniform(0.0, 1.0, count))
    radius, height = 1.0 + thickness * np.cos(b), 0.3 * np.cos(2.0 * a) + thickness * np.sin(b)
    points = np.stack((radius * np.cos(a), radius * np.sin(a), height), -1)
    cage = sinew_native.PositiveMeanValue(
        sinew_native.SurfaceMesh(*ring(15, 5)), exact=False, directions=8, outside="mean_value"
    )
    outside = cage.bind(points).outside
    return np.delete(points, outside, axis=0)


def trilinear(points: np.ndarray) -> np.ndarray:
    corners = cube()[0]
    return np.prod(np.where(corners > 0.5, points[:, None], 1.0 - points[:, None]), axis=2)


def _harmonic(case: str, reference: str) -> list[Row]:
    cage, faces = CAGES[case]()
    points = inside(case)
    mesh = sinew_native.SurfaceMesh(cage, faces)

    def bind(quality: str) -> "sinew_native.Harmonic":
        harmonic = sinew_native.Harmonic(mesh, quality=quality)
        harmonic.bind(points)
        return harmonic

    exact = trilinear(points) if case == "cube" else bind(reference).vertex_weights
    rows = []
    for precision, quality in QUALITIES[case].items():
        seconds, theirs = _mesh_deform(cage, faces, points, precision)
        error = float(np.abs(bind(quality).vertex_weights - exact).max())
        work = Work(lambda quality=quality: bind(quality), repeatable=False)
        time = alternate({"ours": work})["ours"].median
        about = {"quality": quality, "cage_faces": len(faces)}
        rows += [
            {"work": f"harmonic_{precision}", "unit": "s", "ours": time, "peer": seconds, **about},
            {
                "work": f"harmonic_error_{precision}",
                "unit": "",
                "ours": error,
                "peer": float(np.abs(theirs - exact).max()),
                **about,
            },
        ]
    return rows


def _large(case: str) -> list[Row]:
    """Boundary elements have three unknowns per face on such cages, at any quality."""
    apart = {}
    for side, solver in (("ours", "lattice"), ("peer", "boundary")):
        command = [sys.executable, "-m", "groups.cages_harmonic", solver, case]
        done = subprocess.run(command, check=True, capture_output=True, text=True, cwd=HERE)
        apart[side] = json.loads(done.stdout)

    def row(work: str, unit: str, what: str) -> Row:
        return {"work": work, "unit": unit} | {side: apart[side][what] for side in apart}

    errors = {f"{side}_error": apart[side]["error"] for side in apart}
    return [row("harmonic_large", "s", "seconds") | errors, row("harmonic_large_peak", "bytes", "peak")]


def _bind_large(solver: str, case: str) -> dict[str, float]:
    from .memory import Growth

    cage, faces = ring(*LARGE[case])
    points = inside("ring")
    harmonic = sinew_native.Harmonic(sinew_native.SurfaceMesh(cage, faces), solver=solver)
    growth = Growth()
    begin = time.perf_counter()
    error = harmonic.bind(points).error
    return {"seconds": time.perf_counter() - begin, "error": error, "peak": growth.counted()["peak"]}


def _mesh_deform(
    cage: np.ndarray, faces: np.ndarray, points: np.ndarray, precision: int
) -> tuple[float, np.ndarray]:
    debian.install(debian.BLENDER)
    with tempfile.TemporaryDirectory() as folder:
        case, out = Path(folder) / "case.npz", Path(folder) / "out.npz"
        np.savez(case, cage=cage, faces=faces, points=points, precision=precision)
        script = HERE / "mesh_deform.py"
        words = ["blender", "--background", "--factory-startup", "--python", script, "--", case, out]
        status = shell.run(words, timeout=LONGEST, quiet=True)
        if not out.is_file():
            raise SystemExit(f"Mesh Deform at precision {precision} left no weights (status {status})")
        found = np.load(out)
        return float(found["seconds"]), found["weights"]


def _positive(threads: int, rays: int) -> list[Row]:
    """A concave cage of 300 faces."""
    cage, faces = ring(15, 10)
    points = inside("ring", 2_000)
    few = points[:40]

    def weights(at: np.ndarray, turn: np.ndarray | None = None, **options: object) -> np.ndarray:
        turn = np.eye(3) if turn is None else turn
        mesh = sinew_native.SurfaceMesh(cage @ turn, faces)
        positive = sinew_native.PositiveMeanValue(mesh, precision="double", outside="mean_value", **options)
        positive.bind(at @ turn)
        return positive.vertex_weights

    turns = [np.linalg.qr(np.random.default_rng(k).standard_normal((3, 3)))[0] for k in range(8)]
    turns = [turn * np.sign(np.linalg.det(turn)) for turn in turns]
    truth = np.mean([weights(few, turn, exact=False, directions=rays) for turn in turns], axis=0)
    errors = {
        "ours": float(np.abs(weights(few) - truth).max()),  # as exact as the reference allows
        "peer": float(np.abs(weights(few, exact=False, directions=RAYS) - truth).max()),
    }
    sinew_native.limit_threads(threads)
    works = alternate(
        {
            "exact": Work(lambda: weights(points)),
            "rays": Work(lambda: weights(points, exact=False, directions=RAYS)),
        }
    )
    sinew_native.limit_threads(0)
    exact, cast = (works[name].median / len(points) for name in ("exact", "rays"))
    rows = [
        {"work": "positive_rays", "unit": "s", "ours": exact, "peer": cast},
        {"work": "positive_point", "unit": "s", "ours": exact, "peer": 200e-6},
        {"work": "positive_error", "unit": "", **errors},
    ]
    return [{"threads": threads, **row} for row in rows]


if __name__ == "__main__":
    print(json.dumps(_bind_large(*sys.argv[1:])))

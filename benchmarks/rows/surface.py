# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of what is built on other methods: mesh sequences, skeletons, subdivision."""

from collections.abc import Sequence

import numpy as np
import sinew_peers
from cases import STILL, about, bar
from record import Row
from timing import Timed, alternate, compare, require_equal

import sinew_native

from .nonlinear import bound

POSES, LIMIT = 30, 30e-3  # of the skeleton; seconds
PINNED = 1e3


def sequence(size: int, threads: Sequence[int]) -> list[Row]:
    """An animation of 16 frames that is edited at three keys; the frame is between two of them."""
    case = bar("bend 90", size)
    method, arap = bound(case, sinew_native.MeshSequence), bound(case)
    edit = about(np.zeros(3), (0.2, 1.0, 0.0), 35.0, (0.0, 2.0, 5.0))
    keys = np.array([(frame, 1, *map_.ravel()) for frame, map_ in ((0, STILL), (8, edit), (15, STILL))])
    middle = 6
    incoming = _animated(case.points, middle / 16)
    poses = method.poses(middle, keys=keys, incoming=incoming)
    ours = lambda: method.solve_frame(middle, keys=keys, incoming=incoming)  # noqa: E731
    rows = compare(ours, lambda: arap.solve(poses, incoming=incoming), threads, budget=20.0)
    return [{"vertices": case.vertex_count, **row} for row in rows]


def _animated(points: np.ndarray, share: float) -> np.ndarray:
    """The bar, bent and twisted by up to 50 degrees."""
    swing = np.sin(2 * np.pi * share)
    length = np.ptp(points[:, 0])
    twist, bend = np.radians(40) * swing / length * points[:, 0], np.radians(50) * swing / length + 1e-9
    y = np.cos(twist) * points[:, 1] - np.sin(twist) * points[:, 2]
    z = np.sin(twist) * points[:, 1] + np.cos(twist) * points[:, 2]
    along, away = bend * points[:, 0], 1 / bend - y
    return np.column_stack([np.sin(along) * away, 1 / bend - np.cos(along) * away, z])


def skeleton(_size: int, threads: Sequence[int]) -> list[Row]:
    """The feet are pinned and a hand goes elsewhere."""
    heads, tails, parents, hand, feet = _figure()
    bones = np.array([*np.repeat(feet, 2), hand])
    points = np.array([end[foot] for foot in feet for end in (heads, tails)] + [tails[hand]])
    options = {"weights": np.array([PINNED] * 4 + [1.0]), "moving_roots": np.arange(len(parents)) == 0}
    rng = np.random.default_rng(0)
    goals = [np.vstack([points[:-1], points[-1] + 0.25 * rng.normal(size=3)]) for _ in range(POSES)]
    posed = sinew_native.Skeleton(heads, tails, parents)
    rows: list[Row] = []
    for count in threads:
        sinew_native.limit_threads(count)
        works = [Timed(lambda goal=goal: posed.solve(bones, points, goal, **options)) for goal in goals]
        alternate(dict(enumerate(works)))
        slowest = max(work.best for work in works)
        rows.append({"threads": count, "ours": slowest, "peer": LIMIT})
    return rows


def _figure() -> tuple[np.ndarray, np.ndarray, np.ndarray, int, list[int]]:
    """The 60 bones of a figure 1.6 tall with fingers: heads, tails and parents; a hand and the feet."""
    heads: list[np.ndarray] = []
    tails: list[np.ndarray] = []
    parents: list[int] = []

    def add(parent: int, *along: float) -> int:
        heads.append(tails[parent] if parents else np.array((0.0, 0.0, 1.0)))
        tails.append(heads[-1] + along)
        parents.append(parent)
        return len(parents) - 1

    hip = spine = add(-1, 0, 0, 0.1)
    for _ in range(13):
        spine = add(spine, 0, 0, 0.5 / 13)
    hands, feet = [], []
    for side in (1, -1):
        arm = spine
        for length in (0.15, 0.28, 0.26, 0.1):
            arm = add(arm, length * side, 0, 0)
        hands.append(arm)
        for finger in range(5):
            bone = arm
            for _ in range(3):
                bone = add(bone, 0.03 * side, 0.02 * (finger - 2), 0)
        shin = add(add(add(hip, 0.1 * side, 0, -0.1), 0, 0, -0.5), 0, -0.02, -0.45)
        feet.append(add(shin, 0, -0.15, -0.04))
    return np.array(heads), np.array(tails), np.array(parents), hands[0], feet


def subdivision(size: int, threads: Sequence[int]) -> list[Row]:
    """A bumpy sheet of quads, split three times."""
    level = 3
    side = round(np.sqrt(size) / 2**level)
    y, x = np.meshgrid(*[np.linspace(-1.0, 1.0, side + 1)] * 2, indexing="ij")
    sheet = np.stack((x, y, 0.1 * np.sin(9.0 * x) * np.cos(7.0 * y)), axis=-1)
    points = sheet.reshape(-1, 3).astype(np.float32)
    number = np.arange((side + 1) ** 2, dtype=np.int32).reshape(side + 1, side + 1)
    quads = np.stack((number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]), axis=-1)
    quads = quads.reshape(-1, 4)
    peer = sinew_peers.StencilEvaluator(len(points), quads, level)
    ours = sinew_native.SubdivisionSurface(sinew_native.SurfaceMesh(points, quads), level=level)
    out = np.empty((ours.vertex_count, 3), np.float32)
    peer.refine(points)
    require_equal(ours.refine(points, out), peer.result, 1e-5)
    refine = lambda: ours.refine(points, out)  # noqa: E731
    rows = compare(refine, lambda: peer.refine(points), threads, budget=12.0, most=40)
    return [{"vertices": ours.vertex_count, **row} for row in rows]

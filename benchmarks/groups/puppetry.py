# SPDX-License-Identifier: GPL-3.0-or-later
"""Posing a figure of 60 bones: an iteration, a pose, and SciPy's least squares on the same residuals."""

import time

import numpy as np
from record import Row
from scipy.optimize import least_squares
from timing import Work, alternate

import sinew_native

from . import Options, Task

MOST_ITERATION, MOST_POSE = 1e-3, 30e-3  # seconds
PINNED = 1e3
Bones = tuple[np.ndarray, np.ndarray, np.ndarray]  # heads, tails, parents


def plan(options: Options) -> list[Task]:
    works = ("puppet_iteration", "puppet_pose", "puppet_peer")
    drags = 3 if options.smallest else 30
    return [Task("puppetry", works, {"drags": drags, "threads": options.threads})]


def measure(drags: int, threads: list[int]) -> list[Row]:
    heads, tails, parents, hand, feet = figure()
    skeleton = sinew_native.Skeleton(heads, tails, parents)
    moving = np.arange(len(parents)) == 0
    bones = np.array([*np.repeat(feet, 2), hand])
    points = np.array([end[foot] for foot in feet for end in (heads, tails)] + [tails[hand]])
    weights = np.array([PINNED] * 4 + [1.0])
    rng = np.random.default_rng(0)
    goals = [np.vstack([points[:-1], points[-1] + 0.25 * rng.normal(size=3)]) for _ in range(drags)]

    def pose(goal: np.ndarray, **options: object):
        return skeleton.solve(bones, points, goal, weights=weights, moving_roots=moving, **options)

    reports = [pose(goal)[2] for goal in goals]
    steps = [report.iterations + report.rejected for report in reports]
    rows: list[Row] = []
    common = {"size": len(parents), "unit": "s"}
    for count in threads:
        sinew_native.limit_threads(count)
        works = alternate({str(k): Work(lambda goal=goal: pose(goal)) for k, goal in enumerate(goals)})
        seconds = [work.best for work in works.values()]
        iteration = sum(seconds) / sum(steps)
        facts = {"iterations": float(np.median(steps)), "threads": count, **common}
        rows.append({"work": "puppet_iteration", "ours": iteration, "peer": MOST_ITERATION, **facts})
        rows.append({"work": "puppet_pose", "ours": max(seconds), "peer": MOST_POSE, **facts})
        begin = time.perf_counter()
        theirs = scipys((heads, tails, parents), bones, points, goals[0], weights)
        peer = time.perf_counter() - begin
        note = {"energy_ratio": float(theirs / max(reports[0].energy, 1e-300))}
        rows.append({"work": "puppet_peer", "ours": seconds[0], "peer": peer, **facts, **note})
    return rows


def figure() -> tuple[np.ndarray, np.ndarray, np.ndarray, int, list[int]]:
    """Bones of a figure 1.6 tall with fingers; a hand and the feet."""
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


def scipys(
    skeleton: Bones, bones: np.ndarray, points: np.ndarray, goals: np.ndarray, weights: np.ndarray
) -> float:
    """F at the end of SciPy's least squares, with differences for its slopes, from the same start."""
    heads, tails, parents = skeleton
    ends = np.vstack([heads, tails])
    size = np.linalg.norm(ends.max(axis=0) - ends.min(axis=0))
    count = len(parents)

    def residuals(x: np.ndarray) -> np.ndarray:
        turns, move = x[:-3].reshape(count, 3), size * x[-3:]
        angle = np.linalg.norm(turns, axis=1)
        axis = turns / np.maximum(angle, 1e-300)[:, None]
        K = np.zeros((count, 3, 3))
        K[:, 0, 1], K[:, 0, 2], K[:, 1, 2] = -axis[:, 2], axis[:, 1], -axis[:, 0]
        K -= K.transpose(0, 2, 1)
        own = np.eye(3) + np.sin(angle)[:, None, None] * K + (1 - np.cos(angle))[:, None, None] * (K @ K)
        turn, place = np.empty((count, 3, 3)), np.empty((count, 3))
        for bone, parent in enumerate(parents):
            turn[bone] = own[bone] if parent < 0 else turn[parent] @ own[bone]
            place[bone] = (
                heads[bone] + move
                if parent < 0
                else place[parent] + turn[parent] @ (heads[bone] - heads[parent])
            )
        at = place[bones] + np.einsum("kij,kj->ki", turn[bones], points - heads[bones])
        gaps = np.sqrt(weights)[:, None] * (at - goals) / size
        return np.concatenate([gaps.ravel(), 1e-2 * turns[parents >= 0].ravel()])

    start = np.zeros(3 * count + 3)
    start[3:-3:3] = 1e-3
    return float(least_squares(residuals, start, max_nfev=60).cost)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Frames of an animation edited at keys: one frame next to one of ``Arap``, and many frames at once."""

import numpy as np
from cases import STILL, Case, about, bar
from record import Row
from timing import Work, alternate

import sinew_native

from . import Options, Task

FRAMES = 16


def plan(options: Options) -> list[Task]:
    sizes = (10_000,) if options.quick or options.smallest else (10_000, 50_000)
    works = ("sequence_frame", "sequence_at_once", "sequence_threads")
    return [Task("sequence", works, {"size": size, "threads": options.threads}) for size in sizes]


def measure(size: int, threads: list[int]) -> list[Row]:
    case = bar("bend 90", size)
    method = _bound(sinew_native.MeshSequence, case)
    arap = _bound(sinew_native.Arap, case)
    numbers = np.arange(FRAMES)
    shapes = np.stack([_animated(case.points, number / FRAMES) for number in numbers])
    edit = about(np.zeros(3), (0.2, 1.0, 0.0), 35.0, (0.0, 2.0, 5.0))
    keys = np.array([(frame, 1, *map_.ravel()) for frame, map_ in ((0, STILL), (8, edit), (15, STILL))])
    middle = 6
    incoming = shapes[middle]
    poses = method.poses(middle, keys=keys, incoming=incoming)

    def frame() -> None:
        method.solve_frame(middle, keys=keys, incoming=incoming)

    def one_by_one() -> None:
        for number, shape in zip(numbers, shapes, strict=True):
            method.solve_frame(number, keys=keys, incoming=shape)

    def at_once() -> None:
        method.solve_frames(numbers, shapes, keys=keys)

    works: dict[tuple, Work] = {}
    for count in threads:

        def prepare(count: int = count) -> None:
            sinew_native.limit_threads(count)

        works["frame", count] = Work(frame, prepare)
        works["arap", count] = Work(lambda: arap.solve(poses, incoming=incoming), prepare)
        works["one by one", count] = Work(one_by_one, prepare, repeatable=False)
        works["at once", count] = Work(at_once, prepare, repeatable=False)
    alternate(works, budget=20.0)
    rows: list[Row] = []
    for count in threads:
        common = {"size": size, "threads": count, "vertices": case.vertex_count, "unit": "s"}
        pairs = [
            ("sequence_frame", "frame", "arap", count),
            ("sequence_at_once", "at once", "one by one", count),
        ]
        pairs += [("sequence_threads", "at once", "at once", 1)] if count > 1 and 1 in threads else []
        rows += [
            {**common, "work": work, "ours": works[ours, count].best, "peer": works[peer, by].best}
            for work, ours, peer, by in pairs
        ]
    return rows


def _bound(method: type, case: Case) -> object:
    made = method(sinew_native.SurfaceMesh(case.points, case.faces))
    made.set_handles(case.handles)
    return made


def _animated(points: np.ndarray, share: float) -> np.ndarray:
    """The bar, bent and twisted by up to 50 degrees."""
    swing = np.sin(2 * np.pi * share)
    length = np.ptp(points[:, 0])
    twist, bend = np.radians(40) * swing / length * points[:, 0], np.radians(50) * swing / length + 1e-9
    y = np.cos(twist) * points[:, 1] - np.sin(twist) * points[:, 2]
    z = np.sin(twist) * points[:, 1] + np.cos(twist) * points[:, 2]
    along, away = bend * points[:, 0], 1 / bend - y
    return np.column_stack([np.sin(along) * away, 1 / bend - np.cos(along) * away, z])

# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions that go where the caller says, in single precision."""

import threading

import numpy as np
import pytest

import sinew_native as sn

from .meshes import BENT, METHODS, bound

POSES = np.ascontiguousarray(BENT)


@pytest.mark.parametrize("method", METHODS)
def test_positions_in_the_callers_array_are_those_of_the_answer_rounded(method: type) -> None:
    surface, points, _ = bound(method)
    wanted, told = surface.solve(POSES, incoming=points + 0.1)
    room = np.full((len(points) + 2, 3), -1.0, dtype=np.float32)
    positions, report = surface.solve(POSES, incoming=points + 0.1, out=room[1:-1])
    assert np.shares_memory(positions, room)
    np.testing.assert_array_equal(positions, wanted.astype(np.float32))
    np.testing.assert_array_equal(room[[0, -1]], -1.0)
    assert report.energy == told.energy


@pytest.mark.parametrize("method", METHODS)
def test_what_cannot_be_written_in_place_is_refused(method: type) -> None:
    surface, points, _ = bound(method)
    shape = (len(points), 3)
    read_only = np.zeros(shape, dtype=np.float32)
    read_only.flags.writeable = False
    shifted = np.zeros(4 * 3 * len(points) + 1, dtype=np.uint8)[1:].view(np.float32).reshape(shape)
    others = (
        np.zeros(shape),
        np.zeros(shape, dtype=">f4"),
        np.zeros(shape, dtype=np.float32, order="F"),
        np.zeros((len(points), 6), dtype=np.float32)[:, ::2],
        read_only,
        shifted,
        points.tolist(),
        "here",
    )
    for bad in others:
        with pytest.raises(TypeError, match="out: a writable C-contiguous float32 array is needed"):
            surface.solve(POSES, out=bad)
    for wrong in ((len(points) + 1, 3), (3, len(points)), (len(points), 3, 1), (3 * len(points),), (0, 3)):
        with pytest.raises(sn.InvalidConstraint, match=rf"out: the shape must be \({len(points)}, 3\)"):
            surface.solve(POSES, out=np.zeros(wrong, dtype=np.float32))
    assert not read_only.any()


@pytest.mark.parametrize("method", METHODS)
def test_positions_beyond_single_precision_are_refused(method: type) -> None:
    surface, points, _ = bound(method)
    far = POSES.copy()
    far[:, 0, 3] = 1e39
    room = np.empty((len(points), 3), dtype=np.float32)
    with pytest.raises(sn.InvalidConstraint, match="not finite in single precision"):
        surface.solve(far, out=room)
    surface.solve(POSES, out=room)
    np.testing.assert_array_equal(room, surface.solve(POSES)[0].astype(np.float32))


def test_threads_and_progress_calls_do_not_disturb_each_other() -> None:
    """The memory that a solve keeps for the next one belongs to one call at a time."""
    surface, points, _ = bound(sn.Arap)
    poses = [POSES + 0.01 * number * np.eye(4)[3] for number in range(4)]
    wanted = [surface.solve(pose)[0].astype(np.float32) for pose in poses]
    other = np.empty((len(points), 3), dtype=np.float32)

    def again(_fraction: float, _stage: str) -> bool:
        surface.solve(poses[0], out=other)
        return True

    found = [np.empty((len(points), 3), dtype=np.float32) for _ in poses]

    def run(number: int) -> None:
        for _ in range(5):
            surface.solve(poses[number], out=found[number], progress=again if number == 3 else None)

    threads = [threading.Thread(target=run, args=(number,)) for number in range(4)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for one, expected in zip(found, wanted, strict=True):
        np.testing.assert_array_equal(one, expected)
    np.testing.assert_array_equal(other, wanted[0])

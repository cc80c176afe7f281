# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions that go where the caller says, in single precision."""

import threading
from collections.abc import Callable

import numpy as np
import pytest

import sinew_native as sn

from .cages import CUBE, QUADS
from .meshes import BENT
from .methods import bound

POSES = np.ascontiguousarray(BENT)


Call = Callable[..., np.ndarray]


def solve() -> Call:
    """What a surface method writes: called with a scale of the motion and where to write."""
    surface, _, _ = bound(sn.ThinShell)
    return lambda scale=1.0, **out: surface.solve(POSES * [1, 1, 1, scale], **out)[0]


def warp() -> Call:
    """The same of a space method."""
    coordinates = sn.MeanValue(sn.SurfaceMesh(CUBE, QUADS))
    coordinates.bind(np.random.default_rng(1).uniform(0, 1, (81, 3)))
    return lambda scale=1.0, **out: coordinates.warp(2 * scale * CUBE, **out)


EVERY_CALL = pytest.mark.parametrize("make", [solve, warp])


@EVERY_CALL
def test_positions_in_the_callers_array_are_those_of_the_answer_rounded(make: Callable[[], Call]) -> None:
    call = make()
    room = np.full((83, 3), -1.0, dtype=np.float32)
    positions = call(out=room[1:-1])
    assert np.shares_memory(positions, room)
    np.testing.assert_array_equal(positions, call().astype(np.float32))
    np.testing.assert_array_equal(room[[0, -1]], -1.0)


@EVERY_CALL
def test_what_cannot_be_written_in_place_is_refused(make: Callable[[], Call]) -> None:
    call, shape = make(), (81, 3)
    read_only = np.zeros(shape, dtype=np.float32)
    read_only.flags.writeable = False
    shifted = np.zeros(4 * 3 * 81 + 1, dtype=np.uint8)[1:].view(np.float32).reshape(shape)
    others = (
        np.zeros(shape),
        np.zeros(shape, dtype=">f4"),
        np.zeros(shape, dtype=np.float32, order="F"),
        np.zeros((81, 6), dtype=np.float32)[:, ::2],
        read_only,
        shifted,
        [[0.0] * 3] * 81,
        "here",
    )
    for bad in others:
        with pytest.raises(TypeError, match="out: a writable C-contiguous float32 array is needed"):
            call(out=bad)
    for wrong in ((82, 3), (3, 81), (81, 3, 1), (3 * 81,), (0, 3)):
        with pytest.raises(sn.InvalidConstraint, match=r"out: the shape must be \(81, 3\)"):
            call(out=np.zeros(wrong, dtype=np.float32))
    assert not read_only.any()


@EVERY_CALL
def test_positions_beyond_single_precision_are_refused(make: Callable[[], Call]) -> None:
    call, room = make(), np.empty((81, 3), dtype=np.float32)
    with pytest.raises(sn.InvalidConstraint, match="not finite in single precision"):
        call(1e39, out=room)
    np.testing.assert_array_equal(call(out=room), call().astype(np.float32))


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

# SPDX-License-Identifier: GPL-3.0-or-later
"""Positions that go where the caller says, in single precision."""

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import sinew_native as sn

from .cages import CUBE, QUADS
from .meshes import BENT
from .methods import bound

SHAPE = (81, 3)


def solve() -> Callable[..., np.ndarray]:
    """What a surface method writes: called with a scale of the motion and where to write."""
    surface, _, _ = bound(sn.ThinShell)
    return lambda scale=1.0, **out: surface.solve(BENT * [1, 1, 1, scale], **out)[0]


def warp() -> Callable[..., np.ndarray]:
    """The same of a space method."""
    coordinates = sn.MeanValue(sn.SurfaceMesh(CUBE, QUADS))
    coordinates.bind(np.random.default_rng(1).uniform(0, 1, SHAPE))
    return lambda scale=1.0, **out: coordinates.warp(2 * scale * CUBE, **out)


EVERY_CALL = pytest.mark.parametrize("call", [solve(), warp()], ids=["solve", "warp"])


def floats(shape: tuple[int, ...] = SHAPE, **kind: object) -> np.ndarray:
    return np.zeros(shape, **{"dtype": np.float32} | kind)


@EVERY_CALL
def test_positions_in_the_callers_array_are_those_of_the_answer_rounded(call: Callable) -> None:
    room = floats((83, 3)) - 1
    positions = call(out=room[1:-1])
    assert np.shares_memory(positions, room)
    np.testing.assert_array_equal(positions, call().astype(np.float32))
    np.testing.assert_array_equal(room[[0, -1]], -1.0)
    with pytest.raises(sn.InvalidConstraint, match="not finite in single precision"):
        call(1e39, out=room[1:-1])


@EVERY_CALL
def test_what_cannot_be_written_in_place_is_refused(call: Callable) -> None:
    read_only = floats()
    read_only.flags.writeable = False
    shifted = np.zeros(4 * 3 * 81 + 1, dtype=np.uint8)[1:].view(np.float32).reshape(SHAPE)
    others = (floats(dtype=float), floats(dtype=">f4"), floats(order="F"), floats((81, 6))[:, ::2])
    for bad in (*others, read_only, shifted, [[0.0] * 3] * 81, "here"):
        with pytest.raises(TypeError, match="out: a writable C-contiguous float32 array is needed"):
            call(out=bad)
    for wrong in ((82, 3), (3, 81), (81, 3, 1), (3 * 81,), (0, 3)):
        with pytest.raises(sn.InvalidConstraint, match=r"out: the shape must be \(81, 3\)"):
            call(out=floats(wrong))
    assert not read_only.any()


def test_threads_and_progress_calls_do_not_disturb_each_other() -> None:
    """The memory that a solve keeps for the next one belongs to one call at a time."""
    surface, _, _ = bound(sn.Arap)
    poses = [BENT + 0.01 * number * np.eye(4)[3] for number in range(4)]
    wanted = [surface.solve(pose)[0].astype(np.float32) for pose in poses]
    other = floats()

    def again(_fraction: float, _stage: str) -> bool:
        surface.solve(poses[0], out=other)
        return True

    def run(number: int) -> np.ndarray:
        found = floats()
        for _ in range(5):
            surface.solve(poses[number], out=found, progress=again if number == 3 else None)
        return found

    with ThreadPoolExecutor(4) as threads:
        np.testing.assert_array_equal(list(threads.map(run, range(4))), wanted)
    np.testing.assert_array_equal(other, wanted[0])

# SPDX-License-Identifier: GPL-3.0-or-later
"""Threads share objects."""

import pytest

from .methods import SPACE_METHODS, SURFACE_METHODS, called
from .programs import output_of

PROGRAM = """
import faulthandler, sys, threading, time
import numpy as np
import sinew_native as sn
from tests.bindings.meshes import BENT, ends, grid, sphere
from tests.bindings.methods import control, inside, made, required

faulthandler.dump_traceback_later(60, exit=True)
method = getattr(sn, sys.argv[1])
if issubclass(method, sn.SurfaceMethod):
    points, faces = grid(22)
    mesh = sn.SurfaceMesh(points, faces)
    def bind(one, k): one.set_handles(ends(points, 1.6 + k % 3))
    def rebind(one, other, k): one.rebind(other, ends(points, 1.6 + k % 3))
    def use(one): assert np.isfinite(one.solve(BENT, max_iterations=3)[0]).all()
    def reuse(one, other): one.can_reuse(other)
else:
    points, faces = sphere(1)
    mesh = sn.SurfaceMesh(points, faces)
    within = inside(points, 400)
    if "base" in required(method):  # the vertices of its mesh alone can be bound
        within = np.tile(points, (400 // len(points) + 1, 1))
    pose = control(method, mesh) * (1.0, 2.0, 1.0)
    buffer = np.empty((100, 3), np.float32)
    def bind(one, k): one.bind(within[: 100 * (1 + k % 4)])
    def rebind(one, other, k): one.rebind(other, within[: 100 * (1 + k % 4)])
    def use(one):
        assert np.isfinite(one.warp(pose)).all()
        one.warp(pose, np.empty_like(buffer))
    def reuse(one, other): one.can_reuse(other, within)
readable = [n for n in dir(method) if isinstance(getattr(method, n), property) and n != "rest"]
one, other = made(method, mesh), made(method, mesh)
bind(one, 0), bind(other, 0)
def read(k): [getattr(one, name) for name in readable]
work = [
    lambda k: bind(one, k),
    lambda k: bind(one, k + 1),
    lambda k: rebind(*((one, other) if k % 2 else (other, one)), k),
    lambda k: use(one),
    lambda k: use(other),
    lambda k: reuse(one, other),
    read,
]
stop, failures, counts = time.monotonic() + 2.0, [], [0] * len(work)
threading.excepthook = lambda info: failures.append(repr(info.exc_value))
def run(index):
    while time.monotonic() < stop or counts[index] < 2:
        counts[index] += 1
        try:
            work[index](counts[index])
        except sn.InvalidConstraint:  # nothing is bound, or more than fits
            pass
threads = [threading.Thread(target=run, args=(index,)) for index in range(len(work))]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
print(failures or "took turns", counts)
"""

FACTOR = """
import threading, time
import numpy as np
import sinew_native as sn
from tests.bindings.meshes import grid

matrices = [sn.laplacian(sn.SurfaceMesh(*grid(n))) for n in (30, 40)]
for matrix in matrices:
    matrix.setdiag(matrix.diagonal() + 1.0)
factor, stop = sn.SpdFactor(matrices[0]), time.monotonic() + 2.0
def run(k):
    while time.monotonic() < stop:
        try:
            factor.factorize(matrices[k]) if k < 2 else factor.solve(np.ones((factor.size, 3)))
        except sn.InvalidConstraint:  # of the size of the other one
            pass
threads = [threading.Thread(target=run, args=(k,)) for k in range(4)]
[thread.start() for thread in threads]
[thread.join() for thread in threads]
print("took turns")
"""


@pytest.mark.slow
@pytest.mark.parametrize("method", [*SURFACE_METHODS, *SPACE_METHODS], ids=called)
def test_threads_that_share_an_object_take_turns(method: type) -> None:
    assert output_of(PROGRAM, method.__name__).startswith("took turns")


def test_threads_that_share_a_factor_take_turns() -> None:
    assert output_of(FACTOR).startswith("took turns")

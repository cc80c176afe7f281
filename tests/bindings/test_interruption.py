# SPDX-License-Identifier: GPL-3.0-or-later
"""Long calls let other threads run, tell how far they are, and can be stopped; threads share objects."""

import sys
import threading
import time
from collections.abc import Callable
from functools import partial

import numpy as np
import pytest

import sinew_native as sn

from . import limits
from .meshes import BENT, ends, grid
from .methods import SPACE_METHODS, SURFACE_METHODS, bound, called
from .programs import output_of


def longest_pause_of_another_thread(work: Callable[[], object]) -> tuple[float, float]:
    """The longest time a ticking thread stood still while `work` ran, and how long `work` took."""
    ticks: list[float] = []
    stop = threading.Event()

    def tick() -> None:
        while not stop.wait(0.001):
            ticks.append(time.perf_counter())

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.perf_counter()
    work()
    end = time.perf_counter()
    stop.set()
    thread.join()
    return max(np.diff([begin, *(t for t in ticks if begin < t < end), end])), end - begin


@pytest.mark.parametrize(("method", "solves"), [(sn.ThinShell, False), (sn.Arap, False), (sn.Arap, True)])
def test_other_python_threads_run_during_a_long_call(method: type, solves: bool) -> None:
    points, faces = grid(180)  # 33,000 vertices: binds of some tenths of a second
    surface = method(sn.SurfaceMesh(points, faces))
    work = partial(surface.set_handles, ends(points, 5))
    if solves:
        work()
        work = partial(surface.solve, BENT + 20 * np.eye(4)[3], max_iterations=20, tolerance=0)
    pause, took = longest_pause_of_another_thread(work)
    assert took > 0.05, "too quick to tell"
    assert pause < 0.5 * took  # holding the lock would make it the whole call


@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_the_number_of_threads_changes_no_bit(method: type) -> None:
    surface, _, _ = bound(method, n=60)
    expected, _ = surface.solve(BENT)
    for count in (1, 2):
        with limits.threads(count):
            np.testing.assert_array_equal(surface.solve(BENT)[0], expected)


@pytest.mark.parametrize("answer", [True, None, 1, np.True_])
def test_progress_that_does_not_say_no_goes_on(answer: object) -> None:
    surface, _, handles = bound(sn.ThinShell)
    told: list[tuple[float, str]] = []
    surface.set_handles(handles, progress=lambda share, stage: told.append((share, stage)) or answer)
    assert told[-1][0] == 1.0
    assert all(isinstance(stage, str) and stage for _, stage in told)


@pytest.mark.parametrize("answer", [False, 0, np.False_, LookupError])
def test_progress_that_says_no_or_fails_ends_the_call_and_nothing_is_lost(answer: object) -> None:
    surface, _, handles = bound(sn.ThinShell)
    before, _ = surface.solve(BENT)
    answers = iter([None, answer])

    def progress(_share: float, _stage: str) -> object:
        if (now := next(answers)) is LookupError:
            raise LookupError
        return now

    with pytest.raises(LookupError if answer is LookupError else sn.Cancelled):
        surface.set_handles(handles[:1], progress=progress)
    assert next(answers, "all are used") == "all are used"
    np.testing.assert_array_equal(surface.solve(BENT)[0], before)


def test_a_solve_can_be_cancelled_in_its_middle() -> None:
    arap, _, _ = bound(sn.Arap, tolerance=0)
    answers = iter([None, None, None, False])
    with pytest.raises(sn.Cancelled):
        arap.solve(BENT, progress=lambda *_: next(answers))


def test_a_callback_may_use_the_module() -> None:
    surface, points, handles = bound(sn.ThinShell)
    other, _, _ = bound(sn.Arap)
    shapes = []
    surface.set_handles(handles, progress=lambda *_: shapes.append(other.solve(BENT)[0].shape))
    assert set(shapes) == {points.shape}


INTERRUPTED = """
import signal, sys, threading
import sinew_native as sn
from tests.bindings.meshes import BENT, ends, grid

# A shell that runs tests in the background leaves its children deaf to Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)
points, faces = grid(int(sys.argv[2]))
surface, handles = getattr(sn, sys.argv[1])(sn.SurfaceMesh(points, faces)), ends(points, 3)
held = 2 if "solve" in sys.argv[3] else 1
surface.set_handles(handles[:held])
threading.Timer(0.03, signal.raise_signal, [signal.SIGINT]).start()
try:
    exec(compile(sys.argv[3], "", "exec"))  # a text in itself would end the process by the signal
except KeyboardInterrupt:
    assert len(surface.solve(BENT[:held], max_iterations=1)[0]) == len(points)
    print("interrupted, and usable")
"""
BIND = "surface.set_handles(handles)"
SOLVE = "while True: surface.solve(BENT, max_iterations=100000, tolerance=0)"


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot send itself Ctrl-C there")
@pytest.mark.parametrize(
    ("method", "size", "call"), [("ThinShell", 220, BIND), ("Arap", 220, BIND), ("Arap", 100, SOLVE)]
)
def test_ctrl_c_stops_a_long_call(method: str, size: int, call: str) -> None:
    assert output_of(INTERRUPTED, method, str(size), call) == "interrupted, and usable\n"


SHARED = """
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
    assert output_of(SHARED, method.__name__).startswith("took turns")


def test_threads_that_share_a_factor_take_turns() -> None:
    assert output_of(FACTOR).startswith("took turns")

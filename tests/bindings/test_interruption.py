# SPDX-License-Identifier: GPL-3.0-or-later
"""Long calls let other threads run, tell how far they are, and can be stopped; calls may overlap."""

import subprocess
import sys
import threading
import time
from collections.abc import Callable

import numpy as np
import pytest

import sinew_native as sn

from .meshes import BENT, ends, grid
from .methods import SURFACE_METHODS, bound


@pytest.fixture(scope="module")
def large() -> tuple[sn.SurfaceMesh, list[np.ndarray]]:
    points, faces = grid(180)  # 33,000 vertices: binds of some tenths of a second
    return sn.SurfaceMesh(points, faces), ends(points, 5)


def longest_pause_of_another_thread(work: Callable[[], object]) -> tuple[float, float]:
    """The longest time a ticking thread stood still while `work` ran, and how long `work` took."""
    ticks = [time.perf_counter()]
    stop = threading.Event()

    def tick() -> None:
        while not stop.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=tick)
    thread.start()
    begin = time.perf_counter()
    work()
    end = time.perf_counter()
    stop.set()
    thread.join()
    inside = [begin, *(t for t in ticks if begin < t < end), end]
    return max(np.diff(inside)), end - begin


def long_solve(mesh: sn.SurfaceMesh, handles: list[np.ndarray]) -> Callable[[], object]:
    arap = sn.Arap(mesh, max_iterations=20, tolerance=0)
    arap.set_handles(handles)
    poses = BENT.copy()
    poses[1, :, 3] += (20, 0, 30)
    return lambda: arap.solve(poses)


CALLS = {
    "bind of a thin shell": lambda mesh, handles: lambda: sn.ThinShell(mesh).set_handles(handles),
    "bind of arap": lambda mesh, handles: lambda: sn.Arap(mesh).set_handles(handles),
    "solve of arap": long_solve,
}


@pytest.mark.parametrize("name", CALLS)
def test_other_python_threads_run_during_a_long_call(name: str, large) -> None:
    pause, took = longest_pause_of_another_thread(CALLS[name](*large))
    assert took > 0.05, "too quick to tell"
    assert pause < 0.5 * took  # holding the lock would make it the whole call


@pytest.mark.parametrize("method", SURFACE_METHODS)
def test_the_number_of_threads_changes_no_bit(method: type) -> None:
    surface, _, _ = bound(method, n=60)
    found = []
    for threads in (1, 2, 0):
        sn.limit_threads(threads)
        found.append(surface.solve(BENT)[0])
    np.testing.assert_array_equal(found[1], found[0])
    np.testing.assert_array_equal(found[2], found[0])


class Stopper:
    """A progress callback that says no when called for the n-th time."""

    def __init__(self, stop: int, no: object) -> None:
        self.stop, self.no, self.calls = stop, no, 0

    def __call__(self, fraction: float, stage: str) -> object:
        self.calls += 1
        return self.no if self.calls >= self.stop else None


@pytest.mark.parametrize("answer", [True, None, 1, np.True_])
def test_progress_that_does_not_say_no_goes_on(answer: object) -> None:
    surface, _, handles = bound(sn.ThinShell)
    told: list[tuple[float, str]] = []
    surface.set_handles(handles, progress=lambda share, stage: told.append((share, stage)) or answer)
    assert told[-1][0] == 1.0
    assert all(isinstance(stage, str) and stage for _, stage in told)


@pytest.mark.parametrize("answer", [False, 0, np.False_])
def test_progress_that_says_no_cancels_and_nothing_is_lost(answer: object) -> None:
    surface, _, handles = bound(sn.ThinShell)
    before, _ = surface.solve(BENT)
    no = Stopper(2, answer)
    with pytest.raises(sn.Cancelled):
        surface.set_handles(handles[:1], progress=no)
    assert no.calls == 2
    np.testing.assert_array_equal(surface.solve(BENT)[0], before)


def test_a_solve_can_be_cancelled_in_its_middle() -> None:
    arap, _, _ = bound(sn.Arap, tolerance=0)
    before, _ = arap.solve(BENT)
    with pytest.raises(sn.Cancelled):
        arap.solve(BENT, progress=Stopper(4, False))
    np.testing.assert_array_equal(arap.solve(BENT)[0], before)


def test_an_error_of_the_callback_comes_through_as_it_is() -> None:
    surface, _, handles = bound(sn.ThinShell)
    before, _ = surface.solve(BENT)

    class OurError(Exception):
        pass

    def fail(fraction: float, stage: str) -> None:
        if fraction > 0:
            raise OurError(stage)

    with pytest.raises(OurError):
        surface.set_handles(handles[:1], progress=fail)
    np.testing.assert_array_equal(surface.solve(BENT)[0], before)


def test_a_callback_may_use_the_module() -> None:
    surface, points, handles = bound(sn.ThinShell)
    other, _, _ = bound(sn.Arap)
    shapes = []
    surface.set_handles(handles, progress=lambda *_: shapes.append(other.solve(BENT)[0].shape))
    assert set(shapes) == {points.shape}


PROGRAM = """
import signal, sys, threading, time
import numpy as np
import sinew_native as sn

# A shell that runs tests in the background leaves its children deaf to Ctrl-C.
signal.signal(signal.SIGINT, signal.default_int_handler)

def grid(n):
    y, x = np.mgrid[:n + 1, :n + 1].astype(float)
    points = np.stack([x, y, np.sin(0.1 * x)], -1).reshape(-1, 3)
    v = np.arange((n + 1) ** 2).reshape(n + 1, n + 1)
    a, b, c, d = (p.ravel() for p in (v[:-1, :-1], v[:-1, 1:], v[1:, 1:], v[1:, :-1]))
    return points, np.concatenate([np.stack([a, b, c], 1), np.stack([a, c, d], 1)])

points, faces = grid(SIZE)
surface = sn.CLASS(sn.SurfaceMesh(points, faces) OPTIONS)
x = points[:, 0]
handles = [np.flatnonzero(x < 3), np.flatnonzero(x > x.max() - 3)]
poses = np.zeros((2, 3, 4)); poses[:, :, :3] = np.eye(3); poses[1, 2, 3] = 0.3 * SIZE
SETUP
threading.Timer(DELAY, lambda: signal.raise_signal(signal.SIGINT)).start()
begin = time.perf_counter()
try:
    CALL
    print("finished after", time.perf_counter() - begin)
except KeyboardInterrupt:
    print("interrupted after", time.perf_counter() - begin)
CHECK
print("usable")
"""


BIND = "surface.set_handles(handles)"
SOLVE = "surface.solve(poses{which}, max_iterations=1)"
INTERRUPTIONS = {
    # class, size, options, before, during, handles of the solve afterwards
    "bind of a thin shell": (
        "ThinShell",
        220,
        ", affine_basis=False",
        "surface.set_handles(handles[:1])",
        BIND,
        "[:1]",
    ),
    "bind of arap": ("Arap", 220, "", "surface.set_handles(handles[:1])", BIND, "[:1]"),
    "solve of arap": (
        "Arap",
        100,
        ", max_iterations=100000, tolerance=0",
        BIND,
        "while True: surface.solve(poses)",
        "",
    ),
}


@pytest.mark.skipif(sys.platform == "win32", reason="a process cannot send itself Ctrl-C there")
@pytest.mark.parametrize("name", INTERRUPTIONS)
def test_ctrl_c_stops_a_long_call(name: str) -> None:
    method, size, options, setup, call, which = INTERRUPTIONS[name]
    parts = {
        "SIZE": str(size),
        "CLASS": method,
        "OPTIONS": options,
        "SETUP": setup,
        "CALL": call,
        "CHECK": f"assert len({SOLVE.format(which=which)}[0]) == len(points)",
        "DELAY": "0.03",
    }
    program = PROGRAM
    for mark, value in parts.items():
        program = program.replace(mark, value)
    command = [sys.executable, "-c", program]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.stdout.startswith("interrupted after"), done.stdout + done.stderr
    assert "usable" in done.stdout, done.stderr

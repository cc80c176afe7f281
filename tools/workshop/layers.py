# SPDX-License-Identifier: GPL-3.0-or-later
"""The layers of the tests. Each sets up what it needs, runs, and counts its tests.

``LAYERS`` are all of them; ``QUICK`` is what a plain ``tests/run`` takes of them.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from . import debian, environments, windows_tests
from .blenders import RUN_PYTEST, blender_module, conditions, install_legacy, layer_of
from .dev import BENCHMARK_TARGETS, build_tree
from .format import checks
from .neon_tests import neon
from .package import package
from .places import DEV_MODULE, NATIVE_TREE, PYTHON311
from .results import Outcome, outcome
from .shell import run
from .suites import OPTIONS, googletest, new_junit, only_some
from .tidy import tidy, uncommitted

PROGRAM = "tests/native/sinew_tests"  # in a tree of CMake
LEAKS_OF_OTHERS = Path(__file__).with_name("leaks-of-others.txt")
# What a method computes does not depend on Blender. So the oldest release runs all tests on all methods, and
# the newest one test_every_method.py. All other tables over methods run there on one method of each kind, and
# so do all tables in the releases between.
EVERY_METHOD = "--all-methods-in=test_every_method"
METHODS_OF_EACH_KIND = "--all-methods-in=none"
# Those between run the tests that use addon/compat, where releases differ (meshes, modifier inputs, stack,
# animation, shape keys, bones, drawing, layout, types of objects), the tests with files of other releases,
# and random sequences.
CORE_TESTS = (
    METHODS_OF_EACH_KIND,
    "test_bake.py",
    "test_browser.py",
    "test_cage_kinds.py",
    "test_chains.py",
    "test_event_files.py",
    "test_event_render.py",
    "test_event_stack.py",
    "test_every_method.py",
    "test_handles.py",
    "test_installation.py",
    "test_interface.py",
    "test_methods.py",
    "test_missing_libraries.py",
    "test_other_systems.py",
    "test_overlay.py",
    "test_panels.py",
    "test_random_operations.py",
)


@dataclass(frozen=True)
class Layer:
    name: str
    timeout: float  # seconds, for the tests without their set-up: three times what they take beside others
    run: Callable[[float], Outcome]
    one_process: bool = False  # its tests use one core, so that such a layer can run beside another
    waits: bool = False  # half of the time, for a window that draws, and leaves its core to another layer
    only_by_name: bool = False  # tests/run --all leaves it out
    whole: "Layer | None" = None  # what runs instead by --whole, where this is a core of all tests
    without: str = ""  # what this leaves out of the layer of the same name


def lint(timeout: float, quick: bool = False) -> Outcome:
    """Formats, types, clang-tidy on all sources or, if ``quick``, on those that are not committed yet."""
    total = Outcome()
    formats = checks()
    for name, command in (formats | {"mypy": [environments.dev().bin / "mypy"]}).items():
        note = f"{name}: try tools/format" if name in formats else name
        passed = run(command, timeout=timeout) == 0
        total += Outcome(passed=1) if passed else Outcome(failed=1, note=note)
    sources = uncommitted() if quick else None
    if sources == set():
        return total
    return total + (Outcome(passed=1) if tidy(sources) else Outcome(failed=1, note="clang-tidy"))


def architecture(timeout: float) -> Outcome:
    return _pytest("architecture", timeout)


def tools(timeout: float) -> Outcome:
    return _pytest("tools", timeout)


def native(timeout: float) -> Outcome:
    build_tree("dev")
    return googletest("native", [NATIVE_TREE / PROGRAM], timeout) + _other_native_tests(timeout)


def native_quick(timeout: float) -> Outcome:
    build_tree("dev", "sinew_native", "sinew_tests")
    return googletest("native", [NATIVE_TREE / PROGRAM], timeout)


def sanitizers(timeout: float) -> Outcome:
    build_tree("dev", "sinew_tests_sanitized")
    sanitizer_options = {
        "ASAN_OPTIONS": "detect_leaks=1:strict_init_order=1",
        "LSAN_OPTIONS": f"suppressions={LEAKS_OF_OTHERS}:print_suppressions=0",
        "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1",
    }
    return googletest("sanitizers", [NATIVE_TREE / f"{PROGRAM}_sanitized"], timeout, sanitizer_options)


def bindings(timeout: float) -> Outcome:
    build_tree("dev", "sinew_native")
    return _pytest("bindings", timeout, {"PYTHONPATH": DEV_MODULE})


def bindings_quick(timeout: float) -> Outcome:
    build_tree("dev", "sinew_native")
    return _pytest("bindings", timeout, {"PYTHONPATH": DEV_MODULE}, "-m", "not slow")


def addon(timeout: float) -> Outcome:
    debian.install(debian.QEMU)
    build_tree("dev", "sinew_native")
    return _pytest("addon", timeout, {"PYTHONPATH": DEV_MODULE})


def addon_quick(timeout: float) -> Outcome:
    build_tree("dev", "sinew_native")
    chosen = ("-m", "not slow", "--ignore=tests/addon/install/test_old_processors.py")
    return _pytest("addon", timeout, {"PYTHONPATH": DEV_MODULE}, *chosen)


def benchmarks(timeout: float) -> Outcome:
    debian.install(debian.BLENDER)
    build_tree("dev", *BENCHMARK_TARGETS)
    package()  # done first, so that no row has to wait for it
    environments.newest_blender().make()
    return _pytest("benchmarks", timeout, {"PYTHONPATH": DEV_MODULE})


def blender_3_4(timeout: float, from_wheel: bool = True, tests: tuple[str, ...] = ()) -> Outcome:
    """Runs ``tests``, which may be options of pytest, or all."""
    debian.install(debian.BLENDER_TESTS)
    env = install_legacy("blender-3.4", from_wheel)
    junit = new_junit("blender-3.4")
    headless = ["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python"]
    status = run(
        [*headless, RUN_PYTEST, "--", *tests, *OPTIONS, f"--junitxml={junit}"],
        env=env | conditions("blender-3.4"),
        timeout=timeout,
    )
    return outcome(junit, status)


def blender_layer(version: str, tests: tuple[str, ...] = ()) -> Layer:
    """A layer for a release of Blender, which runs ``tests``, or all."""
    name = layer_of(version)
    run_tests = partial(blender_module, name, environments.blender(version), tests)
    return Layer(name, 1200 if tests else 3000, run_tests, one_process=True)


def blender_5(timeout: float) -> Outcome:
    newest = environments.newest_blender()
    found = blender_module("blender-5", newest, (EVERY_METHOD,), timeout)
    if newest.name != "bpy-5.2.3":
        found += Outcome(note="Blender 5.0.1 ran instead of 5.2, which needs a Python 3.13")
    return found


def gui(timeout: float, from_wheel: bool = True, tests: tuple[str, ...] = ()) -> Outcome:
    debian.install(debian.GUI)
    env = install_legacy("gui", from_wheel)
    junit = new_junit("gui")
    screen = ["xvfb-run", "--auto-servernum", "--server-args=-ac -screen 0 1280x800x24"]
    command = [*screen, PYTHON311, "-m", "pytest", "tests/gui", *tests, *OPTIONS, f"--junitxml={junit}"]
    return outcome(junit, run(command, env=env, timeout=timeout))


def _pytest(name: str, timeout: float, env: Mapping[str, str | Path] | None = None, *options: str) -> Outcome:
    junit = new_junit(name)
    command = [
        environments.dev().make().python,
        "-m",
        "pytest",
        f"tests/{name}",
        *options,
        *OPTIONS,
        f"--junitxml={junit}",
    ]
    return outcome(junit, run(command, env=env, timeout=timeout))


def _other_native_tests(timeout: float) -> Outcome:
    """What ctest knows beside GoogleTest's own: the count of instructions, where there is Valgrind."""
    if only_some():
        return Outcome()
    junit = new_junit("native")
    command = ["ctest", "--output-on-failure", "--output-junit", junit, "--no-tests=ignore"]
    status = run([*command, "--label-exclude", "googletest"], cwd=NATIVE_TREE, timeout=timeout)
    none = junit.is_file() and "<testcase" not in junit.read_text(encoding="utf-8")
    return Outcome() if none else outcome(junit, status)


def windows_layer(name: str, tests: Callable[[bool, float], Outcome]) -> Layer:
    """A layer of a core of these tests; by --whole, of all of them."""
    whole = Layer(f"windows-{name}", 5400, partial(tests, True), one_process=True, only_by_name=True)
    core = partial(tests, False)
    return Layer(f"windows-{name}", 600, core, one_process=True, only_by_name=True, whole=whole)


LAYERS = (
    Layer("lint", 420, lint),
    Layer("native", 300, native),
    Layer("sanitizers", 1200, sanitizers),
    Layer("windows-native", 420, windows_tests.native, only_by_name=True),
    Layer("architecture", 60, architecture, one_process=True),
    Layer("tools", 60, tools, one_process=True),
    Layer("benchmarks", 600, benchmarks, one_process=True),
    Layer("addon", 600, addon, one_process=True),
    Layer("bindings", 1200, bindings, one_process=True),
    Layer("blender-3.4", 3000, blender_3_4, one_process=True),
    *(blender_layer(version, CORE_TESTS) for version in environments.LONG_TERM_BLENDERS),
    Layer("blender-5", 3000, blender_5, one_process=True),
    Layer("gui", 1200, gui, one_process=True, waits=True),
    windows_layer("bindings", windows_tests.bindings),
    windows_layer("blender", windows_tests.blender),
    windows_layer("bindings-3.13", windows_tests.bindings_313),
    Layer("windows-processors", 420, windows_tests.old_processors, one_process=True, only_by_name=True),
    Layer("windows-blender-5", 900, windows_tests.blender_5, one_process=True, only_by_name=True),
    Layer("neon", 600, neon, only_by_name=True),
)

# What of the tests in Blender a plain tests/run takes: every method, and the table of events on the two rigs
# that have regions and faces.
QUICK_BLENDER = (
    "test_every_method.py",
    "test_event_data.py",
    "test_event_files.py",
    "test_event_history.py",
    "test_event_modes.py",
    "test_event_scene.py",
    "test_event_stack.py",
    "-k",
    "test_every_method or [handles or -handles or [cage or -cage",
)
QUICK_SESSION = "[start- or [start]"  # of those in windows
QUICK = (
    Layer("native", 300, native_quick, without="the count of instructions"),
    Layer(
        "lint", 240, partial(lint, quick=True), one_process=True, without="clang-tidy on committed sources"
    ),
    Layer("architecture", 60, architecture, one_process=True),
    Layer("tools", 60, tools, one_process=True),
    Layer(
        "addon",
        120,
        addon_quick,
        one_process=True,
        without="emulated processors and the comparison of methods",
    ),
    Layer("bindings", 300, bindings_quick, one_process=True, without="those marked slow"),
    Layer(
        "blender-3.4",
        420,
        partial(blender_3_4, from_wheel=False, tests=QUICK_BLENDER),
        one_process=True,
        without="all but every method, and the events on regions and cages",
    ),
    Layer(
        "gui",
        240,
        partial(gui, from_wheel=False, tests=("-k", QUICK_SESSION)),
        one_process=True,
        waits=True,
        without="all but one session",
    ),
)

# SPDX-License-Identifier: GPL-3.0-or-later
"""The layers of the tests. Each sets up what it needs, runs, and counts its tests.

``LAYERS`` are all of them; ``QUICK`` is what a plain ``tests/run`` takes of them.
"""

import tarfile
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from . import blenders, cross_wheels, debian, environments, linux_wheels, windows_tests, wine
from .archives import unpack
from .blenders import HEADLESS, RUN_PYTEST, blender_module, conditions, install_legacy, layer_of
from .dev import BENCHMARK_TARGETS, build_tree
from .format import checks
from .neon_tests import neon
from .package import package
from .places import BUILD, DEV_MODULE, NATIVE_TREE, PACKAGES, PYTHON311, ROOT
from .release import source_archive
from .results import Outcome, outcome
from .shell import must, run
from .suites import OPTIONS, emptied, files, googletest, new_junit, only_some
from .tidy import tidy, uncommitted

PROGRAM = "tests/native/sinew_tests"  # in a tree of CMake
WORKFLOWS = ROOT / ".github" / "workflows"
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
    *files("bake browser cage_kinds chains event_files event_render event_stack every_method handles"),
    *files("installation interface methods missing_libraries other_systems overlay panels random_operations"),
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
    further = {"mypy": ["mypy"], "actionlint": ["actionlint", *sorted(WORKFLOWS.glob("*.yml"))]}
    others = {name: [environments.dev().bin / words[0], *words[1:]] for name, words in further.items()}
    for name, command in (formats | others).items():
        note = f"{name}: try tools/format" if name in formats else name
        passed = run(command, timeout=timeout) == 0
        total += Outcome(passed=1) if passed else Outcome(failed=1, note=note)
    sources = uncommitted() if quick else None
    if sources == set():
        return total
    return total + (Outcome(passed=1) if tidy(sources) else Outcome(failed=1, note="clang-tidy"))


def native(timeout: float, quick: bool = False) -> Outcome:
    build_tree("dev", *(("sinew_native", "sinew_tests") if quick else ()))
    found = googletest("native", [NATIVE_TREE / PROGRAM], timeout)
    return found if quick else found + _other_native_tests(timeout)


def sanitizers(timeout: float) -> Outcome:
    build_tree("dev", "sinew_tests_sanitized")
    sanitizer_options = {
        "ASAN_OPTIONS": "detect_leaks=1:strict_init_order=1",
        "LSAN_OPTIONS": f"suppressions={LEAKS_OF_OTHERS}:print_suppressions=0",
        "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1",
    }
    return googletest("sanitizers", [NATIVE_TREE / f"{PROGRAM}_sanitized"], timeout, sanitizer_options)


def in_python(timeout: float, name: str, *options: str, qemu: bool = False) -> Outcome:
    """The tests in a folder that import the Python module."""
    if qemu:
        debian.install(debian.QEMU)
    build_tree("dev", "sinew_native")
    return _pytest(timeout, name, *options, env={"PYTHONPATH": DEV_MODULE})


def source(timeout: float) -> Outcome:
    """A core of the tests of the bindings, on what pip builds from the source archive in an empty folder."""
    build_tree("dev", "sinew_native")
    folder = emptied(BUILD / "source")
    with tarfile.open(source_archive(folder)) as archive:
        archive.extractall(folder)
    unpacked, installed = next(folder.glob("sinew_native-*/")), folder / "installed"
    pip = [environments.build().make().python, "-m", "pip", "install", "--quiet", "--no-deps", "--target"]
    compiler = {  # named as in the developer's tree, so that ccache knows what it has compiled there
        "CC": "gcc",
        "CXX": "g++",
        "CMAKE_CXX_COMPILER_LAUNCHER": "ccache",
        "CCACHE_BASEDIR": unpacked,
        "CCACHE_NOHASHDIR": "1",
        "CCACHE_SLOPPINESS": "pch_defines,time_macros",
    }
    must([*pip, installed, "--no-build-isolation", unpacked], cwd=folder, env=compiler, quiet=True)
    return _core_of_bindings("source", timeout, {"PYTHONPATH": installed})


def shipped(timeout: float) -> Outcome:
    """The same core on the module of the zips, which has to give the answers of the developer's."""
    wheel = cross_wheels.build_wheel(linux_wheels.TARGET, environments.build_for(11).make(), 11)
    answers = windows_tests.answers_of_this_machine("shipped")
    module = unpack(wheel, emptied(BUILD / "shipped"))
    return _core_of_bindings("shipped", timeout, {"PYTHONPATH": module, "SINEW_ANSWERS": answers})


def _core_of_bindings(name: str, timeout: float, env: Mapping[str, str | Path]) -> Outcome:
    junit = new_junit(name)
    tests = [next(windows_tests.BINDINGS.rglob(file)) for file in windows_tests.CORE_BINDINGS]
    command = [environments.dev().make().python, "-m", "pytest", *tests, *OPTIONS, f"--junitxml={junit}"]
    return outcome(junit, run(command, env=env, timeout=timeout))


def benchmarks(timeout: float) -> Outcome:
    debian.install(debian.BLENDER)
    build_tree("dev", *BENCHMARK_TARGETS)
    package()  # done first, so that no row has to wait for it
    environments.newest_blender().make()
    return _pytest(timeout, "benchmarks", env={"PYTHONPATH": DEV_MODULE})


def farm(timeout: float) -> Outcome:
    """Bakes of the installed extension in many processes, some of which are killed; sweeps of the module."""
    debian.install(debian.NODE, debian.QEMU, debian.SSH)
    build_tree("dev", "sinew_native")
    blender, junit = environments.newest_blender().make(), new_junit("farm")
    env = blenders.install_extension(blender, "farm")
    command = Path(env["BLENDER_USER_RESOURCES"]) / "extensions/user_default/sinew/farm/command.py"
    env |= {"SINEW_ATOM": f"{blender.python} {command}", "PYTHONPATH": f"{PACKAGES}:{DEV_MODULE}"}
    tests = [environments.farm().make().python, "-m", "pytest", "tests/farm", *OPTIONS, f"--junitxml={junit}"]
    return outcome(junit, run(tests, env=env, timeout=timeout))


def updates(timeout: float, system: str = "linux") -> Outcome:
    """Blenders of a system that install and update the extension from a host on this machine."""
    environments.newest_blender().make()  # validates and lists the extensions
    package(system)
    if system == "linux":
        for version in environments.LONG_TERM_BLENDERS:
            environments.blender(version).make()
    else:
        wine.set_up()
    return _pytest(timeout, "updates", env={"SINEW_SYSTEM": system})


def blender_3_4(timeout: float, from_wheel: bool = True, tests: tuple[str, ...] = ()) -> Outcome:
    """Runs ``tests``, which may be options of pytest, or all."""
    debian.install(debian.BLENDER_TESTS)
    env = install_legacy("blender-3.4", from_wheel)
    junit = new_junit("blender-3.4")
    command = [*HEADLESS, RUN_PYTEST, "--", *tests, *OPTIONS, f"--junitxml={junit}"]
    return outcome(junit, run(command, env=env | conditions("blender-3.4"), timeout=timeout))


def blender_layer(version: str, tests: tuple[str, ...] = ()) -> Layer:
    """A layer for a release of Blender, which runs ``tests``, or all."""
    name = layer_of(version)
    run_tests = partial(blender_module, name, environments.blender(version), tests)
    return Alone(name, 1200 if tests else 3000, run_tests)


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


def _pytest(timeout: float, name: str, *options: str, env: Mapping[str, str | Path] | None = None) -> Outcome:
    junit = new_junit(name)
    command = [environments.dev().make().python, "-m", "pytest", f"tests/{name}", *options, *OPTIONS]
    return outcome(junit, run([*command, f"--junitxml={junit}"], env=env, timeout=timeout))


def _other_native_tests(timeout: float) -> Outcome:
    """What ctest knows beside GoogleTest's own: the count of instructions, where there is Valgrind."""
    if only_some():
        return Outcome()
    junit = new_junit("native")
    command = ["ctest", "--output-on-failure", "--output-junit", junit, "--no-tests=ignore"]
    status = run([*command, "--label-exclude", "googletest"], cwd=NATIVE_TREE, timeout=timeout)
    none = junit.is_file() and "<testcase" not in junit.read_text(encoding="utf-8")
    return Outcome() if none else outcome(junit, status)


def _of(
    function: Callable[..., Outcome], *arguments: object, **options: object
) -> Callable[[float], Outcome]:
    """The function of a timeout that also gets these arguments."""
    return lambda timeout: function(timeout, *arguments, **options)


def windows_layer(name: str, tests: Callable[[bool, float], Outcome]) -> Layer:
    """A layer of a core of these tests; by --whole, of all of them."""
    whole = Alone(f"windows-{name}", 5400, partial(tests, True), only_by_name=True)
    return Alone(f"windows-{name}", 600, partial(tests, False), only_by_name=True, whole=whole)


Alone = partial(Layer, one_process=True)
LAYERS = (
    Layer("lint", 420, lint),
    Layer("native", 300, native),
    Layer("sanitizers", 1200, sanitizers, only_by_name=True),
    Layer("windows-native", 420, windows_tests.native, only_by_name=True),
    Alone("architecture", 60, _of(_pytest, "architecture")),
    Alone("tools", 480, _of(in_python, "tools")),
    Alone("benchmarks", 600, benchmarks),
    Alone("addon", 600, _of(in_python, "addon", qemu=True)),
    Alone("bindings", 1200, _of(in_python, "bindings")),
    Alone("source", 300, source),
    Alone("shipped", 300, shipped),
    Alone("blender-3.4", 3000, blender_3_4),
    *(blender_layer(version, CORE_TESTS) for version in environments.LONG_TERM_BLENDERS),
    Alone("blender-5", 3000, blender_5),
    Alone("farm", 900, farm),
    Alone("updates", 300, updates),
    Alone("gui", 1200, gui, waits=True),
    windows_layer("bindings", windows_tests.bindings),
    windows_layer("blender", windows_tests.blender),
    windows_layer("bindings-3.13", windows_tests.bindings_313),
    Alone("windows-processors", 420, windows_tests.old_processors, only_by_name=True),
    Alone("windows-blender-5", 900, windows_tests.blender_5, only_by_name=True),
    Alone("windows-updates", 900, _of(updates, "windows"), only_by_name=True),
    Layer("neon", 600, neon, only_by_name=True),
)

# What of the tests in Blender a plain tests/run takes: every method, and the table of events on the two rigs
# that have regions and faces.
QUICK_BLENDER = (
    *files("every_method event_data event_files event_history event_modes event_scene event_stack"),
    "-k",
    "test_every_method or [handles or -handles or [cage or -cage",
)
SOME_ADDON = ("-m", "not slow", "--ignore=tests/addon/install/test_old_processors.py")
QUICK_SESSION = ("-k", "[start- or [start]")  # of those in windows
LEFT_IN_BLENDER = "all but every method, and the events on regions and cages"
QUICK = (
    Layer("native", 300, partial(native, quick=True), without="the count of instructions"),
    Alone("lint", 240, partial(lint, quick=True), without="clang-tidy on committed sources"),
    Alone("architecture", 60, _of(_pytest, "architecture")),
    Alone("tools", 120, _of(in_python, "tools", "-m", "not slow"), without="the site"),
    Alone(
        "addon", 120, _of(in_python, "addon", *SOME_ADDON), without="emulators and the comparison of methods"
    ),
    Alone("bindings", 300, _of(in_python, "bindings", "-m", "not slow"), without="those marked slow"),
    Alone("blender-3.4", 420, _of(blender_3_4, False, QUICK_BLENDER), without=LEFT_IN_BLENDER),
    Alone("gui", 240, _of(gui, False, QUICK_SESSION), waits=True, without="all but one session"),
)

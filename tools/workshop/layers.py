# SPDX-License-Identifier: GPL-3.0-or-later
"""The layers of the tests, from fast to slow. Each sets up what it needs, runs, and counts its tests."""

import os
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

from . import debian, environments
from .dev import BENCHMARK_TARGETS, build_tree
from .environments import Environment
from .format import checks
from .neon_tests import neon
from .package import package, validate
from .places import BUILD, DEV_MODULE, NATIVE_TREE, PYTHON311, ROOT, SANITIZE_TREE
from .results import Outcome, outcome
from .shell import must, one_at_a_time, run
from .suites import OPTIONS, RESULTS, emptied, googletest, new_junit
from .tidy import tidy
from .windows_tests import windows

PROGRAM = "tests/native/sinew_tests"  # in a tree of CMake
TESTS = ROOT / "tests"
INSIDE = Path(__file__).parent / "inside"
LEAKS_OF_OTHERS = Path(__file__).with_name("leaks-of-others.txt")
RANDOM_SEQUENCES = 50  # in each of four releases: 200 per run
# The oldest and the newest release run all tests. Those between run the tests that use addon/compat, where
# releases differ (meshes, modifier inputs, stack, animation, shape keys, bones, drawing, layout, types of
# objects), the tests with files of other releases, and random sequences.
CORE_TESTS = (
    "test_bake.py",
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
    "test_overlay.py",
    "test_random_operations.py",
)


@dataclass(frozen=True)
class Layer:
    name: str
    timeout: float  # seconds, for the tests without their set-up
    run: Callable[[float], Outcome]
    one_process: bool = False  # its tests use one core, so that such a layer can run beside another
    only_by_name: bool = False  # a plain tests/run leaves it out


def lint(timeout: float) -> Outcome:
    total = Outcome()
    formats = checks()
    for name, command in (formats | {"mypy": [environments.dev().bin / "mypy"]}).items():
        note = f"{name}: try tools/format" if name in formats else name
        passed = run(command, timeout=timeout) == 0
        total += Outcome(passed=1) if passed else Outcome(failed=1, note=note)
    return total + (Outcome(passed=1) if tidy() else Outcome(failed=1, note="clang-tidy"))


def architecture(timeout: float) -> Outcome:
    return _pytest("architecture", timeout)


def tools(timeout: float) -> Outcome:
    return _pytest("tools", timeout)


def native(timeout: float) -> Outcome:
    build_tree("dev")
    return googletest("native", [NATIVE_TREE / PROGRAM], timeout) + _other_native_tests(timeout)


def sanitizers(timeout: float) -> Outcome:
    build_tree("sanitize")
    sanitizer_options = {
        "ASAN_OPTIONS": "detect_leaks=1:strict_init_order=1",
        "LSAN_OPTIONS": f"suppressions={LEAKS_OF_OTHERS}:print_suppressions=0",
        "UBSAN_OPTIONS": "print_stacktrace=1:halt_on_error=1",
    }
    return googletest("sanitizers", [SANITIZE_TREE / PROGRAM], timeout, sanitizer_options)


def bindings(timeout: float) -> Outcome:
    build_tree("dev", "sinew_native")
    return _pytest("bindings", timeout, {"PYTHONPATH": DEV_MODULE})


def addon(timeout: float) -> Outcome:
    build_tree("dev", "sinew_native")
    return _pytest("addon", timeout, {"PYTHONPATH": DEV_MODULE})


def benchmarks(timeout: float) -> Outcome:
    debian.install(debian.BLENDER)
    for target in BENCHMARK_TARGETS:
        build_tree("dev", target)
    package()  # done first, so that no row has to wait for it
    environments.newest_blender().make()
    return _pytest("benchmarks", timeout, {"PYTHONPATH": DEV_MODULE})


def blender_3_4(timeout: float) -> Outcome:
    debian.install(debian.BLENDER_TESTS)
    env = install_legacy("blender-3.4")
    junit = new_junit("blender-3.4")
    script = TESTS / "blender" / "run_pytest.py"
    headless = ["blender", "--background", "--factory-startup", "--python-exit-code", "1", "--python", script]
    status = run(
        [*headless, "--", *OPTIONS, f"--junitxml={junit}"],
        env=env | _conditions("blender-3.4"),
        timeout=timeout,
    )
    return outcome(junit, status)


def blender_module(name: str, blender: Environment, tests: tuple[str, ...], timeout: float) -> Outcome:
    """Runs ``tests``, or all, on the installed extension in a Blender that is a Python module."""
    env = install_extension(blender.make(), name)
    junit = new_junit(name)
    script = TESTS / "blender" / "run_pytest.py"
    command = [blender.python, script, "--", *tests, *OPTIONS, f"--junitxml={junit}"]
    return outcome(junit, run(command, env=env | _conditions(name), timeout=timeout))


def _conditions(name: str) -> dict[str, str]:
    """Lets freed memory be overwritten, so that dangling pointers are found, and gives each layer its own
    seed.
    """
    seed = str(zlib.crc32(name.encode()))
    wanted = {
        "MALLOC_PERTURB_": "165",
        "SINEW_RANDOM_SEQUENCES": str(RANDOM_SEQUENCES),
        "SINEW_RANDOM_SEED": seed,
    }
    return {key: os.environ.get(key, value) for key, value in wanted.items()}


def blender_layer(version: str, tests: tuple[str, ...] = ()) -> Layer:
    """A layer for a release of Blender, named after its series. It runs ``tests``, or all."""
    name = f"blender-{version.rpartition('.')[0]}"
    return Layer(name, 900, partial(blender_module, name, environments.blender(version), tests), True)


def blender_5(timeout: float) -> Outcome:
    newest = environments.newest_blender()
    found = blender_module("blender-5", newest, (), timeout)
    if newest.name != "bpy-5.2.3":
        found += Outcome(note="Blender 5.0.1 ran instead of 5.2, which needs a Python 3.13")
    return found


def gui(timeout: float) -> Outcome:
    debian.install(debian.GUI)
    env = install_legacy("gui")
    junit = new_junit("gui")
    screen = ["xvfb-run", "--auto-servernum", "--server-args=-ac -screen 0 1280x800x24"]
    command = [*screen, PYTHON311, "-m", "pytest", "tests/gui", *OPTIONS, f"--junitxml={junit}"]
    return outcome(junit, run(command, env=env, timeout=timeout))


@one_at_a_time()
def install_legacy(name: str) -> dict[str, str | Path]:
    """Installs the legacy zip in Debian's Blender, in a new user folder.

    Returns the environment variables.
    """
    _, zip_file = package()
    user = emptied(BUILD / "blender-users" / name)
    env = {
        "BLENDER_USER_CONFIG": user / "config",
        "BLENDER_USER_SCRIPTS": user / "scripts",
        "SINEW_ADDON_MODULE": "sinew",
        "SINEW_TEST_OUTPUT": emptied(RESULTS / name),
    }
    headless = ["blender", "--background", "--factory-startup", "--python-exit-code", "1"]
    must([*headless, "--python", INSIDE / "install_zip.py", "--", zip_file], env=env, timeout=120, quiet=True)
    return env


@one_at_a_time()
def install_extension(blender: Environment, name: str) -> dict[str, str | Path]:
    """Installs the extension in a Blender that is a Python module, in the same way."""
    zip_file, _ = package()
    validate(zip_file, blender)
    env = {
        "BLENDER_USER_RESOURCES": emptied(BUILD / "blender-users" / name),
        "SINEW_ADDON_MODULE": "bl_ext.user_default.sinew",
        "SINEW_TEST_OUTPUT": emptied(RESULTS / name),
    }
    command = [blender.python, INSIDE / "install_zip.py", "--", zip_file]
    must(command, env=env, timeout=120, quiet=True)
    return env


def _pytest(name: str, timeout: float, env: Mapping[str, str | Path] | None = None) -> Outcome:
    junit = new_junit(name)
    command = [
        environments.dev().make().python,
        "-m",
        "pytest",
        f"tests/{name}",
        *OPTIONS,
        f"--junitxml={junit}",
    ]
    return outcome(junit, run(command, env=env, timeout=timeout))


def _other_native_tests(timeout: float) -> Outcome:
    """What ctest knows beside GoogleTest's own: the count of instructions, where there is Valgrind."""
    junit = new_junit("native")
    command = ["ctest", "--output-on-failure", "--output-junit", junit, "--no-tests=ignore"]
    status = run([*command, "--label-exclude", "googletest"], cwd=NATIVE_TREE, timeout=timeout)
    none = junit.is_file() and "<testcase" not in junit.read_text(encoding="utf-8")
    return Outcome() if none else outcome(junit, status)


LAYERS = (
    Layer("lint", 420, lint),
    Layer("architecture", 120, architecture),
    Layer("tools", 120, tools),
    Layer("native", 300, native),
    Layer("sanitizers", 1500, sanitizers),
    Layer("benchmarks", 600, benchmarks),
    Layer("addon", 120, addon, one_process=True),
    Layer("bindings", 420, bindings, one_process=True),
    Layer("blender-3.4", 1000, blender_3_4, one_process=True),
    *(blender_layer(version, CORE_TESTS) for version in environments.LONG_TERM_BLENDERS),
    Layer("blender-5", 1000, blender_5, one_process=True),
    Layer("gui", 1200, gui, one_process=True),
    Layer("neon", 600, neon, only_by_name=True),
    Layer("windows", 900, windows, only_by_name=True),
)

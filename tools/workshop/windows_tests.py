# SPDX-License-Identifier: GPL-3.0-or-later
"""The tests that run in Windows' programs under Wine: GoogleTest's, those of the bindings, those in Blender.

Wine is not Windows: what it does not show stands in docs/developer/decisions/windows-by-zig.md.
"""

import os
import re
import shlex
import shutil
import subprocess
from pathlib import Path

from . import cross_wheels, environments, wine
from .archives import write_zip
from .blenders import INSIDE, RUN_PYTEST, blender_module, conditions
from .cross_libraries import build, libraries
from .cross_wheels import configure
from .debian import GOOGLETEST, QEMU, install
from .dev import build_tree
from .package import extension_files, package
from .places import BUILD, DEV_MODULE, ROOT, version
from .results import Outcome, outcome
from .shell import environment, jobs, must, one_at_a_time, run
from .site import manual_files
from .suites import OPTIONS, RESULTS, emptied, files, googletest, new_junit
from .windows_libraries import WINDOWS
from .windows_wheels import TARGET

BINDINGS = ROOT / "tests" / "bindings"
OLD_PROCESSORS = ROOT / "tests" / "addon" / "install" / "test_old_processors.py"
LOADER = Path("/usr/lib/wine/wine64")  # the program itself; "wine" is a script around it
# Of SciPy's packages, scipy.sparse alone works without scipy.linalg.
LINALG = re.compile(r"\bscipy\.(?!sparse\b)\w|\bscipy\.sparse\.linalg\b")
OWN_MODULES = re.compile(r"^from \.*(?:\w+\.)*(\w+) import", flags=re.MULTILINE)
# Python 3.11 runs all tests of the bindings; 3.13 these, which call every method and convert every argument.
CORE_BINDINGS = files("arguments contract errors out same_answers")
# Every method's bind, pose, frame, undo, save and load; cages; bakes and their paths; modules that do not
# load, broken installations and known answers; files of earlier versions and of other systems.
CORE_TESTS = (
    "--all-methods-in=test_other_systems",  # of other tables over methods, one of each kind of control
    *files("bake bake_files cage event_files event_history every_method foreign_modules handles"),
    *files("installation old_files other_systems paths"),
)
NO_PYTHON = Outcome(skipped=1, note="no Python 3.13 here, so there is no wheel for it")
VERSION = "4.5.15"
NEWEST = "5.2.3"
OF_ANOTHER_SYSTEM = "SINEW_FILES_OF_ANOTHER_SYSTEM"
USER = "Jürgen Müller 日本語"  # a folder of a user, as Windows names it after him


def native(timeout: float) -> Outcome:
    wine.set_up()
    return googletest("windows-native", ["wine", test_program()], timeout, wine.SETTINGS, drive="Z:")


@one_at_a_time()
def test_program() -> Path:
    install(GOOGLETEST)
    libraries(WINDOWS)
    if not (WINDOWS.prefix / "lib" / "libgtest.a").is_file():
        build(WINDOWS, "googletest", Path("/usr/src/googletest"), "-DBUILD_GMOCK=OFF")
    # The tree of the wheel serves, so that the library is compiled once. CMake must not run the program.
    settings = ("-DSINEW_BUILD_TESTS=ON", "-DCMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE=PRE_TEST")
    tree = configure(TARGET, environments.build().make(), 11, *settings)
    must(["cmake", "--build", tree, "--target", "sinew_tests", "-j", str(jobs())], quiet=True)
    return tree / "tests" / "native" / "sinew_tests.exe"


def bindings(whole: bool, timeout: float) -> Outcome:
    """A core of the bindings' tests, or all, in the Python of Blender 4.2 to 5.0."""
    return bindings_in(11, () if whole else CORE_BINDINGS, timeout)


def bindings_313(whole: bool, timeout: float) -> Outcome:
    """The same in the Python of Blender 5.1 and later."""
    if not environments.python313():
        return NO_PYTHON
    return bindings_in(13, () if whole else CORE_BINDINGS, timeout)


def old_processors(timeout: float) -> Outcome:
    """Known answers and messages of the wheel on emulated processors without AVX2, and without SSE4.2."""
    install(QEMU)
    wine.set_up()
    build_wheel(11)
    junit = new_junit("windows-processors")
    env = wine.SETTINGS | {
        "WINELOADERNOEXEC": "1",  # else Wine starts itself again, outside of the emulator
        "SINEW_EMULATED_PYTHON": shlex.join([str(LOADER), str(wine.python(11))]),
        "SINEW_EMULATED_MODULE": unpacked_wheel(11),
    }
    command = [environments.dev().make().python, "-m", "pytest", OLD_PROCESSORS, *OPTIONS]
    return outcome(junit, run([*command, f"--junitxml={junit}"], env=env, timeout=timeout))


def unpacked_wheel(minor: int) -> Path:
    return WINDOWS.tree / "wheel-check" / f"cp3{minor}"


def build_wheel(minor: int) -> Path:
    """The wheel for one Python alone. That of the other takes minutes more to compile."""
    builder = environments.build_for(minor)
    return cross_wheels.build_wheel(TARGET, builder.make(), minor)


def bindings_in(minor: int, names: tuple[str, ...], timeout: float) -> Outcome:
    """These files of the bindings' tests, or all, on the unpacked wheel. One of them compares the answers of
    all methods with those of this machine."""
    build_wheel(minor)
    here = answers_of_this_machine(f"windows-3.{minor}")
    python = wine.python(minor)
    every = [file for file in sorted(BINDINGS.rglob("test_*.py")) if not names or file.name in names]
    left_out = [file for file in every if minor == 13 and calls_linalg(file)]
    junit = new_junit(f"windows-bindings-3.{minor}")
    tested = [file for file in every if file not in left_out]
    command = [python, "-m", "pytest", *tested, *OPTIONS, f"--junitxml=Z:{junit}"]
    env = {"PYTHONPATH": f"Z:{unpacked_wheel(minor)}", "SINEW_ANSWERS": f"Z:{here}"}
    found = outcome(junit, wine.run_in_windows(command, env=env, timeout=timeout))
    if left_out:
        count = len(left_out)
        note = f"{count} files left out in Python 3.13: Wine 8 lacks crealf, which SciPy's linalg calls"
        found += Outcome(skipped=count, note=note)
    return found


def calls_linalg(file: Path, seen: frozenset[Path] = frozenset()) -> bool:
    """Whether a file of the bindings' tests imports SciPy's ``linalg``, by itself or by a module of ours."""
    text = file.read_text(encoding="utf-8")
    names = OWN_MODULES.findall(text)
    modules = {path for name in names for path in BINDINGS.rglob(f"{name}.py")}
    modules |= {path for name in names if (path := ROOT / "benchmarks" / f"{name}.py").is_file()}
    seen |= {file}
    return bool(LINALG.search(text)) or any(calls_linalg(module, seen) for module in modules - seen)


def answers_of_this_machine(reader: str) -> Path:
    """They have a file for each of the layers that read them, as these run beside each other."""
    build_tree("dev", "sinew_native")
    RESULTS.mkdir(parents=True, exist_ok=True)
    file = RESULTS / f"answers-{reader}.npz"
    python = environments.dev().make().python
    paths = f"{DEV_MODULE}{os.pathsep}{ROOT}"
    must([python, "-m", "tests.bindings.oracles.answers", file], env={"PYTHONPATH": paths}, quiet=True)
    return file


def blender(whole: bool, timeout: float) -> Outcome:
    """A core of the tests in a Blender for Windows, or all. The same release on this machine leaves files for
    it, and opens those that it leaves."""
    here, exchange = environments.blender(VERSION), ("test_other_systems.py",)
    total = blender_module("exchange", here, exchange, timeout)
    for_it = {OF_ANOTHER_SYSTEM: f"Z:{RESULTS / 'exchange' / 'files'}"}
    total += in_blender(VERSION, () if whole else CORE_TESTS, timeout, for_it)
    left = {OF_ANOTHER_SYSTEM: RESULTS / f"windows-blender-{VERSION}" / "files"}
    return total + blender_module("exchange-back", here, exchange, timeout, left)


def blender_5(timeout: float) -> Outcome:
    """The same core in the newest Blender for Windows, which takes Python 3.13."""
    if not environments.python313():
        return NO_PYTHON
    return in_blender(NEWEST, CORE_TESTS, timeout, {})


def in_blender(version: str, tests: tuple[str, ...], timeout: float, further: dict[str, str]) -> Outcome:
    """Runs these tests, or all, on the installed extension in a Blender for Windows, a Python module."""
    name = f"windows-blender-{version}"
    env = install_extension(version) | conditions(name) | further
    junit = new_junit(name)
    command = [python_with_blender(version), RUN_PYTEST, "--", *tests, *OPTIONS, f"--junitxml=Z:{junit}"]
    return outcome(junit, wine.run_in_windows(command, env=env, timeout=timeout))


def said_by_blender(system: str, version: str, words: list[str | Path], folder: Path) -> str:
    """What a new Blender of a system says while it runs a program. The last argument is ``folder``, which
    holds the folder of its user."""
    drive, user = ("Z:" if system == "windows" else ""), folder / "user"
    env = {"BLENDER_USER_RESOURCES": f"{drive}{user}", "NO_PROXY": "127.0.0.1"}
    words = [*words, f"{drive}{folder}"]
    if system == "windows":
        return wine.said_in_windows([python_with_blender(version), *words], env, timeout=600)
    command = list(map(str, [environments.blender(version).make().python, *words]))
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    return subprocess.run(command, env=environment(env), timeout=300, check=False, **pipes).stdout


@one_at_a_time()
def install_extension(version: str) -> dict[str, str]:
    """Installs the extension in that Blender, in a new user folder, and returns the environment variables."""
    zip_file = extension_with([build_wheel(11)]) if version == VERSION else package("windows")[0]
    env = {
        "BLENDER_USER_RESOURCES": f"Z:{emptied(BUILD / 'blender-users' / f'{USER} {version}')}",
        "SINEW_ADDON_MODULE": "bl_ext.user_default.sinew",
        "SINEW_TEST_OUTPUT": f"Z:{emptied(RESULTS / f'windows-blender-{version}')}",
    }
    command = [python_with_blender(version), INSIDE / "install_zip.py", "--", f"Z:{zip_file}"]
    said = wine.said_in_windows(command, env, timeout=300)
    if "native module works" not in said:
        raise SystemExit(f"{zip_file.name} could not be installed in Windows' Blender {version}:\n{said}")
    return env


def extension_with(wheels: list[Path]) -> Path:
    """An extension with these wheels alone. It lies outside ``dist``, as nobody is to get it."""
    target = WINDOWS.tree / "zips" / f"sinew-{version()}-windows-x64.zip"
    return write_zip(target, extension_files(wheels, manual_files()))


@one_at_a_time()
def python_with_blender(version: str) -> Path:
    """The Python for Windows that holds a Blender. Blender 5.2 asks for a NumPy that Wine 8 cannot import;
    that of the tests of the bindings takes its place."""
    if version != NEWEST:
        return wine.python(11, f"bpy-{version}")
    python = wine.python(13, f"bpy-{version}")
    theirs, own = (each.parent / "Lib" / "site-packages" for each in (wine.python(13), python))
    about = next(theirs.glob("numpy-*.dist-info"))  # its name has the version
    if not (own / about.name).is_dir():
        for newer in own.glob("numpy*/"):
            shutil.rmtree(newer)
        for older in theirs.glob("numpy*/"):
            shutil.copytree(older, own / older.name)
    return python

# SPDX-License-Identifier: GPL-3.0-or-later
"""The tests that run in Windows' programs under Wine: GoogleTest's, and those of the bindings in its Pythons.

Wine is not Windows: what it does not show stands in docs/developer/decisions/windows-by-mingw.md.
"""

import os
import re
from pathlib import Path

from . import environments, wine
from .cross_libraries import build, libraries
from .cross_wheels import configure
from .debian import GOOGLETEST, install
from .dev import build_tree
from .package import package
from .places import BUILD, DEV_MODULE, ROOT, WHEELS
from .results import Outcome, outcome
from .shell import jobs, must, one_at_a_time, say
from .suites import OPTIONS, RESULTS, emptied, googletest, new_junit
from .windows_libraries import WINDOWS
from .windows_wheels import TARGET, build_wheels

BINDINGS = ROOT / "tests" / "bindings"
LINALG = re.compile(r"^(?:import|from) scipy\.(?:sparse\.)?linalg", flags=re.MULTILINE)
# Every method's bind, pose, undo, save and load, cages, bakes, and files of earlier versions.
CORE_TESTS = (
    "test_bake.py",
    "test_bake_files.py",
    "test_cage.py",
    "test_event_files.py",
    "test_event_history.py",
    "test_every_method.py",
    "test_handles.py",
    "test_old_files.py",
)
INSTALL = Path(__file__).parent / "inside" / "install_zip.py"


def windows(timeout: float) -> Outcome:
    build_wheels()
    total = native_tests(timeout)
    for minor in (11, 13):
        if list(WHEELS.glob(f"*-cp3{minor}-win_amd64.whl")):
            total += bindings(minor, timeout)
        else:
            total += Outcome(note=f"no Python 3.{minor} here, so there is no wheel for it")
    return total + blender("4.5.15", CORE_TESTS, timeout)


def native_tests(timeout: float) -> Outcome:
    wine.set_up()
    return googletest("windows-native", ["wine", test_program()], timeout, wine.SETTINGS, drive="Z:")


@one_at_a_time()
def test_program() -> Path:
    """Builds the program of GoogleTest for Windows."""
    install(GOOGLETEST)
    libraries(WINDOWS)
    if not (WINDOWS.prefix / "lib" / "libgtest.a").is_file():
        build(WINDOWS, "googletest", Path("/usr/src/googletest"), "-DBUILD_GMOCK=OFF")
    # The tree of the wheel serves, so that the library is compiled once. CMake must not run the program.
    settings = ("-DSINEW_BUILD_TESTS=ON", "-DCMAKE_GTEST_DISCOVER_TESTS_DISCOVERY_MODE=PRE_TEST")
    tree = configure(TARGET, environments.build().make(), 11, *settings)
    must(["cmake", "--build", tree, "--target", "sinew_tests", "-j", str(jobs())], quiet=True)
    return tree / "tests" / "native" / "sinew_tests.exe"


def bindings(minor: int, timeout: float) -> Outcome:
    """The bindings' tests, on the unpacked wheel.

    One of them compares the answers of all methods with those of this machine.
    """
    here = answers_of_this_machine()
    python = wine.python(minor)
    files = sorted(BINDINGS.glob("test_*.py"))
    if minor == 13:  # Wine 8 lacks a function that SciPy's linalg calls there when it is imported
        files = [file for file in files if not LINALG.search(file.read_text(encoding="utf-8"))]
    junit = new_junit(f"windows-bindings-3.{minor}")
    unpacked = WINDOWS.tree / "wheel-check" / f"cp3{minor}"
    status = wine.run_in_windows(
        [python, "-m", "pytest", *files, *OPTIONS, f"--junitxml=Z:{junit}"],
        env={"PYTHONPATH": f"Z:{unpacked}", "SINEW_ANSWERS": f"Z:{here}"},
        timeout=timeout,
    )
    return outcome(junit, status)


def answers_of_this_machine() -> Path:
    build_tree("dev", "sinew_native")
    file = RESULTS / "answers.npz"
    python = environments.dev().make().python
    paths = f"{DEV_MODULE}{os.pathsep}{ROOT}"
    must([python, "-m", "tests.bindings.answers", file], env={"PYTHONPATH": paths}, quiet=True)
    return file


def blender(version: str, tests: tuple[str, ...], timeout: float) -> Outcome:
    """Installs the extension in a Blender for Windows, a Python 3.11 module, and runs these tests."""
    name = f"windows-blender-{version.rpartition('.')[0]}"
    python = wine.python(11, f"bpy-{version}")
    zip_file, _ = package("windows")
    env = {
        "BLENDER_USER_RESOURCES": f"Z:{emptied(BUILD / 'blender-users' / name)}",
        "SINEW_ADDON_MODULE": "bl_ext.user_default.sinew",
        "SINEW_TEST_OUTPUT": f"Z:{emptied(RESULTS / name)}",
    }
    said = wine.said_in_windows([python, INSTALL, "--", f"Z:{zip_file}"], env, timeout=300)
    junit = new_junit(name)
    script = ROOT / "tests" / "blender" / "run_pytest.py"
    command = [python, script, "--", *tests, *OPTIONS, f"--junitxml=Z:{junit}"]
    found = outcome(junit, wine.run_in_windows(command, env=env, timeout=timeout))
    if found.failed:
        say(said)
    return found

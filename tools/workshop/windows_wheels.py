# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the wheels of sinew_native for Windows on this machine, each with one statically linked module.

A wheel is only kept if its module needs nothing but Python and Windows' own libraries, moves no wide vector
in a way that Windows' stack is not aligned for, and works in Windows' Python under Wine.
"""

import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from . import environments, wine
from .archives import read_zip, write_wheel
from .environments import Environment
from .notices import ON_WINDOWS, notices
from .places import ROOT, WHEELS, version
from .shell import Stamp, fingerprint, jobs, must, one_at_a_time, say
from .windows_libraries import SETTINGS, TREE, imported_libraries, libraries, python_for_compilers

INPUTS = (
    "native",
    "CMakeLists.txt",
    "pyproject.toml",
    "README.md",
    "LICENSE",
    "tools/requirements/build.txt",
    *(f"tools/requirements/windows{python}.txt" for python in ("", "-3.11", "-3.13")),
    "tools/workshop/windows",
    *(
        f"tools/workshop/{name}.py"
        for name in ("archives", "notices", "wine", "windows_libraries", "windows_wheels")
    ),
)
CHECK = Path(__file__).parent / "inside" / "check_module.py"
PLATFORM = "win_amd64"
# What every Windows has. Whatever else a module imports must be in the wheel, and nothing else is.
OF_WINDOWS = {"kernel32.dll", "msvcrt.dll"}
# Moves between a register of 32 or 64 bytes and the stack that fail where the stack is aligned to 16 bytes.
ALIGNED_MOVE = re.compile(
    r"\tvmov(?:ap[sd]|dqa\w*|ntp[sd]|ntdqa?)\s[^\n]*(?:\(%r[sb]p[^\n]*%[yz]mm|%[yz]mm[^\n]*\(%r[sb]p)"
)
METADATA = (
    "import sys; from scikit_build_core.build import prepare_metadata_for_build_wheel as prepare; "
    "prepare(sys.argv[1])"
)


def build_wheels() -> list[Path]:
    """A wheel for Python 3.11 and, where this machine has the headers of a Python 3.13, one for 3.13."""
    builders = {11: environments.build(), 13: environments.build313()}
    return [build_wheel(builder.make(), minor) for minor, builder in builders.items() if builder]


@one_at_a_time()
def build_wheel(builder: Environment, minor: int) -> Path:
    """The wheel for one Python; it is built again only if inputs changed."""
    tag = f"cp3{minor}"
    wheel = WHEELS / f"sinew_native-{version()}-{tag}-{tag}-{PLATFORM}.whl"
    made_from = fingerprint([ROOT / name for name in INPUTS], str(builder.interpreter))
    stamp = Stamp(WHEELS / f"{tag}-{PLATFORM}.made-from", made_from)
    if stamp.is_fresh() and wheel.is_file():
        return wheel
    say(f"Building the wheel for {tag} on Windows")
    stamp.forget()
    for old in WHEELS.glob(f"*-{tag}-{PLATFORM}.whl"):
        old.unlink()
    tree = configure(builder, minor)
    must(["cmake", "--build", tree, "--target", "sinew_native", "-j", str(jobs())], quiet=True)
    with tempfile.TemporaryDirectory(dir=TREE) as folder:
        must(["cmake", "--install", tree, "--prefix", folder], quiet=True)
        check_module(next(Path(folder).glob("*.pyd")), minor)
        must([builder.python, "-c", METADATA, folder], quiet=True)
        files = {path.relative_to(folder).as_posix(): path.read_bytes() for path in _files(Path(folder))}
    about = next(name for name in files if name.endswith(".dist-info/WHEEL"))
    files[about] = re.sub(rb"(?m)^Tag: .*$", f"Tag: {tag}-{tag}-{PLATFORM}".encode(), files[about])
    files[about.replace("WHEEL", "RECORD")] = b""
    write_wheel(wheel, files | notices(files, ON_WINDOWS, builder))
    check_wheel(wheel, minor)
    stamp.write()
    return wheel


def configure(builder: Environment, minor: int, *further: str) -> Path:
    """Configures the tree that compiles for Windows' Python 3.``minor``."""
    prefix = libraries()
    question = "import sysconfig; print(sysconfig.get_path('include'))"
    asked = subprocess.run([builder.interpreter, "-c", question], capture_output=True, text=True, check=True)
    python = python_for_compilers(minor, Path(asked.stdout.strip()))
    tree = TREE / f"cp3{minor}"
    must(
        [
            *("cmake", "-S", ROOT, "-B", tree, *SETTINGS),
            f"-DCGAL_INCLUDE_DIR={prefix / 'include'}",
            f"-Dpybind11_DIR={builder.site_packages / 'pybind11' / 'share' / 'cmake' / 'pybind11'}",
            f"-DPython_EXECUTABLE={builder.python}",
            f"-DPython_INCLUDE_DIR={python / 'include'}",
            f"-DPython_LIBRARY={python / f'libpython3{minor}.a'}",
            f"-DPYTHON_MODULE_EXTENSION=.cp3{minor}-{PLATFORM}.pyd",
            "-DPYTHON_MODULE_DEBUG_POSTFIX=",
            "-DPYTHON_IS_DEBUG=OFF",
            "-DCMAKE_DISABLE_FIND_PACKAGE_OpenMP=ON",  # CHOLMOD is built without it
            *further,
        ],
        quiet=True,
    )
    return tree


def check_module(module: Path, minor: int) -> None:
    """Ends the tool if a module could not be loaded by every Windows, or might crash there."""
    foreign = imported_libraries(module) - OF_WINDOWS - {f"python3{minor}.dll"}
    if foreign:
        raise SystemExit(f"{module.name} needs {', '.join(sorted(foreign))}, which the wheel does not hold")
    aligned = ALIGNED_MOVE.findall(disassembled(module))
    if aligned:
        raise SystemExit(f"{module.name} has {len(aligned)} aligned moves of wide vectors on the stack")


def disassembled(module: Path) -> str:
    listing = ["x86_64-w64-mingw32-objdump", "-d", "--no-show-raw-insn", str(module)]
    return subprocess.run(listing, capture_output=True, text=True, check=True).stdout


def check_wheel(wheel: Path, minor: int) -> None:
    """Loads the wheel in Windows' Python under Wine, from a folder that holds nothing else."""
    unpacked = TREE / "wheel-check" / f"cp3{minor}"
    shutil.rmtree(unpacked, ignore_errors=True)
    for name, content in read_zip(wheel).items():
        (unpacked / name).parent.mkdir(parents=True, exist_ok=True)
        (unpacked / name).write_bytes(content)
    said = wine.said_in_windows([wine.python(minor), CHECK], {"PYTHONPATH": f"Z:{unpacked}"}, timeout=300)
    if f"works in Python 3.{minor}." not in said:
        wheel.unlink()
        raise SystemExit(f"{wheel.name} does not work in Windows' Python 3.{minor} under Wine:\n{said}")
    say(f"{wheel.name} works in Windows' Python 3.{minor} under Wine")


def _files(folder: Path) -> list[Path]:
    return sorted(path for path in folder.rglob("*") if path.is_file())

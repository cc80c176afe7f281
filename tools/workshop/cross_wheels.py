# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds wheels of sinew_native for a system, each with one static module, from pinned sources."""

import re
import shutil
import tempfile
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

from . import environments, zig
from .archives import read_folder, write_wheel
from .cross_libraries import System, libraries
from .dev import types
from .environments import Environment
from .notices import notices
from .places import PACKAGES, ROOT, WHEEL_SOURCES, WHEELS, version
from .shell import Stamp, fingerprint, jobs, must, one_at_a_time, said, say

INPUTS = (
    *WHEEL_SOURCES,
    "tools/workshop/libraries",
    *(f"tools/workshop/{name}.py" for name in ("archives", "cross_libraries", "cross_wheels", "notices")),
)
METADATA = (
    "import sys; from scikit_build_core.build import prepare_metadata_for_build_wheel as prepare; "
    "prepare(sys.argv[1])"
)


@dataclass(frozen=True)
class Target:
    """What the wheels for one system are, beside what all have in common."""

    system: System
    platform: str  # as in the names of wheels
    suffix: str  # of the module's file, with {minor} for that of Python
    inputs: tuple[str, ...]
    check_module: Callable[[Path, int], None]  # ends the tool if the system could not load the module
    check_wheel: Callable[[Path, int], None]  # ends the tool if the wheel does not work
    python: Callable[[int], list[str]] = lambda minor: []  # further settings of CMake for Python 3.minor
    has_python: Callable[[int], bool] = lambda minor: True  # whether there is a Python 3.minor to try a wheel
    licences: dict[str, Path] = field(default_factory=dict)  # of what this system alone links into the module


def build_wheels(target: Target, for_programs: bool = False) -> list[Path]:
    """A wheel for each Python of a Blender, or of any program, whose headers this machine has."""
    wheels = []
    for minor, builder in environments.builders(for_programs).items():
        if target.has_python(minor):
            wheels.append(build_wheel(target, builder.make(), minor))
        else:
            say(f"No wheel for Python 3.{minor} on {target.system.title}: there is none to try it with")
    return wheels


def are_built(target: Target) -> bool:
    """Whether build_wheels() would find all its wheels made from what is there now."""
    found = [_wheel(target, builder, minor) for minor, builder in environments.builders().items()]
    return all(stamp.is_fresh() and wheel.is_file() for wheel, stamp in found)


def _wheel(target: Target, builder: Environment, minor: int) -> tuple[Path, Stamp]:
    """Where the wheel for one Python is, and the stamp of what it is made from."""
    tag = f"cp3{minor}"
    inputs = [*(ROOT / name for name in (*INPUTS, *target.inputs)), *target.system.inputs]
    made_from = fingerprint(inputs, str(builder.interpreter))
    stamp = Stamp(WHEELS / f"{tag}-{target.platform}.made-from", made_from)
    return WHEELS / f"sinew_native-{version()}-{tag}-{tag}-{target.platform}.whl", stamp


@one_at_a_time()
def build_wheel(target: Target, builder: Environment, minor: int) -> Path:
    """The wheel for one Python; it is built again only if inputs changed."""
    tag = f"cp3{minor}"
    wheel, stamp = _wheel(target, builder, minor)
    if stamp.is_fresh() and wheel.is_file():
        return wheel
    say(f"Building the wheel for {tag} on {target.system.title}")
    stamp.forget()
    for old in WHEELS.glob(f"*-{tag}-{target.platform}.whl"):
        old.unlink()
    tree = configure(target, builder, minor)
    must(["cmake", "--build", tree, "--target", "sinew_native", "-j", str(jobs())], quiet=True)
    with tempfile.TemporaryDirectory(dir=target.system.tree) as folder:
        must(["cmake", "--install", tree, "--prefix", folder], quiet=True)
        target.check_module(next(Path(folder).glob(f"*{_suffix(target, minor)}")), minor)
        must([builder.python, "-c", METADATA, folder], quiet=True)
        shutil.copy(types(), folder)  # of this machine's module, which has the same names
        unwanted = shutil.ignore_patterns("__pycache__")
        shutil.copytree(PACKAGES / "sinew_farm", Path(folder) / "sinew_farm", ignore=unwanted)
        files = read_folder(Path(folder))
    about = next(name for name in files if name.endswith(".dist-info/WHEEL"))
    files[about] = re.sub(rb"(?m)^Tag: .*$", f"Tag: {tag}-{tag}-{target.platform}".encode(), files[about])
    files[about.replace("WHEEL", "RECORD")] = b""
    write_wheel(wheel, files | notices(files, zig.licences() | target.licences, builder))
    check(target, wheel, minor)
    stamp.write()
    return wheel


def check(target: Target, wheel: Path, minor: int) -> None:
    """Ends the tool if a wheel does not work, and removes the wheel."""
    try:
        target.check_wheel(wheel, minor)
    except SystemExit:
        wheel.unlink()
        raise


def configure(target: Target, builder: Environment, minor: int, *further: str) -> Path:
    """Configures the tree that compiles for Python 3.``minor`` of a system."""
    prefix = libraries(target.system)
    include = python_headers(target.system, builder, minor)
    module = (
        f"-DCGAL_INCLUDE_DIR={prefix / 'include'}",
        "-DCMAKE_DISABLE_FIND_PACKAGE_OpenMP=ON",  # CHOLMOD is built without it
        f"-Dpybind11_DIR={builder.site_packages / 'pybind11' / 'share' / 'cmake' / 'pybind11'}",
        f"-DPython_EXECUTABLE={builder.python}",
        f"-DPython_INCLUDE_DIR={include}",
        f"-DPYTHON_MODULE_EXTENSION={_suffix(target, minor)}",
        "-DPYTHON_MODULE_DEBUG_POSTFIX=",
        "-DPYTHON_IS_DEBUG=OFF",
        "-DSINEW_BUILD_TESTS=OFF",  # unless they are asked for: the tree would remember that they once were
        *target.python(minor),
    )
    tree = target.system.tree / f"cp3{minor}"
    must(["cmake", "-S", ROOT, "-B", tree, *target.system.configuration(), *module, *further], quiet=True)
    return tree


def python_headers(system: System, builder: Environment, minor: int) -> Path:
    """The headers of this machine's Python 3.``minor`` with the pyconfig.h of the system.

    Python.h looks for pyconfig.h in its own folder first, so the headers are copied and this one is replaced.
    For Linux it stays, with the one that Debian's includes.
    """
    question = "import sysconfig as s; print(s.get_path('include'), s.get_config_var('MULTIARCH'))"
    headers, machine = map(Path, said([builder.interpreter, "-c", question]).split())
    folder = system.tree / f"python3{minor}-headers"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(headers, folder)
    own = system.files / "python"
    if own.is_dir():
        return Path(shutil.copytree(own, folder, dirs_exist_ok=True))
    included = headers.parent / machine / headers.name
    if included.is_dir():
        shutil.copytree(included, folder / machine / headers.name)
    return folder


def _suffix(target: Target, minor: int) -> str:
    return target.suffix.format(minor=minor)

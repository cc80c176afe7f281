# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds self-contained wheels of sinew_native, for Linux, or for Windows or macOS (cross_wheels.py).

One for Python 3.11 (Blender 3.4.1 of Debian 12 and 4.2 to 5.0) and, where a Python 3.13 exists, one for 3.13
(Blender 5.1 and later); if wanted, also for 3.12 and 3.14. Each carries its own CHOLMOD, OpenBLAS, TBB and
OpenSubdiv, and is only kept if it works.
"""

import argparse
import os
import shutil
import tempfile
from pathlib import Path

from . import debian, environments, macos_wheels, windows_wheels
from .archives import read_zip, unpack, write_wheel
from .environments import Environment
from .isolation import isolated
from .notices import notices, of_packages, repaired
from .places import BUILD, PYTHON311, ROOT, WHEEL_SOURCES, WHEELS, version
from .shell import Stamp, fingerprint, jobs, must, one_at_a_time, say

INPUTS = (
    *WHEEL_SOURCES,
    *(f"tools/workshop/{name}.py" for name in ("archives", "isolation", "notices", "wheels")),
)
OTHERS = {"macos": macos_wheels.build_wheels, "windows": windows_wheels.build_wheels}
CHECK = Path(__file__).parent / "inside" / "check_module.py"
WITHOUT_BLENDER = (12, 14)  # the second numbers of Pythons that no Blender of blender.org comes with
EPOCH = "315532800"  # 1 January 1980, the first date that a zip can store


def build_wheels(for_programs: bool = False) -> list[Path]:
    """The repaired wheels, also those for programs without Blender; built again only if inputs changed."""
    debian.install(debian.BUILD)
    builders = [environments.build(), environments.build313()]
    builders += [environments.build_for(minor) for minor in WITHOUT_BLENDER if for_programs]
    return [build_wheel(builder.make()) for builder in builders if builder]


@one_at_a_time()
def build_wheel(builder: Environment) -> Path:
    tag = _tag(builder)
    made_from = fingerprint([ROOT / name for name in INPUTS], str(builder.interpreter))
    stamp = Stamp(WHEELS / f"{tag}.made-from", made_from)
    if stamp.is_fresh() and len(list(WHEELS.glob(f"*-{tag}-*linux*.whl"))) == 1:
        return _wheel(tag)
    say(f"Building the wheel for {tag}")
    stamp.forget()
    _require_threaded_blas()
    for old in WHEELS.glob(f"*-{tag}-*linux*.whl"):
        old.unlink()
    with tempfile.TemporaryDirectory(dir=_made(BUILD)) as raw:
        settings = {
            "PATH": f"{builder.bin}{os.pathsep}{os.environ['PATH']}",
            "CC": "gcc",  # the same for every Python, so that ccache can reuse the compiled library
            "CXX": "g++",
            "CMAKE_BUILD_PARALLEL_LEVEL": str(jobs()),
            "CMAKE_CXX_COMPILER_LAUNCHER": "ccache",
            "CMAKE_GENERATOR": "Ninja",
            "SOURCE_DATE_EPOCH": EPOCH,
        }
        build = [builder.python, "-m", "build", "--wheel", "--no-isolation", "--outdir", raw, ROOT]
        must(build, env=settings, quiet=True)
        made = next(Path(raw).glob("*.whl"))
        must([builder.bin / "auditwheel", "repair", "-w", _made(WHEELS), made], env=settings, quiet=True)
    wheel = _wheel(tag)
    files = isolated(read_zip(wheel), builder)
    write_wheel(wheel, files | notices(files, of_packages(repaired(files)), builder))
    check_wheel(wheel, builder)
    stamp.write()
    return wheel


def check_wheel(wheel: Path, builder: Environment) -> None:
    """Loads the wheel without the libraries of the build, in plain CPython and, if installed, in Blender."""
    unpacked = unpack(wheel, BUILD / "wheel-check" / _tag(builder))
    must([builder.python, "-I", CHECK, "--own-libraries", unpacked, "--alone"], timeout=120, quiet=True)
    say(f"{wheel.name} works in {builder.interpreter}")
    blender = shutil.which("blender", path="/usr/bin")
    if blender and builder.interpreter == PYTHON311:
        script = [blender, "--background", "--factory-startup", "--python-exit-code", "1", "--python", CHECK]
        must([*script, "--", "--own-libraries", unpacked], timeout=120, quiet=True)
        say(f"{wheel.name} works in {blender}")


def _require_threaded_blas() -> None:
    """Of several builds of OpenBLAS, the serial one gives wrong results when two binds run at once."""
    chosen = Path("/usr/lib/x86_64-linux-gnu/libblas.so.3").resolve()
    if "openblas-pthread" not in str(chosen):
        raise SystemExit(
            f"The wheel would carry {chosen}. Choose OpenBLAS's pthread build: "
            "update-alternatives --config libblas.so.3-x86_64-linux-gnu (and liblapack.so.3-...)"
        )


def _made(folder: Path) -> Path:
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def _tag(builder: Environment) -> str:
    """As in the name of the wheel: "cp312" for the environment "build-3.12"."""
    return "cp" + (builder.name.removeprefix("build").strip("-") or "3.11").replace(".", "")


def _wheel(tag: str) -> Path:
    found = sorted(WHEELS.glob(f"sinew_native-{version()}-{tag}-*linux*.whl"))
    if len(found) != 1:
        raise SystemExit(f"expected one wheel of {version()} for {tag} in {WHEELS}, found {len(found)}")
    return found[0]


def main() -> None:
    parser = argparse.ArgumentParser(prog="tools/build_wheels", description=__doc__)
    systems, further = ("linux", *OTHERS), "on Linux also for Python 3.12 and 3.14, where these exist"
    parser.add_argument("system", nargs="?", default="linux", choices=systems, help="without one, linux")
    parser.add_argument("--all", action="store_true", help=further)
    options = parser.parse_args()
    other = OTHERS.get(options.system)
    for wheel in other() if other else build_wheels(options.all):
        say(str(wheel.relative_to(ROOT)))

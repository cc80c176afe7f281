# SPDX-License-Identifier: GPL-3.0-or-later
"""Builds the static libraries that the sinew_native of a wheel links, for each system.

``libraries/sources.txt`` pins the sources of Debian's packages by digests. Only what is linked is built:
CHOLMOD with its orderings and METIS, oneTBB, OpenSubdiv's CPU half, and the few routines of BLAS. Eigen, CGAL
and Boost are headers, which come from the packages of this machine.
"""

import hashlib
import shutil
import tarfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from . import debian
from .places import BUILD
from .shell import Stamp, fingerprint, jobs, must, one_at_a_time, said, say

LIBRARIES = Path(__file__).parent / "libraries"
SOURCES = BUILD / "sources"
NO_OPENSUBDIV = (
    "EXAMPLES TUTORIALS REGRESSION DOC OMP TBB CUDA OPENCL OPENGL CLEW DX GLEW GLFW METAL PTEX TESTS GLTESTS "
    "MACOS_FRAMEWORK"
)
NO_TBB = ("BUILD_SHARED_LIBS", "TBB_TEST", "TBB_EXAMPLES", "TBB_STRICT", "TBBMALLOC_BUILD")
SETTINGS = {
    "onetbb": (*(f"-D{name}=OFF" for name in NO_TBB), "-DTBB_DISABLE_HWLOC_AUTOMATIC_SEARCH=ON"),
    "opensubdiv": (*(f"-DNO_{name}=ON" for name in NO_OPENSUBDIV.split()), "-DBUILD_SHARED_LIBS=OFF"),
}
ALL = ("onetbb", "opensubdiv", "suitesparse", "blas")


@dataclass(frozen=True)
class System:
    """A system that this machine compiles for."""

    name: str  # of its folder in .build, and of the one beside this file that holds its toolchain.cmake
    title: str
    make_compiler: Callable[[], object]  # installs it
    settings: tuple[str, ...]  # of CMake, beside those of every system
    inputs: tuple[Path, ...] = ()  # files that the libraries depend on, beside those of every system

    @property
    def files(self) -> Path:
        return Path(__file__).parent / self.name

    @property
    def tree(self) -> Path:
        return BUILD / self.name

    @property
    def prefix(self) -> Path:
        """Where the libraries and their headers are."""
        return self.tree / "libraries"

    def configuration(self) -> list[str]:
        """What CMake needs to know wherever it compiles for this system."""
        return [
            "-GNinja",
            "-Wno-dev",
            f"-DCMAKE_TOOLCHAIN_FILE={self.files / 'toolchain.cmake'}",
            "-DCMAKE_BUILD_TYPE=Release",
            f"-DCMAKE_PREFIX_PATH={self.prefix}",
            "-DEigen3_DIR=/usr/share/eigen3/cmake",
            *self.settings,
        ]


@dataclass(frozen=True)
class Source:
    package: str
    archive: str
    digest: str

    @property
    def path(self) -> Path:
        return SOURCES / self.archive


def pinned(file: Path) -> list[Source]:
    lines = file.read_text(encoding="utf-8").splitlines()
    return [Source(*line.split()) for line in lines if not line.startswith("#")]


@one_at_a_time()
def libraries(system: System, names: tuple[str, ...] = ALL) -> Path:
    """The folder with these libraries and their headers, which are built again only if something changed."""
    debian.install(debian.BUILD)
    system.make_compiler()
    inputs = [LIBRARIES, system.files, Path(__file__), *system.inputs]
    stamp = Stamp(system.prefix / "made-from", fingerprint(inputs, *system.settings, *names))
    if stamp.is_fresh():
        return system.prefix
    stamp.forget()
    shutil.rmtree(system.prefix, ignore_errors=True)
    fetch_from_debian()
    sources = {name: unpacked(system, name) for name in names if name != "blas"}
    for name in names:
        own = LIBRARIES / name  # our CMake file, for those that have none which serves
        found = [f"-DSINEW_SOURCE={sources[name]}"] if own.is_dir() and name in sources else []
        build(system, name, own if own.is_dir() else sources[name], *SETTINGS.get(name, ()), *found)
    # The whole folder of the system would bring the headers of Linux's C library along.
    for name in ("CGAL", "boost"):
        (system.prefix / "include" / name).symlink_to(Path("/usr/include") / name)
    shutil.rmtree(system.tree / "unpacked")
    stamp.write()
    return system.prefix


def build(system: System, name: str, source: Path, *settings: str) -> None:
    """Builds a library by CMake into the prefix of a system."""
    say(f"Building {name} for {system.title}")
    tree = system.tree / name
    prefix = f"-DCMAKE_INSTALL_PREFIX={system.prefix}"
    options = [*system.configuration(), prefix, *settings]
    must(["cmake", "--fresh", "-S", source, "-B", tree, *options], quiet=True)
    must(["cmake", "--build", tree, "--target", "install", "-j", str(jobs())], quiet=True)


def unpacked(system: System, package: str) -> Path:
    """The folder of the unpacked sources of a package."""
    source = next(row for row in pinned(LIBRARIES / "sources.txt") if row.package == package)
    target = system.tree / "unpacked" / package
    shutil.rmtree(target, ignore_errors=True)
    with tarfile.open(source.path) as archive:
        archive.extractall(target)
    return next(target.iterdir())


def fetch_from_debian() -> None:
    """Downloads the sources that are not there yet, from where this machine gets its packages."""
    wanted = pinned(LIBRARIES / "sources.txt")
    missing = [row.package for row in wanted if not row.path.is_file()]
    if missing:
        say("Downloading the sources of " + ", ".join(missing))
        SOURCES.mkdir(parents=True, exist_ok=True)
        settings = _apt_of_sources()
        lacking = "apt could not download the sources of " + ", ".join(missing)
        must(["apt-get", "-qq", *settings, "update"], lacking=lacking, quiet=True)
        download = ["apt-get", "-qq", *settings, "source", "--download-only", *missing]
        must(download, cwd=SOURCES, lacking=lacking, quiet=True)
    for row in wanted:
        check(row)


def _apt_of_sources() -> list[str]:
    """Options that let apt-get know Debian's source packages, without a change to the machine's own lists."""
    question = ["apt-get", "indextargets", "--format", "$(REPO_URI) $(CODENAME) $(COMPONENT)"]
    lines = said([*question, "Created-By: Packages", "Codename: bookworm"]).splitlines()
    if not lines:
        raise SystemExit("apt knows no package of Debian 12, whose sources are needed: apt-get update")
    folder = SOURCES / "apt"
    (folder / "lists" / "partial").mkdir(parents=True, exist_ok=True)
    (folder / "sources.list").write_text("".join(f"deb-src {line}\n" for line in lines), encoding="utf-8")
    sources = ("Dir::Etc::sourceparts=-", f"Dir::Etc::sourcelist={folder / 'sources.list'}")
    caches = ("Dir::Cache::pkgcache=", "Dir::Cache::srcpkgcache=", f"Dir::State::lists={folder / 'lists'}")
    return [word for place in (*sources, *caches, "APT::Sandbox::User=root") for word in ("-o", place)]


def check(source: Source) -> None:
    """Ends the tool if a downloaded file is not the pinned one."""
    if not source.path.is_file():
        raise SystemExit(f"{source.package} no longer brings {source.archive}, which tools/workshop pins")
    found = hashlib.sha256(source.path.read_bytes()).hexdigest()
    if found != source.digest:
        raise SystemExit(f"{source.archive} has the SHA-256 {found}, tools/workshop pins {source.digest}")

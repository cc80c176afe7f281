# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the folder that a static web host shows, ``dist/release``:

``stable/``, ``latest/``  a repository of extensions each, with links that can be dragged into Blender
``legacy/``               the zips for Blender before 4.2
``python/``               the wheels and the source archive of the library
``NOTES.md``, ``SHA256SUMS``, and the site

With ``--latest``, ``stable/`` is left out, so that a host keeps what it has there. Each version that is
published needs a number of its own: Blender does not replace a compiled module of the same version.
"""

import argparse
import hashlib
import re
import shutil
from collections.abc import Iterable
from pathlib import Path

from . import cross_wheels, environments
from .package import extension_tool, package
from .places import DIST, ROOT, address, exists, version
from .shell import git, must, say
from .site import write_site
from .suites import emptied
from .wheels import TARGETS, name_what_is_missing

RELEASE = DIST / "release"
PAGE = Path(__file__).parent / "inside" / "repository.html"
# Blender's own command, which reads the folder in the order of the disk, and writes it in that order.
SORTED = """
import os, runpy, sys
scan = os.scandir
os.scandir = lambda folder: sorted(scan(folder), key=lambda entry: entry.name)
del sys.argv[0]
runpy.run_path(sys.argv[0], run_name="__main__")
"""


def release(channels: Iterable[str]) -> Path:
    news = notes(changelog(), version())
    environments.newest_blender().make()  # validates and lists the extensions
    folder = emptied(RELEASE)
    shutil.copytree(write_site(), folder, dirs_exist_ok=True)  # whose first page is that of the folder
    zips = [package(system) for system in TARGETS]
    for channel in channels:
        repository(folder / channel, [extension for extension, _legacy in zips])
    copy([legacy for _extension, legacy in zips], folder / "legacy")
    wheels = [wheel for target in TARGETS.values() for wheel in cross_wheels.build_wheels(target, True)]
    name_what_is_missing()
    copy(wheels, folder / "python")
    source_archive(folder / "python")
    (folder / "NOTES.md").write_text(news, encoding="utf-8")
    (folder / "SHA256SUMS").write_text(sums(folder), encoding="utf-8")
    return folder


def repository(folder: Path, zips: Iterable[Path]) -> Path:
    """A repository of these extensions, as Blender's own command lists them."""
    copy(zips, emptied(folder))
    blender = environments.newest_blender().make()
    generate = [blender.python, "-c", SORTED, extension_tool(blender), "server-generate"]
    must([*generate, f"--repo-dir={folder}", "--html", f"--html-template={PAGE}"], quiet=True)
    return folder


def source_archive(folder: Path) -> Path:
    """The sources of the library in one file, from which pip builds it."""
    builder = environments.build().make()
    folder.mkdir(exist_ok=True)
    options = ["--sdist", "--no-isolation", "--outdir", folder]
    must([builder.python, "-m", "build", *options, ROOT], quiet=True)
    return next(folder.glob("sinew_native-*.tar.gz"))


def copy(files: Iterable[Path], folder: Path) -> None:
    folder.mkdir(exist_ok=True)
    for file in files:
        shutil.copyfile(file, folder / file.name)


def changelog() -> str:
    return (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def notes(text: str, of_version: str) -> str:
    """What the changelog says about a version, or what is new since then if there is something."""
    found = unreleased(text) or section(text, of_version)
    if not found:
        raise SystemExit(f"CHANGELOG.md has no entries for version {of_version}")
    return f"# Sinew {of_version}\n\n{found}\n"


def unreleased(text: str) -> str:
    return section(text, "Unreleased")


def section(text: str, name: str) -> str:
    found = re.search(rf"^## \[{re.escape(name)}\][^\n]*\n(.*?)(?=^## |\Z)", text, flags=re.M | re.S)
    return found[1].strip() if found else ""


def sums(folder: Path) -> str:
    """A line for each file, as sha256sum writes and checks it."""
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    digests = {path.relative_to(folder).as_posix(): hashlib.sha256(path.read_bytes()) for path in files}
    return "".join(f"{digest.hexdigest()}  {name}\n" for name, digest in digests.items())


def refusal(place: str, text: str, channels: Iterable[str]) -> str:
    """Why what is here must not be published; empty if it may."""
    if not exists(place):
        return (
            f"Nothing can be published yet: pyproject.toml says that Sinew is at '{place}', which is no "
            "address on the web. Set Homepage under [project.urls] to the address of the host. To look at "
            "the folder before, run tools/release --preview"
        )
    tag = f"v{version()}"
    if git("tag", "--list", tag) and git("rev-list", "--max-count=1", tag) != git("rev-parse", "HEAD"):
        return f"Nothing can be published: another commit is {tag}. State the next version in CMakeLists.txt"
    if changes := git("status", "--porcelain"):
        return f"Nothing can be published before these changes are committed:\n{changes}"
    if "stable" in channels and unreleased(text):
        return (
            "The channel stable cannot be published: CHANGELOG.md has entries under Unreleased. Put them "
            "under the next version, or publish the channel latest alone by tools/release --latest"
        )
    return ""


def main() -> None:
    as_it_is = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="tools/release", description=__doc__, formatter_class=as_it_is)
    parser.add_argument("--latest", action="store_true", help="leave out the channel stable")
    about = "make the folder although it must not be published yet"
    parser.add_argument("--preview", action="store_true", help=about)
    options = parser.parse_args()
    channels = ("latest",) if options.latest else ("stable", "latest")
    reason = refusal(address(), changelog(), channels)
    if reason and not options.preview:
        raise SystemExit(reason)
    say(f"{release(channels).relative_to(ROOT)} is ready. {reason}".rstrip())

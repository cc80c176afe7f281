# SPDX-License-Identifier: GPL-3.0-or-later
"""Packs the two zips that people install, for Linux, Windows or macOS.

``dist/sinew-<version>-linux-x64.zip``         extension for Blender 4.2 and later, wheels inside
``dist/sinew-legacy-<version>-linux-x64.zip``  add-on for Blender 3.4, the cp311 wheel unpacked in
``sinew/_native``

For Windows they end in ``-windows-x64.zip``, for macOS in ``-macos-arm64.zip``. All hold the manual and the
pages about methods in ``manual/``, as the site has them.

For ``here``, Debian's Blender on this machine alone, there is a legacy zip in ``.build``, without a wheel.

The same tree and wheels give the same bytes, whenever they are packed.
"""

import argparse
import functools
import re
import tomllib
from pathlib import Path

from . import cross_wheels, environments, wheels
from .archives import read_zip, write_zip
from .dev import build_tree
from .environments import Environment
from .places import ADDON, BUILD, DEV_MODULE, DIST, ROOT, address, exists, version
from .shell import must, one_at_a_time, say
from .site import manual_files

MANIFEST = "blender_manifest.toml"
NATIVE_FOLDER = "_native"
EXCLUDED_SUFFIXES = (".pyc", ".blend1", ".orig", ".swp")
PLATFORMS = {
    "manylinux": "linux-x64",
    "win_amd64": "windows-x64",
    "macosx_11_0_arm64": "macos-arm64",
}


def addon_files() -> dict[str, bytes]:
    """All files of the add-on: path inside the add-on -> content."""
    found = {}
    for path in sorted(ADDON.rglob("*")):
        inside = path.relative_to(ADDON)
        hidden = any(part == "__pycache__" or part.startswith(".") for part in inside.parts)
        hidden |= path.suffix in EXCLUDED_SUFFIXES or inside.parts[0] == NATIVE_FOLDER
        if path.is_file() and not hidden:
            found[inside.as_posix()] = path.read_bytes()
    if MANIFEST not in found or "__init__.py" not in found:
        raise SystemExit(f"{ADDON} is not an add-on: {MANIFEST} or __init__.py is missing")
    found["LICENSE"] = (ROOT / "LICENSE").read_bytes()
    return found


def extension_files(wheels: list[Path], manual: dict[str, bytes]) -> dict[str, bytes]:
    files = addon_files() | manual
    files[MANIFEST] = filled_manifest(files[MANIFEST].decode(), [wheel.name for wheel in wheels]).encode()
    return files | {f"wheels/{wheel.name}": wheel.read_bytes() for wheel in wheels}


def legacy_files(native: dict[str, bytes], manual: dict[str, bytes]) -> dict[str, bytes]:
    """``native`` are the files of an unpacked wheel, of which Blender needs the module alone."""
    files = addon_files() | manual
    note = '# SPDX-License-Identifier: GPL-3.0-or-later\n"""The unpacked wheel of sinew_native."""\n'
    files[f"{NATIVE_FOLDER}/__init__.py"] = note.encode()
    module = {name: content for name, content in native.items() if not name.startswith("sinew_farm/")}
    files |= {f"{NATIVE_FOLDER}/{name}": content for name, content in module.items()}
    return {f"sinew/{name}": content for name, content in files.items()}


def filled_manifest(text: str, wheel_names: list[str]) -> str:
    """The manifest with the ``wheels`` and ``platforms`` of the wheels that are packed, and the website."""
    if exists(address()):
        text = re.sub(r"^(?=id\s*=)", f'website = "{address()}"\n', text, count=1, flags=re.M)
    values = {
        "platforms": sorted({_platform(name) for name in wheel_names}),
        "wheels": [f"./wheels/{name}" for name in wheel_names],
    }
    for key, items in values.items():
        line = f"{key} = [\n" + "".join(f'  "{item}",\n' for item in items) + "]\n"
        old = rf"^{key}\s*=\s*\[[^\]]*\]\s*?\n"
        text, replaced = re.subn(old, line.replace("\\", r"\\"), text, flags=re.M)
        if replaced == 0:  # keys must stand before the first table
            table = re.search(r"^\[", text, flags=re.M)
            place = table.start() if table else len(text)
            text = text[:place] + line + "\n" + text[place:]
    stated = tomllib.loads(text)
    if stated["version"] != version() or stated["wheels"] != values["wheels"]:
        raise SystemExit(f"{MANIFEST} states version {stated['version']}, CMakeLists.txt {version()}")
    return text


def _platform(wheel_name: str) -> str:
    tag = wheel_name.removesuffix(".whl").rsplit("-", 1)[-1]
    found = [platform for prefix, platform in PLATFORMS.items() if tag.startswith(prefix)]
    if not found:
        raise SystemExit(f"{wheel_name}: no Blender platform is known for {tag}")
    return found[0]


def pack(target: Path, files: dict[str, bytes]) -> Path:
    write_zip(target, files)
    say(f"{target.relative_to(ROOT)}  {target.stat().st_size / 1e6:.1f} MB")
    return target


def extension_tool(blender: Environment) -> Path | None:
    """Blender's own command for extensions, if that Blender is set up (``tools/setup tests``)."""
    scripts = "lib/python3*/site-packages/bpy/*/scripts/addons_core/bl_pkg/cli"
    return next(blender.folder.glob(f"{scripts}/blender_ext.py"), None)


def validate(extension: Path, blender: Environment) -> None:
    """Lets a Blender check an extension, and its tags by Blender's own list, if that Blender is set up."""
    tool = extension_tool(blender)
    if not tool:
        say(f"{extension.name} was not validated: {blender.folder.relative_to(ROOT)} is not set up")
        return
    tags = tool.parents[3] / "modules" / "_bpy_internal" / "extensions" / "tags.py"
    must([blender.python, tool, "validate", f"--valid-tags={tags}", extension], quiet=True)
    say(f"{extension.name} passes the validation of {blender.name}")


@functools.cache
@one_at_a_time()
def package(system: str = "linux") -> tuple[Path, Path]:
    """Packs the extension and the legacy zip for a system, once per run."""
    extension, legacy = zips(cross_wheels.build_wheels(wheels.TARGETS[system]), manual_files())
    validate(extension, environments.newest_blender())
    return extension, legacy


def zips(wheels: list[Path], manual: dict[str, bytes]) -> tuple[Path, Path]:
    """Replaces the zips of a platform. Those of other versions go last, so that there always are some."""
    (platform,) = {_platform(wheel.name) for wheel in wheels}
    extension = pack(DIST / f"sinew-{version()}-{platform}.zip", extension_files(wheels, manual))
    oldest = next(wheel for wheel in wheels if "-cp311-" in wheel.name)
    unpacked = legacy_files(read_zip(oldest), manual)
    legacy = pack(DIST / f"sinew-legacy-{version()}-{platform}.zip", unpacked)
    for old in {*DIST.glob(f"sinew-*-{platform}.zip")} - {extension, legacy}:
        old.unlink()
    return extension, legacy


@functools.cache
@one_at_a_time()
def package_for_this_machine() -> Path:
    """Packs the legacy zip with the module of the developer's tree, for Debian's Blender. That module uses
    the libraries of this machine, so it takes no wheel to build, and works nowhere else."""
    build_tree("dev", "sinew_native")
    module = {path.name: path.read_bytes() for path in DEV_MODULE.glob("sinew_native*.so")}
    return pack(BUILD / "sinew-legacy-here.zip", legacy_files(module, manual_files()))


def main() -> None:
    as_it_is = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="tools/package", description=__doc__, formatter_class=as_it_is)
    systems = (*wheels.TARGETS, "here")
    parser.add_argument("system", nargs="?", default="linux", choices=systems, help="without one, linux")
    system = parser.parse_args().system
    package_for_this_machine() if system == "here" else package(system)

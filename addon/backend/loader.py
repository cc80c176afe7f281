# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the native module and compare versions.

The zip for Blender before 4.2 holds the unpacked wheel in the folder ``_native`` beside this package. For an
extension, Blender installs the wheel, which can then be imported by its name; on Windows a copy of the module
is imported.
"""

import contextlib
import fnmatch
import importlib
import importlib.util
import platform
import sys
import tempfile
import traceback
import zipfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from ..ids import VERSION

_ROOT = __package__.rpartition(".")[0]
_ADDON = Path(__file__).parent.parent
_UNPACKED, _WHEELS = _ADDON / "_native", _ADDON / "wheels"
_MODULES = {".so", ".pyd"}
_OLD_PROCESSOR = "the processor of this computer lacks"  # what entry.cpp says


@dataclass(frozen=True)
class Availability:
    """The native module; or, in ``remedy``, why it cannot be used and what to do.

    ``details`` is the traceback, for a report. ``is_outdated``: it is that of another version of the add-on.
    """

    module: ModuleType | None
    remedy: str = ""
    details: str = ""
    is_outdated: bool = False


def wheel_name() -> str:
    """The pattern of the file name of the wheel that fits this Blender."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    system = {"Windows": "win", "Darwin": "macosx"}.get(platform.system(), platform.system().lower())
    return f"sinew_native-{VERSION}-{python}-{python}-*{system}*{platform.machine().lower()}*"


def _readable(text: str) -> str:
    """Paths in the messages of the system may be no text in the language that Python assumes there."""
    return text.encode("utf-8", "surrogateescape").decode("utf-8", "replace")


def _fitting_zip() -> str:
    return f"the Sinew zip for this Blender, which holds {wheel_name()}"


def load() -> Availability:
    """Import the module. It raises nothing; ``remedy`` holds the reason if there is no module."""
    name = f"{_ROOT}._native.sinew_native" if _UNPACKED.is_dir() else "sinew_native"
    try:
        module = _imported(name)
    except ModuleNotFoundError:
        return Availability(None, _missing(), _readable(traceback.format_exc()))
    except (ImportError, OSError) as error:
        remedy = (
            "Use another computer; files open here and show their last solution"
            if _OLD_PROCESSOR in str(error)
            else "Restart Blender; if this stays, let your virus scanner allow it, or install "
            + _fitting_zip()
        )
        text = f"The native module does not load ({error}). {remedy}"
        return Availability(None, _readable(text), _readable(traceback.format_exc()))
    found = getattr(module, "__version__", "unknown")
    if found != VERSION:
        return Availability(
            None,
            f"The native module is version {found}, the add-on {VERSION}. "
            "Restart Blender; if this stays, install the zip again",
            is_outdated=True,
        )
    return Availability(module)


def _imported(name: str) -> ModuleType:
    try:
        return _imported_copy(name) or importlib.import_module(name)
    except ModuleNotFoundError:
        if not _unpack_wheel():
            raise
    return _imported_copy(name) or importlib.import_module(name)


def _imported_copy(name: str) -> ModuleType | None:
    """The module from a copy of its file, if it is that of an extension on Windows and not loaded yet.

    Windows lets nobody replace a file that is loaded, so an update by Blender would end with an error.
    """
    if name in sys.modules or platform.system() != "Windows":
        return None
    found = importlib.util.find_spec(name)
    copy = _copied(Path(found.origin)) if found and found.origin else None
    spec = importlib.util.spec_from_file_location(name, copy) if copy else None
    if spec is None or spec.loader is None:
        return None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    sys.modules[name] = module
    return module


def _copied(file: Path) -> Path | None:
    """A copy in the folder that an extension has for its own files; None if there can be none."""
    local = next((folder for folder in file.parents if folder.name == ".local"), None)
    if local is None or not _ROOT.startswith("bl_ext."):
        return None
    folder = local.parent.joinpath(".user", *_ROOT.split(".")[1:], "module")
    try:
        folder.mkdir(parents=True, exist_ok=True)
        content = file.read_bytes()
        copy = folder / f"{file.stem}-{zlib.crc32(content):08x}{file.suffix}"
        if not copy.exists():
            with tempfile.NamedTemporaryFile(dir=folder, delete=False) as fresh:
                fresh.write(content)
            Path(fresh.name).replace(copy)
        for other in folder.iterdir():
            if other != copy:
                with contextlib.suppress(OSError):  # another Blender uses this one
                    other.unlink()
    except OSError:
        return None
    return copy


def _unpack_wheel() -> bool:
    """Unpack the fitting wheel to where Blender unpacks it, and say whether that could be done.

    An update on Windows leaves it out if another program uses the module of the former version.
    """
    python = f"python{sys.version_info.major}.{sys.version_info.minor}"
    folder = _ADDON.parents[1] / ".local" / "lib" / python / "site-packages"
    wheels = [_WHEELS / name for name in _packed() if _is_fitting(name)]
    if not wheels or not folder.is_dir():
        return False
    try:
        with zipfile.ZipFile(wheels[0]) as archive, tempfile.TemporaryDirectory(dir=folder) as fresh:
            archive.extractall(fresh)  # a damaged one ends this before anything is in its place
            for part in Path(fresh).iterdir():
                if not (place := folder / part.name).exists():  # what is there may be loaded: it stays
                    part.replace(place)
    except (OSError, zipfile.BadZipFile, zlib.error):
        return False
    importlib.invalidate_caches()
    return True


def _is_fitting(wheel: str) -> bool:
    return fnmatch.fnmatchcase(wheel.lower(), wheel_name())


def _missing() -> str:
    packed = _packed()
    if any(map(_is_fitting, packed)):
        return (
            f"The native module is missing: Blender has not installed {wheel_name()}, which the zip holds. "
            "Close Blender, and install the zip again"
        )
    held = f": the installed zip holds {' and '.join(packed)}" if packed else ""
    return f"The native module is missing{held}. Install {_fitting_zip()}"


def _packed() -> list[str]:
    """The names of the wheels, or of the modules of an unpacked wheel, that came with the zip."""
    if _UNPACKED.is_dir():
        return sorted(path.name for path in _UNPACKED.iterdir() if path.suffix in _MODULES)
    return sorted(path.name for path in _WHEELS.glob("*.whl"))

# SPDX-License-Identifier: GPL-3.0-or-later
"""Find the native module and compare versions.

The zip for Blender before 4.2 holds the unpacked wheel in the folder ``_native`` beside this package. For an
extension, Blender installs the wheel, which can then be imported by its name.
"""

import importlib
import platform
import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType

from ..ids import VERSION

_ROOT = __package__.rpartition(".")[0]


@dataclass(frozen=True)
class Availability:
    """The native module; or, in ``remedy``, why it cannot be used and what to do."""

    module: ModuleType | None
    remedy: str = ""


def wheel_name() -> str:
    """The pattern of the file name of the wheel that fits this Blender."""
    python = f"cp{sys.version_info.major}{sys.version_info.minor}"
    system = {"Windows": "win", "Darwin": "macosx"}.get(platform.system(), platform.system().lower())
    return f"sinew_native-{VERSION}-{python}-{python}-*{system}*{platform.machine().lower()}*"


def load() -> Availability:
    """Import the module. It raises nothing; ``remedy`` holds the reason if there is no module."""
    bundled = (Path(__file__).parent.parent / "_native").is_dir()
    name = f"{_ROOT}._native.sinew_native" if bundled else "sinew_native"
    try:
        module = importlib.import_module(name)
    except ImportError as error:
        reason = "is missing" if isinstance(error, ModuleNotFoundError) else f"does not load ({error})"
        return Availability(
            None,
            f"The native module {reason}. Install the Sinew zip for this Blender, which holds {wheel_name()}",
        )
    found = getattr(module, "__version__", "unknown")
    if found != VERSION:
        return Availability(
            None,
            f"The native module is version {found}, the add-on {VERSION}. "
            "Restart Blender; if this stays, install the zip again",
        )
    return Availability(module)

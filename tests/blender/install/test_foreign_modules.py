# SPDX-License-Identifier: GPL-3.0-or-later
"""Native modules that this Blender cannot load: the add-on says so, names the wheel that fits, and lives.

The operating system itself refuses each file. What the add-on does then, stands in test_event_files.py.
"""

import importlib.util
import sys
import zipfile
from importlib.machinery import ExtensionFileLoader
from pathlib import Path
from types import ModuleType

import installed
import pytest
from inside import inner, native

OTHER_NAMES = {b"KERNEL32.dll": b"NOLIBR32.dll", b"libm.so.6": b"lib0.so.6"}  # of libraries, of same length


def truncated(folder: Path) -> Path:
    """A download that broke off."""
    file = folder / Path(native().__file__).name
    file.write_bytes(Path(native().__file__).read_bytes()[:40])
    return file


def of_another_system(folder: Path) -> Path:
    """It begins as modules of Linux do; on Linux, as those of Windows."""
    file = folder / "sinew_native.pyd"
    file.write_bytes((b"MZ" if sys.platform == "linux" else b"\x7fELF") + bytes(4096))
    return file


def without_a_library(folder: Path) -> Path:
    """A library that it needs is missing."""
    content = Path(native().__file__).read_bytes()
    for name, other in OTHER_NAMES.items():
        content = content.replace(name, other)
    file = folder / Path(native().__file__).name
    file.write_bytes(content)
    return file


def of_another_python(folder: Path) -> Path:
    """From a wheel for another Python, which an extension keeps beside the one that fits."""
    own = f"-cp{sys.version_info.major}{sys.version_info.minor}-"
    wheels = Path(sys.modules[installed.name()].__file__).parent / "wheels"
    others = [wheel for wheel in sorted(wheels.glob("sinew_native-*.whl")) if own not in wheel.name]
    if not others:
        pytest.skip("this zip holds no other wheel")
    with zipfile.ZipFile(others[0]) as wheel:
        wheel.extractall(folder)
    return next(file for file in folder.iterdir() if file.suffix in (".so", ".pyd"))


@pytest.mark.parametrize(
    "fault",
    [truncated, of_another_system, without_a_library, of_another_python],
    ids=lambda fault: fault.__name__,
)
def test_a_module_that_does_not_load_is_told_with_the_wheel_that_fits(
    fault, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    file, loader = fault(tmp_path), inner.loader

    def foreign(_name: str) -> ModuleType:
        finder = ExtensionFileLoader("sinew_native", str(file))
        return importlib.util.module_from_spec(importlib.util.spec_from_loader("sinew_native", finder))

    with monkeypatch.context() as patch:
        patch.setattr(loader.importlib, "import_module", foreign)
        found = loader.load()
    assert found.module is None
    assert "does not load" in found.remedy
    assert f"cp{sys.version_info.major}{sys.version_info.minor}" in found.remedy
    assert loader.load().module is native()

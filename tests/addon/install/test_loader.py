# SPDX-License-Identifier: GPL-3.0-or-later
"""A native module that cannot be loaded: its reason, its remedy, the name of its wheel, and no exception."""

import fnmatch
import importlib
import platform
import sys
import zipfile
from pathlib import Path

import pytest

from sinew.backend import loader

THIS = f"cp{sys.version_info.major}{sys.version_info.minor}"
WHEELS = {
    ("Linux", "x86_64"): "manylinux_2_34_x86_64",
    ("Windows", "AMD64"): "win_amd64",
    ("Darwin", "arm64"): "macosx_11_0_arm64",
}


@pytest.mark.parametrize("here", WHEELS)
def test_the_name_fits_the_wheel_of_this_system_alone(here: tuple[str, str], monkeypatch: pytest.MonkeyPatch):
    for ask, answer in zip(("system", "machine"), here, strict=True):
        monkeypatch.setattr(platform, ask, lambda answer=answer: answer)
    names = {key: f"sinew_native-{loader.VERSION}-{THIS}-{THIS}-{tag}.whl" for key, tag in WHEELS.items()}
    assert [key for key, name in names.items() if fnmatch.fnmatchcase(name, loader.wheel_name())] == [here]


def refused(monkeypatch: pytest.MonkeyPatch, error: Exception) -> loader.Availability:
    def refuse(_name: str) -> None:
        raise error

    monkeypatch.setattr(loader.importlib, "import_module", refuse)
    found = loader.load()
    assert found.module is None
    assert type(error).__name__ in found.details
    return found


@pytest.mark.parametrize(
    "error",
    [
        ImportError("DLL load failed while importing sinew_native: The specified module could not be found."),
        ImportError("DLL load failed: An Application Control policy has blocked this file."),
        PermissionError(13, "Permission denied", "sinew_native.so"),
        ImportError("/Übung/sinew_native.so: file too short".encode().decode("ascii", "surrogateescape")),
        OSError("[WinError 225] the file contains a virus or potentially unwanted software"),
    ],
    ids=lambda error: str(error)[-14:],
)
def test_a_module_that_does_not_load_names_the_reason_and_what_to_do(monkeypatch, error: Exception):
    remedy = refused(monkeypatch, error).remedy
    assert str(error).encode("utf-8", "surrogateescape").decode() in remedy
    for word in ("does not load", "Restart Blender", "virus scanner", loader.wheel_name()):
        assert word in remedy


def test_nobody_is_told_to_install_something_on_a_processor_that_is_too_old(monkeypatch):
    error = ImportError("the processor of this computer lacks SSE4.2, which Sinew needs")
    remedy = refused(monkeypatch, error).remedy
    assert remedy.startswith(f"The native module does not load ({error}). Use another computer; ")
    assert "nstall" not in remedy


def test_another_version_of_the_module_asks_for_a_restart(backend, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(loader, "VERSION", "99.0.0")
    assert "Restart Blender" in loader.load().remedy


@pytest.mark.parametrize(
    ("folder", "name"),
    [
        ("_UNPACKED", "sinew_native.cp399-win_amd64.pyd"),
        ("_WHEELS", "sinew_native-0.1.0-cp399-cp399-win_amd64.whl"),
    ],
)
def test_a_zip_for_another_system_is_named(monkeypatch, tmp_path: Path, folder: str, name: str):
    for each in ("_UNPACKED", "_WHEELS"):
        monkeypatch.setattr(loader, each, tmp_path / each)
    (tmp_path / folder).mkdir()
    (tmp_path / folder / name).touch()
    remedy = refused(monkeypatch, ModuleNotFoundError("sinew_native")).remedy
    assert f"the installed zip holds {name}." in remedy
    assert remedy.endswith(f"Install the Sinew zip for this Blender, which holds {loader.wheel_name()}")


def test_a_wheel_that_blender_did_not_install_is_unpacked(monkeypatch, tmp_path: Path):
    monkeypatch.setattr(loader, "_ADDON", tmp_path / "repository" / "sinew")
    monkeypatch.setattr(loader, "_WHEELS", tmp_path)
    folder = tmp_path / ".local" / "lib" / f"python3.{sys.version_info.minor}" / "site-packages"
    folder.mkdir(parents=True)
    loaded = folder / "loaded.so"  # by another Blender, which crashes if this is written to
    loaded.write_text("in use")
    monkeypatch.syspath_prepend(str(folder))
    import_module = loader.importlib.import_module
    monkeypatch.setattr(loader.importlib, "import_module", lambda _name: import_module("sinew_late"))
    wheel = tmp_path / f"{loader.wheel_name().replace('*', 'x')}.whl"
    with zipfile.ZipFile(wheel, "w", zipfile.ZIP_DEFLATED) as archive:
        archive.writestr("sinew_late.py", f"__version__ = {loader.VERSION!r}")
        archive.writestr("loaded.so", "another one")
    right = wheel.read_bytes()
    for damaged in (b"damaged", right.replace(right[43:53], bytes([255] * 10))):
        wheel.write_bytes(damaged)
        assert "has not installed" in loader.load().remedy
        assert list(folder.iterdir()) == [loaded]
    wheel.write_bytes(right)
    assert loader.load().module.__version__ == loader.VERSION
    assert loaded.read_text() == "in use"


def test_a_wheel_that_blender_did_not_install_is_named(monkeypatch, tmp_path: Path):
    monkeypatch.setattr(loader, "_WHEELS", tmp_path)
    fitting = loader.wheel_name().replace("*", "x")
    (tmp_path / f"{fitting}.whl").touch()
    (tmp_path / "sinew_native-0.1.0-cp399-cp399-win_amd64.whl").touch()
    remedy = refused(monkeypatch, ModuleNotFoundError("sinew_native")).remedy
    assert all(words in remedy for words in ("has not installed", "install the zip again", THIS))


def test_an_extension_on_windows_leaves_the_installed_file_free(monkeypatch, tmp_path: Path):
    """A copy is loaded, since Windows lets nobody replace what is loaded. The next version has its own."""
    installed = tmp_path / ".local" / "lib" / "site-packages" / "sinew_native.py"
    installed.parent.mkdir(parents=True)
    monkeypatch.syspath_prepend(str(installed.parent))
    monkeypatch.setattr(loader, "_UNPACKED", tmp_path / "none")
    monkeypatch.setattr(loader, "_ROOT", "bl_ext.somewhere.sinew")
    monkeypatch.setattr(platform, "system", lambda: "Windows")

    monkeypatch.setitem(sys.modules, "sinew_native", None)  # so that what is there now comes back

    def loaded(version: str) -> Path:
        installed.write_text(f"__version__ = {version!r}")
        monkeypatch.setattr(loader, "VERSION", version)
        monkeypatch.delitem(sys.modules, "sinew_native", raising=False)
        importlib.invalidate_caches()
        module = loader.load().module
        assert module is sys.modules["sinew_native"] is loader.load().module
        assert module.__version__ == version
        return Path(module.__file__)

    own = tmp_path / ".user"
    own.touch()
    assert loaded("1.0") == installed  # where no copy can be made
    own.unlink()
    for version in ("1.0", "2.0"):
        assert [loaded(version)] == [*own.glob("somewhere/sinew/module/*.*")]

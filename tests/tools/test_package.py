# SPDX-License-Identifier: GPL-3.0-or-later
import tomllib
import zipfile
from pathlib import Path

import pytest
from workshop import package, places

WHEELS = ["sinew_native-0.1.0-cp311-cp311-manylinux_2_34_x86_64.whl", "x-0.1.0-cp313-cp313-win_amd64.whl"]
HEAD = f'id = "sinew"\nversion = "{places.version()}"\n'
TABLE = '[permissions]\nfiles = "Write point caches"\n'


@pytest.mark.parametrize(
    "lines", ["", "wheels = []\n", 'wheels = [\n  "./wheels/old.whl",\n]\nplatforms = ["linux-x64"]\n']
)
def test_manifest_lists_the_packed_wheels(lines: str) -> None:
    stated = tomllib.loads(package.filled_manifest(HEAD + lines + TABLE, WHEELS))
    assert stated["wheels"] == [f"./wheels/{name}" for name in WHEELS]
    assert stated["platforms"] == ["linux-x64", "windows-x64"]
    assert stated["permissions"] == {"files": "Write point caches"}


def test_manifest_of_another_version_is_refused() -> None:
    with pytest.raises(SystemExit, match="version"):
        package.filled_manifest(HEAD.replace(places.version(), "9.9.9"), WHEELS)


def test_wheel_of_an_unknown_platform_is_refused() -> None:
    with pytest.raises(SystemExit, match="riscv"):
        package.filled_manifest(HEAD, ["x-0.1.0-cp311-cp311-riscv64.whl"])


def test_caches_and_hidden_files_stay_out(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    wanted = {"__init__.py", "blender_manifest.toml", "core/methods/__init__.py"}
    unwanted = {"core/__pycache__/methods.pyc", "core/.hidden/a.py", "core/a.blend1", "_native/x.so", "a.pyc"}
    for name in wanted | unwanted:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("")
    monkeypatch.setattr(package, "ADDON", tmp_path)
    assert set(package.addon_files()) == wanted | {"LICENSE"}


def test_the_rigs_to_try_are_small_and_name_their_licences() -> None:
    packed = {name: content for name, content in package.addon_files().items() if name.startswith("rigs/")}
    assert b"CC0" in packed.pop("rigs/README.md")
    sizes = [len(content) for content in packed.values()]
    assert len(sizes) == 5
    assert max(sizes) <= 400_000
    assert sum(sizes) <= 1_200_000


def test_packing_again_leaves_no_moment_without_a_zip(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    """Another command may look for the zips of this checkout at any moment."""
    for name in ("__init__.py", "blender_manifest.toml"):
        (tmp_path / "addon" / name).parent.mkdir(exist_ok=True)
        (tmp_path / "addon" / name).write_text(HEAD if name.endswith("toml") else "")
    (tmp_path / "LICENSE").write_text("")
    for name, folder in {"ROOT": "", "ADDON": "addon", "DIST": "dist"}.items():
        monkeypatch.setattr(package, name, tmp_path / folder)
    wheel = tmp_path / WHEELS[0]
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr("sinew_native.so", b"1")

    def found() -> list[str]:
        return sorted(path.name for path in (tmp_path / "dist").glob("*.zip"))

    old = ["sinew-0.0.1-linux-x64.zip", "sinew-legacy-0.0.1-linux-x64.zip"]
    (tmp_path / "dist").mkdir()
    for name in (*old, "sinew-0.0.1-windows-x64.zip"):
        (tmp_path / "dist" / name).write_bytes(b"")
    seen = []
    write = package.write_zip
    monkeypatch.setattr(package, "write_zip", lambda *words: (seen.append(found()), write(*words)))
    new = sorted(path.name for path in package.zips([wheel], {}))
    assert new == [name.replace("0.0.1", places.version()) for name in old]
    assert found() == sorted([*new, "sinew-0.0.1-windows-x64.zip"])
    assert [path.name for path in package.zips([wheel], {})] == new
    assert [set(old) <= set(names) for names in seen[:2]] == [True, True]
    assert [set(new) <= set(names) for names in seen[2:]] == [True, True]


def test_legacy_zip_holds_the_unpacked_wheel_inside_the_addon(tmp_path: Path, monkeypatch):
    for name in ("__init__.py", "blender_manifest.toml"):
        (tmp_path / name).write_text("")
    wheel = {"sinew_native.so": b"1", "sinew_native.libs/libx.so": b"2"}
    monkeypatch.setattr(package, "ADDON", tmp_path)
    files = package.legacy_files(wheel, {"manual/index.html": b"3"})
    assert files["sinew/_native/sinew_native.so"] == b"1"
    assert files["sinew/_native/sinew_native.libs/libx.so"] == b"2"
    assert files["sinew/manual/index.html"] == b"3"
    assert b'"""' in files["sinew/_native/__init__.py"]
    assert all(name.startswith("sinew/") for name in files)

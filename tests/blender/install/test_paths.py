# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes in folders as artists have them: with letters of all languages, on other drives, read-only."""

import os
from pathlib import Path

import bpy
import pytest
from baking import CACHES, TARGETS, assert_same, bake, footprint, played
from rigs.rig import Rig, fails, load, make_active, save

FOLDERS = ("My shots (1)", "Jürgen Müller", "日本語 Ёлка", "it's & 100%")
OUTPUT = os.environ.get("SINEW_TEST_OUTPUT", "")


@pytest.fixture(params=FOLDERS)
def named(request: pytest.FixtureRequest, moving: Rig, tmp_path: Path) -> Path:
    """A bending plate, saved in such a folder under such a name."""
    folder = tmp_path / request.param
    folder.mkdir()
    save(folder / f"{request.param}.blend")
    return folder


@pytest.fixture
def read_only(tmp_path: Path) -> Path:
    """A folder in which this process cannot make a file; an administrator can in most."""
    folder = tmp_path / "read-only"
    folder.mkdir()
    folder.chmod(0o555)
    for each in (folder, Path("/sys"), Path("Z:/sys")):
        try:
            (each / "probe").open("wb").close()
        except OSError:
            if each.is_dir():
                return each
    return pytest.skip("this user may write everywhere")


@pytest.mark.parametrize("target", TARGETS)
def test_a_bake_in_a_folder_of_any_name_plays_before_and_after_loading(moving: Rig, named: Path, target: str):
    live = played(moving.obj)
    bake(moving, target)
    assert_same(played(moving.obj), live)
    save(bpy.data.filepath)
    load(bpy.data.filepath)
    assert_same(played(moving.obj), live)
    assert "Baked frames 1-8" in moving.deformer.status
    assert len(list(named.rglob(f"*.{target.lower()}"))) == (target != "SHAPE_KEYS")


@pytest.mark.parametrize("target", CACHES)
def test_a_chosen_path_beside_the_file_has_the_slashes_of_every_system(
    saved: Rig, tmp_path: Path, target: str, recwarn: pytest.WarningsRecorder
) -> None:
    name = f"plate.{target.lower()}"
    for chosen in (tmp_path / "shot" / "Große Cäche" / name, f"//Große Cäche{os.sep}{name}"):
        bake(saved, target, chosen)
        stored = {
            saved.deformer.bake.filepath,
            *(mod.filepath for mod in saved.obj.modifiers if mod.type != "NODES"),
        }
        assert stored == {f"//Große Cäche/{name}"}
        assert (tmp_path / "shot" / "Große Cäche" / name).is_file()
        bpy.ops.sinew.unbake()
    assert not recwarn.list


def test_a_path_by_another_way_to_the_folder_of_the_file_is_relative_to_it(moving: Rig, tmp_path: Path):
    (tmp_path / "real").mkdir()
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "real", target_is_directory=True)
    if not link.is_symlink():
        pytest.skip("Wine shows its links to nobody")
    save(link / "scene.blend")
    live = played(moving.obj)
    bake(moving, "PC2", tmp_path / "real" / "plate.pc2")
    assert moving.deformer.bake.filepath == "//plate.pc2"
    assert_same(played(moving.obj), live)


@pytest.mark.skipif(os.name != "nt", reason="other systems have no drives")
def test_a_bake_on_another_drive_keeps_its_letter(saved: Rig, tmp_path: Path) -> None:
    other = Path(OUTPUT) / "other drive"
    if not OUTPUT or other.drive == tmp_path.drive:
        pytest.skip("this machine has one drive")
    live = played(saved.obj)
    bake(saved, "PC2", other / "plate.pc2")
    assert Path(saved.deformer.bake.filepath) == other / "plate.pc2"
    save(bpy.data.filepath)
    load(bpy.data.filepath)
    assert_same(played(saved.obj), live)
    assert saved.deformer.status_level == "INFO", saved.deformer.status
    make_active(saved.obj)
    with pytest.raises(RuntimeError, match="outside"):  # the path comes from the file now
        bpy.ops.sinew.bake(target="PC2")


@pytest.mark.parametrize("target", CACHES)
def test_a_read_only_folder_is_reported(saved: Rig, tmp_path: Path, read_only: Path, target: str) -> None:
    before, files = footprint(saved), set(tmp_path.rglob("*"))
    fails(r"Cannot write .*choose another folder", bake, saved, target, read_only / "plate")
    assert footprint(saved) == before
    assert set(tmp_path.rglob("*")) == files


def test_a_read_only_file_is_replaced_or_reported(saved: Rig, tmp_path: Path) -> None:
    """Unix replaces it, since the folder is writable; Windows does not."""
    path, before = tmp_path / "plate.pc2", footprint(saved)
    path.write_text("older")
    path.chmod(0o444)
    live = played(saved.obj)
    try:
        bake(saved, "PC2", path)
    except RuntimeError as error:
        assert "Cannot write" in str(error)  # noqa: PT017
        assert path.read_text() == "older"
        assert footprint(saved) == before
    else:
        assert_same(played(saved.obj), live)
    finally:
        path.chmod(0o666)
    assert not list(tmp_path.rglob("*.part*"))

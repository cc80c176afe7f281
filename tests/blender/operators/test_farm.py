# SPDX-License-Identifier: GPL-3.0-or-later
"""Chunks of any processes are one bake to the last bit; what is in the way has a status and a sentence."""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import bpy
import numpy as np
import pytest
from baking import CACHES, animate, assert_same, bake, played
from inside import inner, room
from libraries import add_collection, override, put_into_a_library, read
from rigs.rig import Rig, add_armature, curves_of, key, linked, load, new_file, press, save
from second_blender import is_executable

NAME = "../Bo/dy"  # no name of an object leads out of the folder
ORDER = ("8,2,5", "7,1,3-4,6")  # what two processes bake of the frames 1 to 8
Run = Callable[..., list[dict]]


@pytest.fixture
def shot(tmp_path: Path, scene: bpy.types.Scene) -> Path:
    """A plate below an armature, with three deformers whose controls jump from frame to frame, in a file."""
    plate = Rig.plate()
    plate.obj.name = plate.name = NAME
    bone = add_armature(plate.obj).pose.bones["high"]
    for number, method in enumerate(("thin_shell", "arap", "primo")):
        plate.bind(method)
        animate(plate.control, angle=80.0 - 20.0 * number)
        key(plate.control, {4: {"location": (0.3, -0.4, 0.1 * number)}, 5: {"location": (-0.1, 0.2, 0.7)}})
        for curve in curves_of(plate.control):
            for point in curve.keyframe_points[number:]:
                point.interpolation = "CONSTANT"
    key(bone, {1: {"rotation_euler": (0.0, 0.0, 0.0)}, 6: {"rotation_euler": (0.7, 0.1, 0.0)}})
    plate.obj.sinew.active_deformer = 2
    (tmp_path / "shot").mkdir()
    return Path(save(tmp_path / "shot" / "shot.blend"))


@pytest.fixture
def out(tmp_path: Path) -> Path:
    return tmp_path / "out"


def words(action: str, where: Path, out: Path, *further: object, **given: str) -> list[str]:
    """Those that every bake and every join needs, and further ones."""
    needed = {"frames": "1-8", "objects": NAME} | given
    named = [word for name, value in needed.items() for word in (f"--{name}", value)]
    return [str(word) for word in (action, where, "--out", out, *named, *further)]


def start(given: list[str], program: Path | None = None) -> subprocess.Popen:
    """The atom in another Blender."""
    command = str(program or Path(inner.atom.__file__).with_name("command.py"))
    blender = [bpy.app.binary_path, "-b", "--factory-startup", "-P", command, "--"]
    started = [*(blender if is_executable() else [sys.executable, command]), *given]
    return subprocess.Popen(started, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)


def told(said: str, status: int) -> list[dict]:
    """The lines of progress, and the status at last."""
    assert "Traceback" not in said, said
    lines = [json.loads(line) for line in said.splitlines() if line.startswith('{"sinew":')]
    assert status in (0, lines[-1].get("code")), said
    return [*lines, {"sinew": "status", "code": status}]


def ended(process: subprocess.Popen) -> list[dict]:
    return told(process.communicate(timeout=120)[0], process.returncode)


@pytest.fixture
def run(capfd: pytest.CaptureFixture) -> Run:
    """The atom in this Blender: what it tells."""

    def run(*given: object, **named: str) -> list[dict]:
        capfd.readouterr()
        action, *further = words(*given, **named)
        status = inner.atom.run(action, further)
        return told(capfd.readouterr().out, status)

    return run


def check_refusal(lines: list[dict], wanted: int, *words: str) -> None:
    *_before, error, status = lines
    assert (status["code"], [word for word in words if word not in error["message"]]) == (wanted, []), error


def left(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*") if not path.is_dir())


def skipped(lines: list[dict]) -> list[bool]:
    return [line["skipped"] for line in lines if line["sinew"] == "chunk"]


def test_chunks_of_other_processes_in_any_order_are_one_bake(shot: Path, out: Path, run: Run):
    """Deformers of three methods after an armature, on controls that ride, with keys that jump."""
    for process in [start(words("bake", shot, out, frames=frames)) for frames in ORDER]:
        assert ended(process)[-1]["code"] == 0
    for target in CACHES:
        one, joined = (out / f"{name}.{target.lower()}" for name in ("one", "joined"))
        bake(Rig.called(NAME), target, one)
        bpy.ops.sinew.unbake()
        assert run("join", out, joined, "--format", target.lower())[-1]["code"] == 0
        assert joined.read_bytes() == one.read_bytes()
    live = played(Rig.called(NAME).obj)
    if bpy.app.build_options.alembic:
        assert run("join", out, out, "--format", "alembic")[-1]["code"] == 0
        new_file()
        bpy.ops.wm.alembic_import(filepath=str(next(out.glob("*.abc"))), as_background_job=False)
        assert_same(played(next(obj for obj in bpy.data.objects if obj.type == "MESH")), live)
    assert not [name for name in left(out.parent) if ".part" in name]


def test_a_join_to_shape_keys_is_the_bake_to_shape_keys(saved: Rig, out: Path, run: Run):
    shot, live, how = bpy.data.filepath, played(saved.obj), ("--format", "shape_keys")
    assert run("bake", shot, out, "--chunk", 3, *how, objects="Plate")[-1]["code"] == 0
    assert run("join", out, out, *how, objects="Plate")[-1]["code"] == 0
    new_file()
    obj = linked(read(out / "Plate.blend", False, "objects", "Plate"))
    assert [block.name for block in obj.data.shape_keys.key_blocks][2:] == [f"Sheet {n}" for n in range(1, 9)]
    assert_same(played(obj), live)


def test_a_killed_process_leaves_no_half_chunk(shot: Path, out: Path, run: Run):
    assert run("bake", shot, out, frames="1-2")[-1]["code"] == 0
    whole = left(out)
    process = start(words("bake", shot, out, frames="5-8"))
    next(line for line in process.stdout if '"frame": 6' in line)
    process.kill()
    process.communicate()
    assert [name for name in left(out) if ".part" not in name] == whole != left(out)
    again = run("bake", shot, out, frames="1-2,3-4,5-8")
    assert skipped(again) == [True, False, False]
    assert [line["frame"] for line in again if line["sinew"] == "frame"] == [3, 4, 5, 6, 7, 8]
    assert len(left(out)) == 6
    save(shot)  # another file
    assert skipped(run("bake", shot, out, frames="1-2")) == [False]


@pytest.mark.usefixtures("preferences")
def test_a_full_disk_and_little_memory(shot: Path, out: Path, run: Run, monkeypatch: pytest.MonkeyPatch):
    """A limit is that of the process, and of what a bind will take, which the library knows before."""
    check_refusal(run("bake", shot, out, "--memory", 0.001), 4, "--memory")
    monkeypatch.setattr(inner.shot, "require_memory", lambda _gigabytes: None)
    check_refusal(run("bake", shot, out, "--memory", 0.001), 4, "memory")
    resource = pytest.importorskip("resource")
    limit, most = resource.RLIMIT_FSIZE, resource.getrlimit(resource.RLIMIT_FSIZE)[1]
    resource.setrlimit(limit, (8192, most))
    lines = run("bake", shot, out)
    resource.setrlimit(limit, (most, most))
    check_refusal(lines, 4, "Cannot write")
    assert (left(shot.parent), out.exists()) == ([shot.name], False)


def test_chunks_of_other_processors_are_refused_by_their_names(shot: Path, out: Path, run: Run):
    run("bake", shot, out, "--chunk", 4)
    one, other = sorted((out / "chunks").glob("*.pc2"))
    joined, said = out / "joined.pc2", other.with_suffix(".json")
    content, manifest = other.read_bytes(), said.read_text()
    for name, value in (("kernels", "sse4.2"), ("sinew", "0.0.1"), ("shot", "0" * 64), ("blender", "2.7")):
        said.write_text(json.dumps({**json.loads(manifest), name: value}))
        check_refusal(run("join", out, joined), 5, str(one), str(other), value, "--mixed")
        assert not joined.exists()
        assert run("join", out, joined, "--mixed")[-1]["code"] == 0
        joined.unlink()
    said.write_text(manifest)
    for damaged in (content[:-4], content[:-4] + b"\0\0\0\0"):
        other.write_bytes(damaged)
        check_refusal(run("join", out, joined, "--mixed"), 5, "frame 5, 6, 7, 8")


# What is wrong: an edit of the shot, or words; the status; and what the sentence says.
WRONG = {
    "unbound": (lambda obj: press(obj, "unbind"), 3, "press Bind"),
    "off": (lambda obj: setattr(obj.modifiers["Sinew"], "show_viewport", False), 3, "switch its modifier on"),
    "not live": (lambda obj: setattr(obj.sinew.deformers[0], "live", False), 3, "switch Live on"),
    "no object": ({"objects": "Nobody"}, 3, "Nobody is not in the shot"),
    "no deformer": ({"objects": "Rig"}, 3, "Rig has no deformer"),
    "step of Alembic": ({"format": "alembic", "frames": "1-8x2"}, 3, "Alembic"),
    "keys after others": ({"format": "shape_keys"}, 3, "shape keys"),
    "code": ({"wedge": "sinew.deformers[0].__class__=1"}, 3, "__class__"),
    "a function": ({"wedge": "sinew.deformers[0].rest_in=1"}, 3, "no property"),
    "another object": ({"wedge": "sinew.deformers[0].handles[0].control.location[0]=1"}, 3, "another"),
    "out of range": ({"wedge": "sinew.deformers[0].factor=7"}, 3, "cannot be 7"),
    "no range": ({"frames": "5-1"}, 2, "'5-1'"),
}


@pytest.mark.parametrize("wrong", WRONG)
def test_what_is_wrong_with_a_shot_or_its_words_is_said(shot: Path, out: Path, run: Run, wrong: str):
    what, wanted, sentence = WRONG[wrong]
    if callable(what):
        what(bpy.data.objects[NAME])
        save(shot)
    given = {} if callable(what) else what
    check_refusal(run("bake", shot, out, **given), wanted, sentence)
    assert not out.exists()


def test_no_shot_no_add_on_no_module(shot: Path, out: Path, run: Run, monkeypatch: pytest.MonkeyPatch):
    garbage, alone = shot.with_name("garbage.blend"), shot.with_name("command.py")
    garbage.write_bytes(b"BLENDER-v402" + bytes(4000))
    for path in (garbage, garbage.with_name("none.blend"), garbage.parent, "\0"):
        check_refusal(run("bake", path, out), 3)
    alone.write_bytes(Path(inner.atom.__file__).with_name("command.py").read_bytes())
    check_refusal(ended(start(words("bake", shot, out), program=alone)), 3, "not installed")
    assert len(room("farm").registered) == 2 * hasattr(bpy.utils, "register_cli_command")
    missing = inner.loader.Availability(None, "The native module is missing")
    monkeypatch.setattr(inner.shot, "availability", lambda: missing)
    check_refusal(run("bake", shot, out), 3, missing.remedy)
    assert not out.exists()


def test_links_lead_nowhere_and_linked_objects_need_overrides(moving: Rig, out: Path, run: Run):
    elsewhere, shot = out.with_name("elsewhere"), out.with_name("shot.blend")
    elsewhere.mkdir()
    out.mkdir()
    library = put_into_a_library(out.with_name("library.blend"), moving.obj, moving.control)
    add_collection(library, link=True)
    save(shot)
    check_refusal(run("bake", shot, out, objects="Plate"), 3, "library override")
    new_file()
    override(library)
    save(shot)
    (out / "chunks").symlink_to(elsewhere, target_is_directory=True)
    if (out / "chunks").is_symlink():
        check_refusal(run("bake", shot, out, objects="Plate"), 3, "leads outside")
        (out / "chunks").unlink()
    assert run("bake", shot, out, objects="Plate")[-1]["code"] == 0
    assert left(elsewhere) == [] != left(out) == ["Plate.1-8.json", "Plate.1-8.pc2"]
    Path(library).unlink()
    check_refusal(run("bake", shot, out, objects="Plate", frames="3"), 3, "library.blend that the shot links")


def test_a_wedge_has_a_folder_for_each_value_and_one_picture(shot: Path, out: Path, run: Run):
    """A folder holds what a bake of a shot with that value does, to the last bit."""
    factors, how = (0.25, 1.0), ("--wedge", "sinew.deformers[2].factor=0.25,1.0")
    assert run("bake", shot, out, *how, frames="7-8")[-1]["code"] == 0
    pictures = [bpy.data.images.load(str(out / f"factor={factor}" / "render.png")) for factor in factors]
    one, other = (np.array(picture.pixels[:]) for picture in pictures)
    assert np.abs(one - other).mean() > 0.001
    sheet = bpy.data.images.load(str(out / "contact-sheet.png"))
    high, wide = sheet.size[1], pictures[0].size[0]
    below = np.array(sheet.pixels[:]).reshape(high, 2, wide, sheet.channels)[: high // 5, ..., 0]
    assert (below.max(axis=(0, 2)) > 0.9).all()  # the values, in white
    assert skipped(run("bake", shot, out, *how, frames="7-8")) == [True, True]
    for factor in factors:
        load(shot)
        plate = Rig.called(NAME)
        plate.obj.sinew.deformers[2].factor = factor
        bake(plate, "PC2", out / "one.pc2", frame_start=7, frame_end=8)
        (chunk,) = (out / f"factor={factor}").rglob("*.pc2")
        assert chunk.read_bytes() == (out / "one.pc2").read_bytes()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Chunks that other processes bake, in any order, are one bake to the last bit. Whatever is in the way of a
farm ends with a status and a sentence, and nothing is half-written."""

import json
import subprocess
import sys
from pathlib import Path

import bpy
import pytest
from baking import animate, bake
from inside import inner
from rigs.rig import Rig, add_armature, curves_of, key, save
from second_blender import is_executable

NAME = "../Bo/dy"  # no name of an object leads out of the folder
FRAMES, ORDERS = range(1, 9), (("7-8,1-3", "4-6"), ("8,2,5", "7,1,3-4,6"))
METHODS = ("thin_shell", "arap", "primo")


def make_shot(folder: Path) -> Path:
    """A plate below an armature, with three deformers whose controls jump from frame to frame, in a file."""
    plate = Rig.plate()
    plate.obj.name = plate.name = NAME
    bone = add_armature(plate.obj).pose.bones["high"]
    for number, method in enumerate(METHODS):
        plate.bind(method)
        animate(plate.control, angle=80.0 - 20.0 * number)
        key(plate.control, {4: {"location": (0.3, -0.4, 0.1 * number)}, 5: {"location": (-0.1, 0.2, 0.7)}})
        for curve in curves_of(plate.control):
            for point in curve.keyframe_points[number:]:
                point.interpolation = "CONSTANT"
    key(bone, {1: {"rotation_euler": (0.0, 0.0, 0.0)}, 6: {"rotation_euler": (0.7, 0.1, 0.0)}})
    plate.obj.sinew.active_deformer = len(METHODS) - 1
    (folder / "shot").mkdir()
    return Path(save(folder / "shot" / "shot.blend"))


@pytest.fixture
def shot(tmp_path: Path, scene: bpy.types.Scene) -> Path:
    return make_shot(tmp_path)


def words(
    action: str, where: Path, out: Path, *further: object, frames: str = "1-8", name: str = NAME
) -> list:
    return [action, where, "--frames", frames, "--objects", name, "--out", out, *further]


def start(*told: object, **how: object) -> subprocess.Popen:
    """The atom in another Blender."""
    command = Path(inner.atom.__file__).with_name("command.py")
    blender = [bpy.app.binary_path, "-b", "--factory-startup", "-P", command, "--"]
    started = [*(blender if is_executable() else [sys.executable, command]), *told]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    return subprocess.Popen([str(word) for word in started], **pipes, **how)


def ended(process: subprocess.Popen) -> list[dict]:
    """What a process told until its end, and its status at last."""
    said, _nothing = process.communicate(timeout=120)
    assert "Traceback" not in said, said
    told = [json.loads(line) for line in said.splitlines() if line.startswith('{"sinew":')]
    return [*told, {"sinew": "status", "code": process.returncode}]


def run(capfd: pytest.CaptureFixture, *told: object) -> list[dict]:
    """The same in this Blender."""
    capfd.readouterr()
    code = inner.atom.run(told[0], [str(word) for word in told[1:]])
    said = capfd.readouterr().out
    assert "Traceback" not in said
    lines = [json.loads(line) for line in said.splitlines() if line.startswith('{"sinew":')]
    return [*lines, {"sinew": "status", "code": code}]


def left(folder: Path) -> list[str]:
    return sorted(path.name for path in folder.rglob("*") if not path.is_dir()) if folder.exists() else []


def skipped(told: list[dict]) -> list[bool]:
    return [line["skipped"] for line in told if line["sinew"] == "chunk"]


@pytest.mark.parametrize("order", ORDERS, ids=" ".join)
def test_chunks_of_other_processes_in_any_order_are_one_bake(
    shot: Path, tmp_path: Path, capfd: pytest.CaptureFixture, order: tuple[str, ...]
):
    """Deformers of three methods after an armature, on controls that ride, with keys that jump."""
    out = tmp_path / "out"
    for process in [start(*words("bake", shot, out, frames=frames)) for frames in order]:
        assert ended(process)[-1]["code"] == 0
    plate = Rig.called(NAME)
    for target in ("PC2", "MDD"):
        bake(plate, target, tmp_path / f"one.{target.lower()}")
        bpy.ops.sinew.unbake()
        joined = tmp_path / f"joined.{target.lower()}"
        assert run(capfd, *words("join", out, joined, "--format", target.lower()))[-1]["code"] == 0
        assert joined.read_bytes() == (tmp_path / f"one.{target.lower()}").read_bytes()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Files that one system saved open on another, show the same shapes, and go on there.

Each run leaves its files in the folder ``files`` of ``SINEW_TEST_OUTPUT``.
``SINEW_FILES_OF_ANOTHER_SYSTEM`` is such a folder that a Blender of another system left.
"""

import os
import shutil
from pathlib import Path

import bpy
import numpy as np
import pytest
from baking import CACHES, FRAMES, bake, played
from registry import METHODS
from rigs.kinds import BY_CONTROL, HandleRig, rig_for
from rigs.rig import Rig, load, save

LEFT = Path(os.environ.get("SINEW_TEST_OUTPUT") or bpy.app.tempdir) / "files"
GIVEN = os.environ.get("SINEW_FILES_OF_ANOTHER_SYSTEM", "")
SAME = 1e-6  # in shapes of size 2, which Blender stores in single precision
from_another = pytest.mark.skipif(not GIVEN, reason="another system has to leave its files first")
every_method = pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)


@pytest.fixture
def given(tmp_path: Path) -> Path:
    """A copy of the files of the other system."""
    return Path(shutil.copytree(GIVEN, tmp_path / "given", copy_function=shutil.copyfile))


def shapes(rig: HandleRig) -> list[np.ndarray]:
    """As it is, and with its control lifted further, in two steps."""
    found = [rig.points()]
    for _ in range(2):
        rig.lift(0.2)
        found.append(rig.points())
    return found


@every_method
def test_a_rig_for_another_system(method) -> None:
    LEFT.mkdir(parents=True, exist_ok=True)
    rig = rig_for(method.id)
    rig.start(method.id).lift(0.5)
    assert rig.deformer.status_level == "INFO", rig.deformer.status
    save(LEFT / f"{method.id}.blend", copy=True)
    np.savez(LEFT / f"{method.id}.npz", *shapes(rig), name=rig.name)


@from_another
@every_method
def test_a_rig_of_another_system_has_the_same_shapes(method, given: Path) -> None:
    with np.load(given / f"{method.id}.npz") as stored:
        name = str(stored["name"])
        expected = [stored[key] for key in stored if key != "name"]
    load(given / f"{method.id}.blend")
    rig = BY_CONTROL[method.control].called(name)
    assert rig.deformer.status_level == "INFO", rig.deformer.status
    found = shapes(rig)
    differences = [float(np.abs(a - b).max()) for a, b in zip(found, expected, strict=True)]
    print(f"{method.id}: " + ", ".join(f"{difference:.1e}" for difference in differences))
    assert max(differences) < SAME, differences


@pytest.mark.parametrize("target", CACHES)
def test_a_bake_for_another_system(moving: Rig, target: str) -> None:
    LEFT.mkdir(parents=True, exist_ok=True)
    save(LEFT / f"{target}.blend")
    bake(moving, target, LEFT / "cache" / f"plate.{target.lower()}")
    np.savez(LEFT / f"{target}.npz", *played(moving.obj).values())
    save(LEFT / f"{target}.blend")


@from_another
@pytest.mark.parametrize("target", CACHES)
def test_a_bake_of_another_system_plays_to_the_last_bit(target: str, given: Path) -> None:
    load(given / f"{target}.blend")
    plate = Rig.called("Plate")
    assert plate.deformer.status_level == "INFO", plate.deformer.status
    with np.load(given / f"{target}.npz") as stored:
        for frame, points in zip(FRAMES, [stored[key] for key in stored], strict=True):
            assert np.array_equal(played(plate.obj, [frame])[frame], points)

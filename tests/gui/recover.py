# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens the autosave that ``session_threads.py`` left, and compares it with a plate made anew."""

import json
import sys
from pathlib import Path

import bpy
import numpy as np
from installed import enable
from mathutils import Vector

AUTOSAVE, ANSWER = sys.argv[sys.argv.index("--") + 1 :]

enable()

from expected import Expected  # noqa: E402 - needs the add-on
from rigs.rig import Rig, evaluated_points, grid_object  # noqa: E402

bpy.ops.wm.recover_auto_save(filepath=AUTOSAVE)
plate = Rig.called("Plate")
height = plate.control.location.z
shown = evaluated_points(plate.obj)
plate.lift(0.25)
later = evaluated_points(plate.obj)

fresh = Rig(grid_object("Fresh", cells=24)).bind("thin_shell")
expected = Expected.of_rig(fresh)
moved = np.eye(4)
moved[:3, 3] = plate.obj.matrix_world.to_3x3().inverted() @ Vector((0.0, 0.0, 0.25))
moved[2, 3] += height
found = {
    "height": height,
    "error": float(np.abs(shown - expected.lifted(height)).max()),
    "later_error": float(np.abs(later - expected.shape(moved)).max()),
}
Path(ANSWER).write_text(json.dumps(found), encoding="utf-8")

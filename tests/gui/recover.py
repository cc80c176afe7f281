# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens the autosave that ``session_threads.py`` left, and compares it with a plate made anew."""

import json
import os
import sys
from pathlib import Path

import addon_utils
import bpy
import numpy as np

AUTOSAVE, ANSWER = sys.argv[sys.argv.index("--") + 1 :]

addon_utils.enable(os.environ.get("SINEW_ADDON_MODULE", "sinew"), default_set=True)

from expected import Expected  # noqa: E402 - needs the add-on
from rigs.rig import Rig, evaluated_points, grid_object, move_world  # noqa: E402

bpy.ops.wm.recover_auto_save(filepath=AUTOSAVE)
plate = bpy.data.objects["Plate"]
control = plate.sinew.deformers[0].handles[0].control
height = control.location.z
shown = evaluated_points(plate)
move_world(control, plate.matrix_world.__class__.Translation((0.0, 0.0, 0.25)))
later = evaluated_points(plate)

fresh = Rig(grid_object("Fresh", cells=24)).bind("thin_shell")
expected = Expected.of_rig(fresh)
rise = plate.matrix_world.to_3x3().inverted() @ plate.location.__class__((0.0, 0.0, 0.25))
moved = np.eye(4)
moved[:3, 3] = np.array(rise) + (0.0, 0.0, height)
found = {
    "height": height,
    "error": float(np.abs(shown - expected.lifted(height)).max()),
    "later_error": float(np.abs(later - expected.shape(moved)).max()),
}
Path(ANSWER).write_text(json.dumps(found), encoding="utf-8")

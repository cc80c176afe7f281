# SPDX-License-Identifier: GPL-3.0-or-later
"""In a Blender with Sinew: ``make_shot.py FILE SIDE`` saves a sheet of SIDE x SIDE vertices with three deformers."""

import sys

import bpy

# isort: split
import addon_utils  # comes with bpy, not before it

*_, FILE, SIDE = sys.argv
ROWS = int(SIDE)

bpy.ops.wm.read_factory_settings(use_empty=True)
addon_utils.enable("bl_ext.user_default.sinew")
bpy.ops.mesh.primitive_grid_add(x_subdivisions=ROWS - 1, y_subdivisions=ROWS - 1)
body = bpy.context.object
body.name = "Body"
body.vertex_groups.new(name="Low").add(list(range(4 * ROWS)), 1.0, "REPLACE")
body.vertex_groups.new(name="High").add(list(range(ROWS * (ROWS - 4), ROWS * ROWS)), 1.0, "REPLACE")
for number, method in enumerate(("thin_shell", "arap", "laplacian_editing")):
    bpy.ops.sinew.deformer_add(method=method)
    for kind, group in (("FIXED", "Low"), ("HANDLE", "High")):
        bpy.ops.sinew.handle_add(kind=kind, vertex_group=group)
    control = body.sinew.deformers[number].handles[-1].control
    for frame in (1, 80, 160, 240):
        control.location.z = 0.4 * ((frame // 80 + number) % 3)
        control.keyframe_insert("location", frame=frame)
    bpy.context.view_layer.objects.active = body
bpy.ops.wm.save_as_mainfile(filepath=FILE)

# SPDX-License-Identifier: GPL-3.0-or-later
"""In a Blender with Sinew: ``make_shot.py FILE SIDE [SOLVER]`` saves a sheet of vertices that moves.

Three deformers move the sheet, or a thin shell with a solver of its own.
"""

import sys

import bpy

file, side, solver = sys.argv[1], int(sys.argv[2]), sys.argv[3:]
METHODS = ("thin_shell",) if solver else ("thin_shell", "arap", "laplacian_editing")
bpy.ops.preferences.addon_enable(module="bl_ext.user_default.sinew")
bpy.ops.mesh.primitive_grid_add(x_subdivisions=side - 1, y_subdivisions=side - 1)
body = bpy.context.object
body.name = "Body"
for number, method in enumerate(METHODS):
    bpy.ops.sinew.deformer_add(method=method)
    if solver:
        body.sinew.deformers[number].parameters.solver = solver[0]
    for kind, first in (("FIXED", 0), ("HANDLE", side * (side - 4))):
        group = body.vertex_groups.new(name=kind)
        group.add(range(first, first + 4 * side), 1.0, "REPLACE")
        bpy.ops.sinew.handle_add(kind=kind, vertex_group=group.name)
    control = body.sinew.deformers[number].handles[-1].control
    for frame in (1, 80, 160, 240):
        control.location.z = 0.4 * ((frame // 80 + number) % 3)
        control.keyframe_insert("location", frame=frame)
    bpy.context.view_layer.objects.active = body
bpy.ops.wm.save_as_mainfile(filepath=file)

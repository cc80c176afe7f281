# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside Blender: installs the add-on's zip as a person would, enables it, and keeps that choice."""

import os

import bpy

bpy.ops.preferences.addon_install(filepath=os.environ["SINEW_ZIP"], overwrite=True)
bpy.ops.preferences.addon_enable(module="sinew")
bpy.ops.wm.save_userpref()
if "sinew" not in bpy.context.preferences.addons:
    raise SystemExit("Sinew was installed but could not be enabled")

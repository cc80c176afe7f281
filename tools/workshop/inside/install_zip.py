# SPDX-License-Identifier: GPL-3.0-or-later
"""Installs one of the two zips in the Blender that runs this, in the user folder that its environment names.

Then it loads the native module through the add-on, and lets Blender quit as it does for an artist.
"""

import importlib
import os
import sys

import bpy


def install(zip_file):
    if hasattr(bpy.ops, "extensions") and hasattr(bpy.app, "online_access"):
        bpy.ops.extensions.package_install_files(
            filepath=zip_file, repo="user_default", enable_on_install=True, overwrite=True
        )
    else:
        bpy.ops.preferences.addon_install(filepath=zip_file, overwrite=True)
        bpy.ops.preferences.addon_enable(module=os.environ["SINEW_ADDON_MODULE"])
    name = os.environ["SINEW_ADDON_MODULE"]
    if name not in bpy.context.preferences.addons:
        raise SystemExit(f"{zip_file} was installed, but its add-on could not be enabled")
    native = importlib.import_module(f"{name}.backend").availability()
    if native.module is None:
        raise SystemExit(f"{zip_file} was installed, but: {native.remedy}")
    print(f"{zip_file} was installed, and its native module works")


install(os.path.abspath(sys.argv[sys.argv.index("--") + 1]))
sys.stdout.flush()
sys.stderr.flush()
if not bpy.app.binary_path:
    os._exit(0)  # Blender as a module may hang or crash while it ends

# SPDX-License-Identifier: GPL-3.0-or-later
"""The commands ``sinew_bake`` and ``sinew_join`` of Blender's command line."""

from functools import partial

import bpy

from . import atom

registered: list[object] = []  # Blender forgets a command when its handle is deleted


def register() -> None:
    """Blender has commands since 4.2; older releases run ``command.py``."""
    if hasattr(bpy.utils, "register_cli_command"):
        for word in atom.ACTIONS:
            registered.append(bpy.utils.register_cli_command(f"sinew_{word}", partial(atom.run, word)))


def unregister() -> None:
    for command in registered:
        bpy.utils.unregister_cli_command(command)
    registered.clear()

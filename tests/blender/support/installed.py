# SPDX-License-Identifier: GPL-3.0-or-later
"""The installed add-on, under the name that this Blender gives it."""

import functools
import os
import sys

import bpy  # noqa: F401

# isort: split
import addon_utils  # comes with bpy, not before it

CANDIDATES = ("bl_ext.user_default.sinew", "sinew")


def enable() -> str:
    """Enable the installed add-on; its module name."""
    wanted = os.environ.get("SINEW_ADDON_MODULE")
    for name in (wanted,) if wanted else CANDIDATES:
        if addon_utils.enable(name, default_set=True) is not None:
            return name
    raise RuntimeError(f"Sinew is not installed as {wanted or ' or '.join(CANDIDATES)}")


@functools.cache
def name() -> str:
    """The module name of the add-on, which is enabled unless it is already."""
    for candidate in CANDIDATES:
        if getattr(sys.modules.get(candidate), "__addon_enabled__", False):
            return candidate
    return enable()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Check whether this installation computes what is known, and write a report."""

from tempfile import NamedTemporaryFile
from typing import TextIO

import bpy
from bpy.types import Context, Operator

from ...backend import Check, check_installation
from ...ids import Operators
from ..reporting import Reports


def write_report(file: TextIO) -> Check:
    """Compute all known answers and write the report into an open file. The scene stays as it is."""
    kind = "in the background" if bpy.app.background else "with a window"
    built = bpy.app.build_hash.decode("ascii", "replace")
    return check_installation(file, f"{bpy.app.version_string} ({built}), {kind}", file.name)


class SINEW_OT_check_installation(Reports, Operator):
    """Compute known answers with every method, and write a report that you can attach to an issue.

    It takes some seconds, and the open file stays as it is
    """

    bl_idname = Operators.CHECK_INSTALLATION
    bl_label = "Check This Installation"
    bl_options = {"INTERNAL"}  # its button is in the preferences, and Blender searches menus

    def execute(self, _context: Context) -> set[str]:
        try:
            with NamedTemporaryFile(
                "w", prefix="sinew-check-", suffix=".txt", encoding="utf-8", errors="replace", delete=False
            ) as file:
                found = write_report(file)
        except OSError as error:
            self.tell({"ERROR"}, f"The report cannot be written: {error}")
            return {"CANCELLED"}
        level = "INFO" if found.is_right else "ERROR"
        self.tell({level}, f"{found.summary}. The report is {found.report}")
        return {"FINISHED"}

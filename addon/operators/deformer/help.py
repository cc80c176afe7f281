# SPDX-License-Identifier: GPL-3.0-or-later
"""Open a page of the manual that came with the add-on."""

from pathlib import Path

import bpy
from bpy.props import EnumProperty
from bpy.types import Context, Operator

from ...core.errors import SinewError
from ...core.labels import label_of
from ...core.methods import BY_ID, METHODS, Method
from ...core.tasks import TASKS
from ...ids import Operators
from ..arguments import once
from ..reporting import Reports, reports_errors

# Identifier, label and description; the identifier is the path of the page's file.
PAGES = (
    ("start", "Start", "A first pose, all tasks as pictures, how to choose a method"),
    ("methods/comparison", "What Fails Where", "Methods on the same hard edits, with pictures and figures"),
    *((task.page, f"About {task.label}", f"How it is done: {task.purpose}") for task in TASKS),
    ("drag", "The Tool Sinew Drag", "Its modes, keys, settings and marks"),
    ("handles", "Handles, Areas, Mirror, Painting", "What moves and what stays, both sides at once, keys"),
    ("order-and-masks", "Order and Masks", "Several deformers, other modifiers, masks, binding"),
    ("show", "Show in Colour", "Colours of regions, of influence, and of distortion"),
    ("prepare", "Prepare a Mesh", "What is unusual about a mesh, what mends it, and how the mesh bends"),
    ("bake", "Bake and Apply", "Store shapes in shape keys, caches, or the mesh itself"),
    ("farms", "Farms", "Bakes on many machines, without a window, and sweeps of a property"),
    ("hand-over", "Hand Over, Farms, Linked Files", "Renders, other machines, libraries, copies"),
    ("troubles", "When Something Is Wrong", "What each warning means, and what to do about it"),
    ("scripting", "Scripts", "Operators, properties, and the Python module"),
)
_OF_METHOD = "methods/{}"
_OF_METHODS = tuple((_OF_METHOD.format(row.id), row.label, row.summary) for row in METHODS)

_ADDON = Path(__file__).resolve().parents[2]


def page_of(method: Method) -> str:
    """The page about a method."""
    return _OF_METHOD.format(method.id)


def manual_page(page: str) -> Path:
    """The file of a page: packaged with the add-on or, in a checkout of the source, as it is written."""
    written = _ADDON.parent / "docs"
    for path in (
        _ADDON / "manual" / f"{page}.html",
        written / "manual" / f"{page}.md",
        written / f"{page}.md",
    ):
        if path.is_file():
            return path
    raise SinewError(
        f"The page '{page}' of the manual is missing - install the Sinew zip again, which contains it"
    )


class SINEW_OT_help(Reports, Operator):
    """Open the page of the manual about this panel in the web browser. It needs no network.

    The manual was installed with the add-on
    """

    bl_idname = Operators.HELP
    bl_label = "Sinew Manual"

    page: once(EnumProperty, items=PAGES + _OF_METHODS, default="start").named(
        "Page", "Choose what to read about"
    )

    @classmethod
    def description(cls, _context: Context, properties: "SINEW_OT_help") -> str:
        """The tooltip, which names the page."""
        method = BY_ID.get(properties.page.rpartition("/")[2])
        if method is None:
            _identifier, label, about = next(item for item in PAGES if item[0] == properties.page)
        else:
            label, about = label_of(method), method.summary
        return f"{label}. {about}.\nOpens the manual in the web browser; it was installed with the add-on"

    @reports_errors
    def execute(self, _context: Context) -> set[str]:
        path = manual_page(self.page)
        if bpy.app.background:
            self.tell({"INFO"}, str(path))
        else:
            bpy.ops.wm.url_open(url=path.as_uri())
        return {"FINISHED"}

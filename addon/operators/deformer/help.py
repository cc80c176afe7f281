# SPDX-License-Identifier: GPL-3.0-or-later
"""Open a page of the manual that came with the add-on."""

from pathlib import Path

import bpy
from bpy.props import EnumProperty
from bpy.types import Context, Operator

from ...core.errors import SinewError
from ...core.labels import label_of
from ...core.methods import BY_ID, METHODS, Method
from ...ids import Operators
from ..arguments import once
from ..reporting import Reports, reports_errors

# Identifier, label and description; the identifier is the path of the page's file.
PAGES = (
    ("handles", "Pose a Surface", "From a selection to a pose: handles, still regions, free areas, methods"),
    ("correct-an-elbow", "Correct an Elbow", "Corrections of a posed figure, which ride on its surface"),
    ("wrap-in-a-cage", "Pose with a Cage", "Let a coarse closed mesh around yours move it"),
    ("clothes", "Clothes", "A dressed figure in one cage, which its bones move"),
    ("put-in-a-box", "Pose with a Lattice", "Let a box of points around one object or several move them"),
    ("brows-and-folds", "Wires and Clay", "Curves and tools that move what is near them"),
    ("move-loose-parts", "Pose with Handle Points", "Let empties, bones and points of objects move space"),
    ("drag", "The Tool Sinew Drag", "Press on the surface in Object Mode, and drag"),
    ("hand-over", "Animate and Render", "Keyframes, drivers, renders, several deformers in one stack"),
    ("troubles", "When Things Go Wrong", "What each warning means, and what to do about it"),
    ("bake", "Bake and Apply", "Store shapes in shape keys, caches, or the mesh itself"),
    ("show", "Show", "Colours of regions, of influence, and of distortion"),
    ("shape-it-once", "Grab Vertices Once", "Move vertices once, without a handle that stays"),
    ("silhouette-sketch", "Draw an Outline", "Draw the outline of a mesh anew, and its surface follows"),
    ("pose-by-bones", "Puppets", "Drag a bone, and the figure and its skin follow"),
    ("scripting", "Scripting", "Operators, properties, and the Python module"),
    ("methods/comparison", "What Fails Where", "Methods on the same hard edits, with pictures and figures"),
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

    page: once(
        EnumProperty, "Page", "Choose what to read about", items=PAGES + _OF_METHODS, default="handles"
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

# SPDX-License-Identifier: GPL-3.0-or-later
"""The settings of overlays and of the drag tool in 3D viewports. They are stored on the scene."""

from collections.abc import Callable

from bpy.props import BoolProperty, EnumProperty, FloatProperty, PointerProperty, StringProperty
from bpy.types import Context, PropertyGroup, Scene

from ..core.methods import METHODS
from .drag import SinewDrag
from .setting import SHARE, field

OVERLAYS = (
    (
        "REGIONS",
        "Regions",
        "Each handle in its colour; regions that stay in place in one common colour",
        "GROUP_VERTEX",
        0,
    ),
    ("WEIGHT", "Handle Weight", "How firmly the active handle holds each vertex", "MOD_VERTEX_WEIGHT", 1),
    ("PARAMETER", "Parameter", "A parameter of the method, as painted by its vertex group", "BRUSH_DATA", 2),
    ("MASK", "Mask", "Where the deformation is shown", "MOD_MASK", 3),
    (
        "CAGE",
        "Cage Weight",
        "How far each vertex goes with the selected vertices of the cage",
        "MESH_CUBE",
        5,
    ),
    ("GRID", "Control Grid", "The grid of a method that has one, as the handles move it", "MESH_GRID", 6),
    ("BANDS", "Bands", "The bands of a method that has some: each turns as one", "ALIGN_JUSTIFY", 7),
    (
        "GRAPH",
        "Graph",
        "The nodes of a method that has some, as the handles move them",
        "OUTLINER_OB_MESH",
        8,
    ),
    ("DISTORTION", "Distortion", "Where the surface was stretched or compressed", "MOD_CLOTH", 4),
)

MEASURES = (
    ("STRETCH", "Largest Stretch", "How much longer the surface became, in the direction that grew most", 0),
    ("AREA", "Area", "How much larger or smaller each part of the surface became", 1),
    ("ANGLE", "Shear", "How much angles changed: the length of a former circle divided by its width", 2),
    (
        "DIRICHLET",
        "Symmetric Dirichlet",
        "Any change of shape or size; stretching and compression count alike",
        3,
    ),
)

_observers: list[Callable[[Context], None]] = []


def add_observer(observer: Callable[[Context], None]) -> None:
    """Let ``observer`` be called whenever a user or a script changes a setting."""
    _observers.append(observer)


def remove_observer(observer: Callable[[Context], None]) -> None:
    """Stop calling ``observer``."""
    if observer in _observers:
        _observers.remove(observer)


def _changed(_settings: "SinewScene", context: Context) -> None:
    for observer in _observers:
        observer(context)


def _shown(declare: Callable, **keywords) -> field:
    return field(declare, update=_changed, **keywords)


def _parameters() -> tuple[tuple, ...]:
    """Every parameter that a vertex group may scale.

    A parameter that several methods share is listed once.
    """
    items: dict[str, tuple] = {}
    for method in METHODS:
        for position, parameter in enumerate(method.parameters):
            if parameter in method.paintable and parameter.id not in items:
                number = 100 * method.number + position
                items[parameter.id] = (parameter.id, parameter.label, parameter.description, "NONE", number)
    return tuple(items.values())


class SinewScene(PropertyGroup):
    """The settings of Sinew that a scene stores"""

    drag: PointerProperty(type=SinewDrag)
    rig: field(StringProperty).named("Rig", "Name the rig of Try It that this scene was opened for")
    came_from: field(PointerProperty, type=Scene).named(
        "Came From", "Choose the scene that Back to My Scene shows again"
    )
    show_overlay: _shown(BoolProperty).named(
        "Show", "Draw regions, painted values or distortion over the meshes that Sinew deforms"
    )
    overlay: _shown(EnumProperty, items=OVERLAYS).named("Colours", "Choose what the colours stand for")
    parameter: _shown(EnumProperty, items=_parameters()).named(
        "Parameter", "Choose which painted parameter is shown"
    )
    measure: _shown(EnumProperty, items=MEASURES).named(
        "Measure", "Choose the measure of distortion that is shown"
    )
    distortion_range: _shown(
        FloatProperty, default=2.0, min=1.01, max=1000.0, soft_min=1.1, soft_max=10.0
    ).named(
        "Range", "Set the distortion that is shown in full colour: 2 means twice the size and half the size"
    )
    opacity: _shown(FloatProperty, **SHARE).named(
        "Opacity", "Set the opacity of the colours, as a share of that in the preferences"
    )
    all_viewports: _shown(BoolProperty, default=True).named(
        "All Viewports", "Draw in every 3D viewport, or only in the one where it was turned off"
    )

# SPDX-License-Identifier: GPL-3.0-or-later
"""What the 3D viewports show over the meshes. Part of the scene, so a file opens as it was left."""

from collections.abc import Callable

from bpy.props import BoolProperty, EnumProperty, FloatProperty
from bpy.types import Context, PropertyGroup

from ..core.methods import METHODS

OVERLAYS = (
    ("REGIONS", "Regions", "Each handle in its colour, what stays in place in grey", "GROUP_VERTEX", 0),
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
    ("DISTORTION", "Distortion", "Where the surface was stretched or compressed", "MOD_CLOTH", 4),
)

MEASURES = (
    ("STRETCH", "Largest Stretch", "How much longer the surface became, in the direction that grew most", 0),
    ("AREA", "Area", "How much larger or smaller each part of the surface became", 1),
    ("ANGLE", "Shear", "How much angles changed: the length of a circle for its width, whatever its size", 2),
    (
        "DIRICHLET",
        "Symmetric Dirichlet",
        "Any change of shape or size, stretched and compressed alike: what keeps a texture from showing it",
        3,
    ),
)

_observers: list[Callable[[Context], None]] = []


def add_observer(observer: Callable[[Context], None]) -> None:
    """Call this whenever a setting was changed by a user or a script."""
    _observers.append(observer)


def remove_observer(observer: Callable[[Context], None]) -> None:
    """Stop calling it."""
    if observer in _observers:
        _observers.remove(observer)


def _changed(_settings: "SinewScene", context: Context) -> None:
    for observer in _observers:
        observer(context)


def _parameters() -> tuple[tuple, ...]:
    """Every parameter that a vertex group may scale; equal ones of several methods once."""
    items: dict[str, tuple] = {}
    for method in METHODS:
        for position, parameter in enumerate(method.parameters):
            if parameter in method.paintable and parameter.id not in items:
                number = 100 * method.number + position
                items[parameter.id] = (parameter.id, parameter.label, parameter.description, "NONE", number)
    return tuple(items.values())


class SinewScene(PropertyGroup):
    """What Sinew stores on a scene"""

    show_overlay: BoolProperty(
        name="Overlays",
        update=_changed,
        description="Draw regions, painted values or distortion over the meshes that Sinew deforms",
    )
    overlay: EnumProperty(
        name="Show", items=OVERLAYS, update=_changed, description="What the colours stand for"
    )
    parameter: EnumProperty(
        name="Parameter", items=_parameters(), update=_changed, description="Which painted parameter is shown"
    )
    measure: EnumProperty(
        name="Measure", items=MEASURES, update=_changed, description="Which kind of distortion is shown"
    )
    distortion_range: FloatProperty(
        name="Range",
        default=2.0,
        min=1.01,
        max=1000.0,
        soft_min=1.1,
        soft_max=10.0,
        update=_changed,
        description="The distortion that has the full colour: 2 means twice as much, and half as much",
    )
    opacity: FloatProperty(
        name="Opacity",
        default=1.0,
        min=0.0,
        max=1.0,
        subtype="FACTOR",
        update=_changed,
        description="How much the colours cover the mesh, as a share of the opacity in the preferences",
    )
    all_viewports: BoolProperty(
        name="All Viewports",
        default=True,
        update=_changed,
        description="Draw in every 3D viewport; off, in the one where you changed this last",
    )

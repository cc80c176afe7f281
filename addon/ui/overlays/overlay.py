# SPDX-License-Identifier: GPL-3.0-or-later
"""Overlays in the 3D viewports: when and where they are drawn, and their panel.

Drawing callbacks are registered only while a scene shows an overlay, and never without a window.
"""

from collections.abc import Iterator

import bpy
from bpy.app.handlers import persistent
from bpy.types import Context, Depsgraph, Mesh, Object, Panel, SpaceView3D, UILayout
from bpy.utils import register_classes_factory

from ...core.geometry.distortion import Measure
from ...core.labels import label_of
from ...ids import Operators
from ...operators import target_of
from ...properties import SinewDeformer, scene as settings
from ...session.datablocks import owners
from ...session.results import result
from ..layouts import draw_field, fields
from ..places import ROOT, SidebarPanel
from ..text import draw_text
from . import overlay_draw
from .overlay_colours import number
from .overlay_mesh import OverlayCache, overlay_settings

cache = OverlayCache()
_PAINT_MODES = ("VERTEX_PAINT", "WEIGHT_PAINT", "TEXTURE_PAINT")  # Blender shows its own colours in these
_callbacks: list = []  # the two drawing callbacks, as Blender identifies them
_last_viewport: list[int] = [0]  # the address of the viewport in which the settings were changed last


def has_window() -> bool:
    """Whether Blender has a window to draw in."""
    return not bpy.app.background


def is_drawing() -> bool:
    """Whether Blender calls the drawing callbacks in each redraw of a viewport."""
    return bool(_callbacks)


def follow(context: Context | None = None) -> None:
    """Start or stop drawing: overlays are drawn only while a scene shows them."""
    space = getattr(context, "space_data", None)
    if isinstance(space, SpaceView3D):
        _last_viewport[0] = space.as_pointer()
    wanted = has_window() and any(scene.sinew.show_overlay for scene in bpy.data.scenes)
    if wanted and not _callbacks:
        for draw, moment in ((_draw_meshes, "POST_VIEW"), (_draw_legend, "POST_PIXEL")):
            _callbacks.append(SpaceView3D.draw_handler_add(draw, (), "WINDOW", moment))
        for event, handler in _HANDLERS:
            getattr(bpy.app.handlers, event).append(handler)
    elif _callbacks and not wanted:
        stop()
    _redraw()


def stop() -> None:
    """Stop drawing, and free what drawing needed."""
    while _callbacks:
        SpaceView3D.draw_handler_remove(_callbacks.pop(), "WINDOW")
    for event, handler in _HANDLERS:
        handlers = getattr(bpy.app.handlers, event)
        if handler in handlers:
            handlers.remove(handler)
    cache.clear()
    result.forget()
    overlay_draw.release()


def _redraw() -> None:
    for window in bpy.context.window_manager.windows:
        for area in window.screen.areas:
            if area.type == "VIEW_3D":
                area.tag_redraw()


@persistent
def on_update(_scene: object, depsgraph: Depsgraph) -> None:
    """Mark the meshes that Blender evaluated again, so that their overlays are computed again."""
    if depsgraph.mode != "VIEWPORT":
        return
    for update in depsgraph.updates:
        if not update.is_updated_geometry:
            continue
        if isinstance(update.id, Object):
            cache.mark_changed(update.id.original)
        elif isinstance(update.id, Mesh):
            _repainted(update.id.original)


def _repainted(mesh: Mesh) -> None:
    for obj in owners.owners():
        if obj.data == mesh:
            cache.mark_changed(obj)
            for deformer in obj.sinew.deformers:
                result.repainted(deformer)


@persistent
def on_frame(_scene: object, depsgraph: Depsgraph) -> None:
    if depsgraph.mode == "VIEWPORT":
        for obj in owners.owners():
            cache.mark_changed(obj)


@persistent
def on_other_state(*_args: object) -> None:
    """Undo, redo and load change settings without calling their update functions."""
    cache.clear()
    result.forget()
    follow()


_HANDLERS = (("depsgraph_update_post", on_update), ("frame_change_post", on_frame))
_ALWAYS = ("load_post", "undo_post", "redo_post")


def shown(context: Context) -> Iterator[tuple[Object, SinewDeformer]]:
    """The objects with an overlay in this viewport, each with the deformer that the overlay shows."""
    space, wanted = context.space_data, context.scene.sinew
    if not wanted.show_overlay or not space.overlay.show_overlays:
        return
    if not wanted.all_viewports and not _is_last_viewport(space):
        return
    for obj in owners.owners():
        if obj.mode in _PAINT_MODES or obj.name not in context.view_layer.objects:
            continue
        if obj.visible_get(viewport=space):
            yield obj, obj.sinew.active


def _is_last_viewport(space: SpaceView3D) -> bool:
    """Whether the settings were last changed in this viewport, or in one that no longer exists."""
    if _last_viewport[0] == space.as_pointer():
        return True
    return not any(
        area.spaces.active.as_pointer() == _last_viewport[0]
        for window in bpy.context.window_manager.windows
        for area in window.screen.areas
    )


def _draw_meshes() -> None:
    context = bpy.context
    depsgraph = context.evaluated_depsgraph_get()
    chosen = overlay_settings(context)
    for obj, deformer in shown(context):
        mesh = cache.overlay_mesh(obj, deformer, chosen, depsgraph)
        if mesh is not None:
            overlay_draw.draw_mesh(context, deformer.uid, obj.evaluated_get(depsgraph), mesh)


def _draw_legend() -> None:
    context = bpy.context
    target = target_of(context)
    for obj, deformer in shown(context):
        if obj == target:
            chosen = overlay_settings(context)
            mesh = cache.overlay_mesh(obj, deformer, chosen, context.evaluated_depsgraph_get())
            if mesh is not None:
                overlay_draw.draw_legend(context, mesh.legend)


class SINEW_PT_overlays(SidebarPanel, Panel):
    """Colours over the mesh: regions, painted values, distortion"""

    bl_label = "Show"
    bl_parent_id = ROOT
    bl_options = {"DEFAULT_CLOSED"}
    bl_order = 20

    @classmethod
    def poll(cls, context: Context) -> bool:
        obj = target_of(context)
        return obj is not None and obj.sinew.active is not None

    def draw_header(self, context: Context) -> None:
        self.layout.prop(context.scene.sinew, "show_overlay", text="")

    def draw(self, context: Context) -> None:
        layout, wanted = fields(context, self.layout), context.scene.sinew
        obj = target_of(context)
        layout.active = wanted.show_overlay
        draw_field(context, layout, wanted, "overlay")
        if wanted.overlay == "PARAMETER":
            _draw_parameters(layout, wanted, obj.sinew.active)
        elif wanted.overlay == "DISTORTION":
            draw_field(context, layout, wanted, "measure")
            layout.prop(wanted, "distortion_range")
        layout.prop(wanted, "opacity", slider=True)
        layout.prop(wanted, "all_viewports")
        if wanted.overlay == "DISTORTION":
            _draw_largest(context, layout, obj, wanted)


def _draw_parameters(layout: UILayout, wanted: settings.SinewScene, deformer: SinewDeformer) -> None:
    paintable = deformer.definition.paintable
    if not paintable:
        layout.label(text=f"{label_of(deformer.definition)} has no parameter to paint", icon="INFO")
        return
    column = layout.column(align=True)
    column.use_property_split = False
    for parameter in paintable:
        column.prop_enum(wanted, "parameter", parameter.id)


def _draw_largest(context: Context, layout: UILayout, obj: Object, wanted: settings.SinewScene) -> None:
    """The vertex with the largest distortion, once a viewport has measured it."""
    found = result.measured(obj, obj.sinew.active, Measure(wanted.measure))
    text = next(label for identifier, label, *_rest in settings.MEASURES if identifier == wanted.measure)
    if found is not None:
        text = f"{text} {number(found.largest)} at vertex {found.worst:,}"
    row = layout.row()
    draw_text(context, row.column(), text, beside=30)
    row.operator(Operators.SELECT_DISTORTED, text="", icon="RESTRICT_SELECT_OFF").measure = wanted.measure


PANELS = (SINEW_PT_overlays,)
_register, _unregister = register_classes_factory(PANELS)


def register() -> None:
    _register()
    settings.add_observer(follow)
    for event in _ALWAYS:
        getattr(bpy.app.handlers, event).append(on_other_state)
    if has_window():
        bpy.app.timers.register(_begin, first_interval=0.0)


def _begin() -> None:
    """A file may show overlays already; while add-ons register, Blender does not allow access to scenes."""
    follow()


def unregister() -> None:
    if bpy.app.timers.is_registered(_begin):
        bpy.app.timers.unregister(_begin)
    stop()
    settings.remove_observer(follow)
    for event in _ALWAYS:
        handlers = getattr(bpy.app.handlers, event)
        if on_other_state in handlers:
            handlers.remove(on_other_state)
    _unregister()

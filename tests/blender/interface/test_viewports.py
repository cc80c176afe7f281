# SPDX-License-Identifier: GPL-3.0-or-later
"""Whose overlay a 3D Viewport shows, and which: viewports exist without a window, too, undrawn."""

import itertools

import bpy
import numpy as np
import pytest
from inside import inner
from mathutils import Matrix
from rigs.rig import Rig, add_group, make_active, move_world, update

LOOKS = {
    **{name: {"overlay": name} for name in ("REGIONS", "WEIGHT", "MASK")},
    "PARAMETER": {"overlay": "PARAMETER", "parameter": "rigidity"},
    **{m: {"overlay": "DISTORTION", "measure": m} for m in ("STRETCH", "AREA", "ANGLE", "DIRICHLET")},
}


@pytest.fixture
def shown(viewport):
    """The objects whose overlay the viewport shows."""
    viewport.scene.sinew.show_overlay = viewport.scene.sinew.all_viewports = True
    overlay = inner.overlay
    yield lambda: [obj for obj, _deformer in overlay.shown(viewport)]
    viewport.scene.sinew.show_overlay = False


def test_blenders_overlay_switch_hides_ours_too(shown, viewport, bound_plate: Rig):
    assert shown() == [bound_plate.obj]
    viewport.space_data.overlay.show_overlays = False
    assert shown() == []
    viewport.space_data.overlay.show_overlays = True
    viewport.scene.sinew.show_overlay = False
    assert shown() == []


def test_hidden_objects_and_local_views_have_no_overlay(shown, viewport, bound_plate: Rig):
    bound_plate.obj.hide_set(True)
    assert shown() == []
    bound_plate.obj.hide_set(False)
    lone = bpy.data.objects.new("Lone", None)
    viewport.scene.collection.objects.link(lone)
    make_active(lone)
    bpy.ops.view3d.localview(frame_selected=False)
    assert shown() == []
    bpy.ops.view3d.localview(frame_selected=False)
    assert shown() == [bound_plate.obj]


def test_no_two_overlays_are_alike(viewport, plate: Rig):
    add_group(plate.obj, "Firm", lambda point: point[0] < 0.0)
    add_group(plate.obj, "Front", lambda point: point[1] < 0.5)
    plate.bind("arap")
    move_world(plate.control, Matrix.Translation((0.2, 0.5, 0.4)) @ Matrix.Rotation(0.6, 4, "Z"))
    plate.deformer.arap.rigidity_group = "Firm"
    cache, painted = inner.overlay.cache, {}
    for name, look in LOOKS.items():
        plate.deformer.mask_group = "Front" if name == "MASK" else ""
        update()
        for key, value in look.items():
            setattr(viewport.scene.sinew, key, value)
        wanted = inner.overlay_mesh.overlay_settings(viewport)
        cache.clear()
        picture = cache.overlay_mesh(plate.obj, plate.deformer, wanted, bpy.context.evaluated_depsgraph_get())
        painted[name] = picture.colours
        assert picture.colours[:, 3].any(), name
    cache.clear()
    for (one, colours), (other, others) in itertools.combinations(painted.items(), 2):
        assert np.abs(colours - others).max() > 0.01, (one, other)


def test_the_scale_of_weights_is_yellow_above_and_violet_below():
    low, high = inner.overlay_colours.scale(np.array((0.0, 1.0)))
    assert low[0] - low[2] < 0.0 < 0.3 < high[0] - high[2]
    assert high.sum() > 2.0 * low.sum()

# SPDX-License-Identifier: GPL-3.0-or-later
"""What handlers of other add-ons and scripts read of a deformed object, in frames, edits and renders."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack

import bpy
import numpy as np
import pytest
from inside import without_the_add_on
from probe import render_points
from rigs.kinds import HandleRig
from rigs.rig import close, key_heights, points_of, update

HEIGHTS = {1: 0.0, 11: 1.0}


@pytest.fixture
def rising(rig: HandleRig) -> HandleRig:
    """Each rig with a control that rises by 0.1 each frame."""
    rig.start()
    start = rig.control.location.z
    key_heights(rig.control, {frame: start + height for frame, height in HEIGHTS.items()}, linear=True)
    bpy.context.scene.frame_set(1)
    return rig


@pytest.fixture
def listen():
    """Add a handler of another add-on, which reads an object."""
    with ExitStack() as added:

        def add(event: str, name: str) -> list[tuple[str, np.ndarray, set[str]]]:
            seen, handlers = [], getattr(bpy.app.handlers, event)

            def read(_scene: object, depsgraph: bpy.types.Depsgraph) -> None:
                found = points_of(bpy.data.objects[name].evaluated_get(depsgraph))
                seen.append((depsgraph.mode, found, {update.id.name for update in depsgraph.updates}))

            handlers.append(read)
            added.callback(handlers.remove, read)
            return seen

        yield add


def height_at(frame: float) -> float:
    return (frame - 1.0) / 10.0


def test_handlers_of_frames_read_the_shape_of_the_frame(rising: HandleRig, listen: Callable):
    seen, edits = listen("frame_change_post", rising.name), listen("depsgraph_update_post", rising.name)
    for frame in (3, 9, 2):
        bpy.context.scene.frame_set(frame)
        _mode, shape, _listed = seen.pop()
        assert close(shape, rising.at(height_at(frame)), max(rising.tolerance, 2e-5)), frame
        assert not seen
        assert not edits, "a change of frame is no edit"
        assert rising.shows(shape)


def test_handlers_that_were_there_before_the_add_on_read_it_too(listen: Callable):
    rig = HandleRig.new().start()
    key_heights(rig.control, HEIGHTS, linear=True)
    seen = listen("frame_change_post", rig.name)
    with without_the_add_on():
        pass
    bpy.context.scene.frame_set(8)
    assert close(seen[-1][1], rig.at(height_at(8)), 2e-5)


def test_handlers_of_frames_read_the_shape_in_renders(rising: HandleRig, listen: Callable):
    seen = listen("frame_change_post", rising.name)
    bpy.context.scene.frame_set(7)
    seen.clear()
    rendered = render_points(rising.obj)
    shapes = [shape for mode, shape, _listed in seen if mode == "RENDER"]
    assert shapes
    assert all(close(shape, rendered, 2e-5) for shape in shapes)


@pytest.mark.parametrize("with_the_scene", [False, True])
def test_handlers_of_edits_read_the_shape_and_hear_of_all_that_changed(
    rising: HandleRig, listen: Callable, with_the_scene: bool
):
    rising.control.animation_data_clear()
    update()
    seen = listen("depsgraph_update_post", rising.name)
    for height in (0.5, 0.2):
        seen.clear()
        if with_the_scene:
            bpy.context.scene.gravity.x += 1.0
        rising.lift_to(height)
        heard = [(close(shape, rising.at(height), 2e-5), listed) for _mode, shape, listed in seen]
        assert heard[-1][0], "the last one reads the right shape"
        assert all(is_right for is_right, listed in heard if rising.name in listed)
        assert {rising.name, rising.control.name} <= set().union(*(listed for _is_right, listed in heard))
        assert rising.is_right(2e-5)

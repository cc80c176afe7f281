# SPDX-License-Identifier: GPL-3.0-or-later
"""A bind that needs more memory than the preferences allow is refused by size, and nothing is lost."""

import re

import bpy
import numpy as np
import pytest
from rig import Rig, make_active


def test_bind_above_the_limit_names_both_sizes_and_shows_rest(preferences, room) -> None:
    status = room("core.status")
    preferences.memory_limit = 0.0001  # 0.1 MB, and a plate of 1,681 vertices needs more
    plate = Rig.plate(cells=40).bind("thin_shell")
    with pytest.raises(RuntimeError, match=r"needs 0\.[2-9] MB, the memory limit is 0\.1 MB"):
        bpy.ops.sinew.bind()
    said = status.current(plate.deformer.uid)
    assert said.level is status.Level.ERROR
    assert re.search(r"needs [\d.]+ MB, the memory limit is 0\.1 MB: raise the limit", said.text)
    assert said.remedy is status.Remedy.PREFERENCES
    np.testing.assert_array_equal(plate.points(), plate.rest())


def test_raised_limit_binds_what_was_refused(preferences) -> None:
    preferences.memory_limit = 0.0001
    plate = Rig.plate(cells=40).bind("thin_shell")
    plate.lift(0.5)
    np.testing.assert_array_equal(plate.points(), plate.rest())
    preferences.memory_limit = 1.0
    make_active(plate.obj)
    bpy.ops.sinew.bind()
    assert np.allclose(plate.points()[plate.top, 2], 0.5, atol=1e-6)


def test_lowered_limit_keeps_what_is_bound(preferences) -> None:
    plate = Rig.plate(cells=40).bind("thin_shell")
    preferences.memory_limit = 0.0001
    plate.lift(0.5)
    assert np.allclose(plate.points()[plate.top, 2], 0.5, atol=1e-6)

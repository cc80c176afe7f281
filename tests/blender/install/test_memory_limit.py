# SPDX-License-Identifier: GPL-3.0-or-later
"""A bind that needs more memory than the preferences allow is refused by size, and nothing is lost."""

from __future__ import annotations

import re

import pytest
from inside import inner
from registry import METHODS, Control
from rigs.cages import assert_goes_on, assert_rests, ball, box, motion_of, set_rest, surround
from rigs.kinds import BY_CONTROL
from rigs.rig import press, refused, subdivided

LIMIT = 0.0001  # gigabytes; shown as 0.1 MB
OVERSHOT = 0.02  # surfaces that resist bending rise a little above the handle that lifts them


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_a_bind_above_the_limit_names_both_sizes_and_waits_for_a_higher_one(preferences, method):
    """A limit that is lowered afterwards leaves what is bound alone."""
    status = inner.status
    preferences.memory_limit = LIMIT
    kind = BY_CONTROL[method.control]
    # On handle points, a method may need no more than 4 bytes per vertex.
    rig = kind.large(cells=180) if method.is_space and method.control is Control.HANDLES else kind.large()
    rig.attach(method.id)
    obj = rig.obj
    refused(r"needs [\d.]+ MB, the memory limit is 0\.1 MB", "bind", obj)
    said = status.current(obj.sinew.active.uid)
    assert (said.level, said.remedy) == (status.Level.ERROR, status.Remedy.PREFERENCES)
    (needed,) = re.findall(r"needs ([\d.]+) MB, the memory limit is 0\.1 MB: raise the limit", said.text)
    assert float(needed) >= 0.1
    rig.lift(0.5)
    assert_rests(obj)
    preferences.memory_limit = 1.0
    press(obj, "bind")
    assert motion_of(obj)[:, 2].max() == pytest.approx(0.5, abs=OVERSHOT)
    preferences.memory_limit = LIMIT
    rig.lift(0.5)
    assert motion_of(obj)[:, 2].max() == pytest.approx(1.0, abs=2 * OVERSHOT)


def test_a_finer_cage_above_the_limit_is_refused_until_it_is_coarse_again(preferences):
    target, cage = ball(), box()
    deformer = surround(target, cage)
    preferences.memory_limit = LIMIT / 2
    smoother = subdivided(cage, 3, 3)
    smoother.subdivision_type = "SIMPLE"
    refused("memory limit", "cage_set_rest", target)
    assert_rests(target)
    assert inner.status.current(deformer.uid).remedy.name == "PREFERENCES"
    cage.modifiers.clear()
    set_rest(target)
    assert_goes_on(target, cage)

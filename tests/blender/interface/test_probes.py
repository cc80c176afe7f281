# SPDX-License-Identifier: GPL-3.0-or-later
"""What ``inside.assert_at_rest`` looks for after every test, it finds in an add-on broken on purpose."""

import pytest
from inside import assert_at_rest, bind_in_thread, dragging, inner
from mathutils import Matrix
from registry import BY_ID, WITH_HANDLES
from rigs.rig import Rig, move_world

TURN = Matrix.Translation((0.0, -0.6, 0.9)) @ Matrix.Rotation(1.9, 4, "X")


def test_a_bind_that_nobody_collects_is_found(plate: Rig, monkeypatch: pytest.MonkeyPatch):
    plate.bind()
    plate.deformer.live = False  # else the next evaluation would ask for another bind
    bind_in_thread(plate.obj, plate.deformer, monkeypatch)
    with monkeypatch.context() as patch:
        patch.setattr(inner.housekeeping, "collect", lambda: None)
        with pytest.raises(AssertionError, match=plate.deformer.uid):
            assert_at_rest(seconds=0.5)


def test_evaluations_that_cause_each_other_are_found(bound_plate: Rig, monkeypatch: pytest.MonkeyPatch):
    with monkeypatch.context() as patch:
        patch.setattr(inner.refresh, "refresh", bound_plate.obj.update_tag)
        with pytest.raises(AssertionError, match="pause after pause"):
            assert_at_rest()


def test_a_preview_that_stays_is_found(plate: Rig, monkeypatch: pytest.MonkeyPatch):
    plate.bind(next(method for method in WITH_HANDLES if BY_ID[method].iterative))
    with dragging():
        move_world(plate.control, TURN)
    with monkeypatch.context() as patch:
        patch.setattr(inner.evaluate, "settle", lambda: False)
        with pytest.raises(AssertionError, match="never becomes final"):
            assert_at_rest()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Typed errors, status texts, and the backend's translation of native errors."""

import dataclasses

import numpy as np
import pytest
from rows import ON_SURFACE, base_option

from sinew.core import errors, memory, status
from sinew.core.elements import Elements, Owner
from sinew.core.methods import BY_ID
from sinew.core.status import Level, Status


def test_every_error_is_a_sinew_error_and_carries_elements():
    kinds = [v for v in vars(errors).values() if isinstance(v, type) and issubclass(v, Exception)]
    assert len(kinds) > 5
    for kind in kinds:
        error = kind("message", Elements(Owner.CONTROL, "vertex", (np.int64(3), 5)))
        assert isinstance(error, errors.SinewError)
        assert error.elements == Elements(Owner.CONTROL, "vertex", (3, 5))
        other = error.with_elements(Elements(Owner.TARGET, "face", (1,)), status.Remedy.REPAIR)
        found = type(other), str(other), other.elements.owner, other.remedy
        assert found == (kind, "message", Owner.TARGET, status.Remedy.REPAIR)
        assert error.elements.owner is Owner.CONTROL, "an error that was raised stays as it was"
        assert str(error) == "message"


def test_status_is_kept_by_key():
    status.put("a", Status(Level.INFO, "fine"))
    status.fail("b", errors.MeshError("broken", Elements(Owner.TARGET, "face", (1, 2))))
    status.put_notes("b", (Status(Level.WARNING, "and free"),))
    assert status.current("a").text == "fine"
    assert status.current("b") == Status(Level.ERROR, "broken", Elements(Owner.TARGET, "face", (1, 2)))
    assert status.notes("b")[0].text == "and free"
    status.clear("b")
    assert status.current("b") is status.EMPTY
    assert status.notes("b") == ()
    memory.forget_all()
    assert status.current("a") is status.EMPTY


PLATE = np.array([(x, y, 0.0) for y in range(4) for x in range(4)], dtype=float)
COUNTS = np.full(9, 4, dtype=np.int32)
ENDS = (np.arange(4), np.arange(12, 16))
CORNERS = np.array([i + j * 4 + k for j in range(3) for i in range(3) for k in (0, 1, 5, 4)], dtype=np.int32)


def build(backend, method_id: str = "thin_shell", points=PLATE, options=None, handles=ENDS, progress=None):
    method = BY_ID[method_id]
    shape, regions = backend.Shape(points, (COUNTS, CORNERS)), backend.Regions(handles, None)
    recipe = backend.Recipe(method, shape, base_option(backend, method) | (options or {}), regions)
    return backend.build_factor(recipe, progress)


def test_a_factor_solves(backend):
    poses = np.stack([np.eye(4)[:3]] * 2)
    poses[:, 2, 3] = 1.0
    positions, _report = build(backend).solve(poses)
    assert np.allclose(positions, PLATE + (0.0, 0.0, 1.0))


def test_every_native_error_has_one_of_ours(backend, monkeypatch: pytest.MonkeyPatch):
    module = backend.availability().module
    kinds = [
        kind for kind in vars(module).values() if isinstance(kind, type) and issubclass(kind, module.Error)
    ]
    found = {}
    for kind in kinds:

        def refuse(*_args: object, kind: type = kind) -> None:
            raise kind("refused")

        monkeypatch.setattr(module, "SurfaceMesh", refuse)
        with pytest.raises(errors.SinewError, match="refused") as caught:
            backend.connected_parts(16, (COUNTS, CORNERS))
        found[kind.__name__] = caught.type
    assert found.pop("Error") is errors.SinewError
    assert len(found) > 5
    assert errors.SinewError not in found.values(), found


def test_a_bind_within_a_bind_of_the_same_object_is_refused(backend):
    """In its progress callback, which cannot wait for the bind that it belongs to."""
    factor = build(backend)
    recipe = dataclasses.replace(
        factor.recipe, control=backend.Regions([np.arange(4), np.arange(8, 16)], None)
    )
    prepared = factor.prepare_rebind(recipe)
    refusals = []

    def progress(*_state: object) -> bool:
        with pytest.raises(errors.FactorInUseError, match="in use") as caught:
            backend.build_factor(recipe, prepared=prepared)
        refusals.append(caught.value.remedy)
        return True

    bound = backend.build_factor(recipe, progress, prepared)
    assert set(refusals) == {status.Remedy.BIND}
    poses = np.stack([np.eye(4)[:3]] * 2)
    assert np.allclose(bound.solve(poses)[0], PLATE)


@pytest.mark.parametrize("method_id", ON_SURFACE)
def test_native_refusals_become_ours(backend, method_id: str):
    with pytest.raises(errors.ConstraintError):
        build(backend, method_id, handles=[np.arange(4), np.array([99])])
    with pytest.raises(errors.ConstraintError) as refused:
        build(backend, method_id, handles=[np.arange(4), np.arange(2, 6)])
    assert set(refused.value.elements.indices) == {2, 3}
    assert refused.value.elements.element == "vertex"
    with pytest.raises(errors.MeshError):
        build(backend, method_id, points=np.full_like(PLATE, np.nan))
    for painted in BY_ID[method_id].paintable:
        with pytest.raises(errors.OptionError):
            build(backend, method_id, options={painted.id: -1.0})
    with pytest.raises(errors.ConstraintError):
        build(backend, method_id).solve(np.stack([np.eye(4)[:3]] * 3))


def test_cancel(backend):
    with pytest.raises(errors.CancelledError):
        build(backend, progress=lambda _fraction, _stage: False)


def test_errors_bring_their_remedy_to_the_panel():
    expected = {
        errors.BackendMissingError: status.Remedy.PREFERENCES,
        errors.CancelledError: status.Remedy.BIND,
        errors.TopologyChangedError: status.Remedy.BIND,
        errors.ConstraintError: status.Remedy.NONE,
    }
    for kind, remedy in expected.items():
        status.fail("remedies", kind("message"))
        assert status.current("remedies").remedy is remedy
    status.fail("remedies", errors.ConstraintError("message", remedy=status.Remedy.PART_REGIONS))
    assert status.current("remedies").remedy is status.Remedy.PART_REGIONS
    memory.forget_all()

# SPDX-License-Identifier: GPL-3.0-or-later
"""Each kind of control that a method asks for answers every question of the session and draws itself."""

from collections.abc import Iterator

import bpy
import pytest
from inside import inner
from registry import WITH_CAGE, WITH_HANDLES
from rigs.cages import ball, box
from rigs.rig import linked


def members(protocol: type) -> Iterator[str]:
    """The names that a class of a protocol declares."""
    yield from protocol.__annotations__
    yield from (name for name in vars(protocol) if not name.startswith("_"))


def test_every_kind_answers_every_question_and_draws_itself_and_every_method_belongs_to_one() -> None:
    kinds, drawing = inner.kinds, inner.control
    questions, wanted = set(members(kinds.ControlKind)), set(members(drawing.ControlDrawing))
    assert len(questions) > 15
    for kind in kinds.every_kind():
        assert questions <= set(dir(kind)), kind
        assert all(kinds.kind_of_method(method) is kind for method in kinds.methods_of(kind))
    listed = [method.id for kind in kinds.every_kind() for method in kinds.methods_of(kind)]
    assert sorted(listed) == sorted(method.id for method in inner.methods.METHODS)
    for method in inner.methods.METHODS:
        assert wanted <= set(dir(drawing.drawing_of(method))), method.id


def test_one_call_lets_an_object_control_a_deformer_of_its_kind() -> None:
    """As Wrap in a Cage does; a kind that needs more than an object refuses, and leaves nothing behind."""
    errors = inner.errors
    target, cage, other = ball(), box(), box("Other")
    for owned, method in enumerate(WITH_CAGE[:2]):
        deformer, refusal = inner.rigging.rig_control(target, cage, method, owned=bool(owned))
        assert refusal is None
        assert (deformer.cage, deformer.owns_cage, deformer.is_bound) == (cage, bool(owned), True)
        assert not any(d.cage is None for d in target.sinew.deformers)
    deformer.cage = None
    assert inner.rigging.waiting_for_control(target, WITH_CAGE[0]) == deformer
    assert inner.rigging.waiting_for_control(target, WITH_HANDLES[0]) is None
    assert inner.rigging.rig_control(target, other, WITH_CAGE[0])[0] == deformer
    assert len(target.sinew.deformers) == 2
    for method, control in ((WITH_HANDLES[0], cage), (WITH_CAGE[0], target)):
        with pytest.raises(errors.SinewError):
            inner.rigging.rig_control(target, control, method)
        assert len(target.sinew.deformers) == 2


@pytest.mark.parametrize("owned", [True, False])
def test_an_object_made_for_a_deformer_goes_unless_another_uses_it(scene, owned: bool) -> None:
    """Whatever kind of control it is, and whichever deformer lets it go first."""
    objects, deformers = inner.objects, []
    control = bpy.data.objects.new("Control", bpy.data.meshes.new("Control"))
    for name in ("One", "Two"):
        target = linked(bpy.data.objects.new(name, bpy.data.meshes.new(name)))
        deformers.append(target.sinew.deformers.add())
        row = deformers[-1].controls.add()
        row.kind, row.object, row.owned, row.rest = "lattice", control, owned, bpy.data.meshes.new("Rest")
    objects.release(deformers[0].controls)
    assert deformers[0].controls[0].object is None
    assert "Control" in bpy.data.objects, "the other deformer uses it"
    objects.release(deformers[1].controls)
    assert ("Control" in bpy.data.objects) != owned
    assert ("Control" in bpy.data.meshes) != owned
    assert not [mesh for mesh in bpy.data.meshes if mesh.name.startswith("Rest")]

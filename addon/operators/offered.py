# SPDX-License-Identifier: GPL-3.0-or-later
"""Mixins that say where Blender offers an operator, and what to do where it does not."""

from typing import ClassVar

from bpy.types import Context

from .. import compat
from ..properties import deformers_of
from ..session.targets import targets
from .reporting import Reports
from .target import LINKED, explain_no_target, target_of


class Offered(Reports):
    """Mixin for an operator that can be undone, and that Blender offers where nothing refuses it."""

    bl_options: ClassVar[set[str]] = {"REGISTER", "UNDO"}

    @classmethod
    def poll(cls, context: Context) -> bool:
        reason = cls.refusal(context)
        if reason:
            cls.poll_message_set(compat.told(reason))
        return not reason

    @classmethod
    def refusal(cls, context: Context) -> str:
        """Why it cannot work now, with the remedy; empty if it can."""
        raise TypeError(f"{cls.__name__} does not say where it is offered")


class OnTarget(Offered):
    """Mixin for an operator that works on an editable object."""

    MESHES_ONLY: ClassVar[bool] = False

    @classmethod
    def refusal(cls, context: Context) -> str:
        obj = target_of(context)
        if obj is None:
            return explain_no_target(context)[0]
        if obj.library is not None:
            return LINKED
        if cls.MESHES_ONLY and not targets.is_mesh(obj):
            remedy = "" if obj.type == "LATTICE" else ", or convert it to a mesh"
            return (
                f"{obj.name} is a {targets.label(obj)} object without regions - add a cage, a lattice, wires "
                f"or handle points{remedy}"
            )
        return ""


class OnDeformer(OnTarget):
    """Mixin for an operator that works on the active deformer of an editable object."""

    @classmethod
    def refusal(cls, context: Context) -> str:
        return super().refusal(context) or (
            "" if deformers_of(target_of(context)) else "Add a deformer first"
        )


class OnLiveDeformer(OnDeformer):
    """Mixin for an operator that works on the active deformer while it is not baked."""

    @classmethod
    def refusal(cls, context: Context) -> str:
        reason = super().refusal(context)
        if reason:
            return reason
        active = target_of(context).sinew.active
        return f"{active.name} is baked - Unbake it first" if active.bake.is_baked else ""

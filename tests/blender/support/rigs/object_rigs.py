# SPDX-License-Identifier: GPL-3.0-or-later
"""What the rigs have in common that one whole object moves."""

import bpy
import numpy as np
from mathutils import Matrix

from rigs.rig import linked


def object_class(base: type) -> type:
    """A rig that the first object in the list of controls moves, by the rig of handles."""

    class ObjectRig(base):
        goes_on = False
        counts_in_no_scene = False
        hidden_meshes = 5  # the control at rest, too

        @staticmethod
        def row_of(obj: bpy.types.Object):
            return obj.sinew.deformers[0].all_controls[0]

        @classmethod
        def control_of(cls, obj: bpy.types.Object) -> bpy.types.Object:
            return cls.row_of(obj).object

        @classmethod
        def set_control(cls, obj: bpy.types.Object, control: bpy.types.Object | None) -> None:
            cls.row_of(obj).object = control

        @classmethod
        def another_control(cls, obj: bpy.types.Object) -> bpy.types.Object:
            return another(cls.control_of(obj))

        @classmethod
        def control_is_missing(cls, obj: bpy.types.Object) -> bool:
            return cls.row_of(obj).missing

        @property
        def control(self) -> bpy.types.Object:
            return self.deformer.all_controls[0].object

        @property
        def held(self) -> slice:
            """All, unless a control reaches a part only."""
            return slice(None)

        def rest(self) -> np.ndarray:
            return self.unmoved(self.obj)

        def bind(self, method: str = "", fixed: bool = True, **_keywords):
            self.bind_at_rest(method or self.methods[0])
            return self

        def bind_at_rest(self, method: str) -> None:
            self.attach(method)
            assert self.deformer.status_level == "INFO", self.deformer.status

        def relax(self) -> None:
            self.control.matrix_basis = Matrix.Identity(4)

        def choose(self, method: str) -> None:
            """Another method than that of the new deformer."""
            if method != self.deformer.method:
                self.deformer.method = method
                bpy.ops.sinew.bind()

    return ObjectRig


def another(control: bpy.types.Object) -> bpy.types.Object:
    """A copy with data of its own."""
    copy = control.copy()
    copy.data = control.data.copy()
    copy.name = "Another"
    return linked(copy)

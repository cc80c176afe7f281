# SPDX-License-Identifier: GPL-3.0-or-later
"""What the event tests share: the shape that must be seen, undo steps, and a second Blender.

The expected shape comes from Blender's own data (mesh, vertex groups, matrices) and the native library,
called directly: neither the session nor what Sinew stores takes part.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import textwrap
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix
from rig import Rig, apply_matrix, base_points, update

FLOAT32 = 4e-6  # a few roundings of coordinates near 1
MATRIX = 1e-5  # a pose that went through location, rotation and scale in float32

_NATIVE = {"thin_shell": "ThinShell", "arap": "Arap"}
_HERE = Path(__file__).parent


def native():
    """The compiled module, under whatever name the add-on imported it."""
    return next(
        module for name, module in sys.modules.items() if name.rpartition(".")[2] == "sinew_native" and module
    )


def faces_of(mesh: bpy.types.Mesh) -> tuple[np.ndarray, np.ndarray]:
    """Corners per face (m,), and vertex indices face after face."""
    counts = np.empty(len(mesh.polygons), dtype=np.int32)
    corners = np.empty(len(mesh.loops), dtype=np.int32)
    mesh.polygons.foreach_get("loop_total", counts)
    mesh.loops.foreach_get("vertex_index", corners)
    return counts, corners


def members_of(obj: bpy.types.Object, group: str) -> tuple[np.ndarray, np.ndarray]:
    """Indices and weights of a vertex group."""
    index = obj.vertex_groups[group].index
    found = [
        (vertex.index, element.weight)
        for vertex in obj.data.vertices
        for element in vertex.groups
        if element.group == index and element.weight > 0.0
    ]
    return np.array([vertex for vertex, _ in found]), np.array([weight for _, weight in found])


def world(obj: bpy.types.Object) -> np.ndarray:
    """World matrix now, (4, 4)."""
    return np.array(obj.matrix_world, dtype=np.float64)


class Expected:
    """What a mesh with one handle and fixed regions must show. Made while the handle is at rest.

    ``points`` (n, 3) is the rest shape where it is not the mesh itself.
    """

    def __init__(
        self,
        obj: bpy.types.Object,
        control: bpy.types.Object,
        handle: str = "Top",
        fixed: tuple[str, ...] = ("Base",),
        method: str = "thin_shell",
        points: np.ndarray | None = None,
        **options: object,
    ) -> None:
        update()
        self._at_rest = np.linalg.inv(world(obj)) @ world(control)
        self._setup = (handle, fixed, method, options)
        self._solver = None
        self.rebind(obj, points)

    def rebind(self, obj: bpy.types.Object, points: np.ndarray | None = None) -> None:
        """Take the mesh and its vertex groups as they are now."""
        handle, fixed, method, options = self._setup
        rest = base_points(obj) if points is None else points
        groups = [members_of(obj, name) for name in (handle, *fixed)]
        mesh = native().SurfaceMesh(rest, faces_of(obj.data))
        self._solver = getattr(native(), _NATIVE[method])(mesh, **options)
        self._solver.set_handles([group[0] for group in groups], weights=[group[1] for group in groups])
        self._still = [np.eye(4)[:3]] * len(fixed)

    @classmethod
    def of(cls, plate: Rig, method: str = "thin_shell", **options: object) -> Expected:
        """Of the plate and its control, after ``plate.bind``."""
        return cls(plate.obj, plate.control, method=method, **options)

    def shape(self, pose: Matrix | np.ndarray, incoming: np.ndarray | None = None) -> np.ndarray:
        """With the handle moved by ``pose`` (4x4, object space) from rest, (n, 3)."""
        rows = np.array([np.array(pose)[:3], *self._still])
        return self._solver.solve(rows, incoming=incoming)[0]

    def now(
        self, obj: bpy.types.Object, control: bpy.types.Object, incoming: np.ndarray | None = None
    ) -> np.ndarray:
        """With the control where it is."""
        update()
        pose = np.linalg.inv(world(obj)) @ world(control) @ np.linalg.inv(self._at_rest)
        return self.shape(pose, incoming)

    def lifted(self, height: float) -> np.ndarray:
        """With the handle moved along z."""
        return self.shape(Matrix.Translation((0.0, 0.0, height)))


def rigid(obj: bpy.types.Object, motion: Matrix) -> np.ndarray:
    """The closed form for a mesh that one handle alone holds."""
    return apply_matrix(motion, base_points(obj))


def close(seen: np.ndarray, expected: np.ndarray, tolerance: float = FLOAT32) -> bool:
    """Equal up to ``tolerance`` a coordinate, with the same number of points."""
    return seen.shape == expected.shape and bool(np.abs(seen - expected).max() < tolerance)


def push(message: str) -> None:
    """An undo step, as the end of any user operation makes one."""
    update()
    bpy.ops.ed.undo_push(message=message)


_PROGRAM = """
import json, os, sys, traceback
sys.path.insert(0, {here!r})
{prelude}
import bpy, addon_utils
import numpy as np
from rig import Rig, base_points, evaluated_points, make_active, move_world, update
seen = {{}}
def run():
    if {addon!r}:
        addon_utils.enable({addon!r}, default_set=True)
{script}
try:
    run()
finally:
    seen["error"] = traceback.format_exc() if sys.exc_info()[0] else ""
    open({answer!r}, "w", encoding="utf-8").write(json.dumps(seen))
    sys.stdout.flush()
    os._exit(0)
"""


def another_blender(script: str, folder: Path, addon_name: str = "", prelude: str = "") -> dict:
    """Run ``script`` in a new Blender of this version; the dictionary ``seen`` that it fills.

    ``addon_name`` enables the add-on there; without, that Blender does not know it. ``prelude`` runs first.
    """
    program, answer = folder / "script.py", folder / "seen.json"
    body = textwrap.indent(textwrap.dedent(script), "    ")
    program.write_text(
        _PROGRAM.format(here=str(_HERE), prelude=prelude, addon=addon_name, script=body, answer=str(answer)),
        encoding="utf-8",
    )
    said = run_blender([], program)
    found = json.loads(answer.read_text(encoding="utf-8"))
    assert not found["error"], found["error"]
    assert "Traceback" not in said, said
    return found


def run_blender(arguments: list[str], program: Path, timeout: float = 120.0) -> str:
    """A Python file in a new background process of this Blender; what it printed."""
    if is_executable():
        command = [bpy.app.binary_path, "-b", "--factory-startup", *arguments]
        command += ["--python-use-system-env"] if "PYTHONPATH" in os.environ else []
        command += ["-P", str(program)]
    else:
        command = [sys.executable, str(program), *arguments]
    ended = subprocess.run(command, timeout=timeout, capture_output=True, text=True, check=False)
    return ended.stdout + ended.stderr


def is_executable() -> bool:
    """Blender runs Python, not the other way round."""
    return Path(bpy.app.binary_path).name.lower().startswith("blender")

# SPDX-License-Identifier: GPL-3.0-or-later
"""What a frame, a bind and an edit cost in Blender, next to Blender's Laplacian Deform and Mesh Deform.

    blender -b --factory-startup -P benchmarks/scripts/blender_frame.py -- [--small] OUT.json

or, with Blender as a module, ``python benchmarks/scripts/blender_frame.py`` with the same arguments. Sinew
and the peer are measured by turns, and their medians are compared.

A frame moves a control, lets Blender evaluate, and reads the positions of the evaluated mesh into an array.
"""

import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from functools import partial
from pathlib import Path
from timeit import timeit

import bpy
import numpy as np
from mathutils import Matrix

sys.path.insert(0, str(Path(__file__).resolve().parents[2] / "tests" / "blender" / "support"))

from installed import enable
from rigs.rig import make_active, update

ADDON = enable()
SMALL = "--small" in sys.argv  # for tests: a small plate and one round, since the times do not matter
SIDE = 40 if SMALL else 316  # vertices along a side: 99,856
BORDER = 0.95  # vertices beyond this share of [-1, 1] are held
CAGE_CUTS = 6
PATCH = 10  # vertices along a side of the handle that is added later


def room(path: str):
    return sys.modules[f"{ADDON}.{path}"]


def plate(side: int = SIDE) -> bpy.types.Object:
    """An uneven height field over [-1, 1]^2. Its groups are Top, Base, their union, and a patch inside."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    random = np.random.default_rng(0)
    y, x = np.meshgrid(*[np.linspace(-1.0, 1.0, side)] * 2, indexing="ij")
    points = np.stack((x, y, 0.05 * np.sin(7.0 * x) * np.cos(5.0 * y)), axis=-1)
    points[1:-1, 1:-1, :2] += random.uniform(-0.3, 0.3, (side - 2, side - 2, 2)) / side
    number = np.arange(side * side, dtype=np.int32).reshape(side, side)
    corners = np.stack((number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]), axis=-1)
    mesh = bpy.data.meshes.new("Plate")
    mesh.from_pydata(points.reshape(-1, 3).tolist(), [], corners.reshape(-1, 4).tolist())
    obj = linked("Plate", mesh)
    middle = slice(side // 2, side // 2 + PATCH)
    top, base = number[y > BORDER], number[y < -BORDER]
    patch, both = number[middle, middle], np.concatenate((top, base))
    for name, members in {"Top": top, "Base": base, "Anchors": both, "Patch": patch}.items():
        obj.vertex_groups.new(name=name).add(members.ravel().tolist(), 1.0, "REPLACE")
    make_active(obj)
    return obj


def deformer_on(obj: bpy.types.Object, method: str):
    """Add a deformer of Sinew with a handle and a fixed region, and bind it."""
    make_active(obj)
    bpy.ops.sinew.deformer_add(method=method)
    with room("session.state.sessions").suspended():  # bind once, instead of once per region
        add_regions(obj, FIXED="Base", HANDLE="Top")
    bpy.ops.sinew.bind()
    return obj.sinew.active


def add_regions(obj: bpy.types.Object, **groups: str) -> list:
    """Add regions by their roles to the active deformer; no bind."""
    handles = room("session.actions.handles.handles")
    regions = [handles.NewRegion(role, group) for role, group in groups.items()]
    return [handles.add_handle(obj, obj.sinew.active, region) for region in regions]


def laplacian_deform_on(obj: bpy.types.Object, control: bpy.types.Object, repeat: int):
    """Add a Hook, which moves the handle, and Laplacian Deform for the rest, which is not bound yet."""
    hook = obj.modifiers.new("Hook", "HOOK")
    hook.object, hook.vertex_group = control, "Top"
    hook.matrix_inverse = control.matrix_world.inverted()
    modifier = obj.modifiers.new("Laplacian Deform", "LAPLACIANDEFORM")
    modifier.vertex_group, modifier.iterations = "Anchors", repeat
    return modifier


def bind_laplacian_deform(obj: bpy.types.Object, modifier) -> None:
    """Bind Laplacian Deform, and evaluate it once, which computes the factor."""
    bind_peer(obj, modifier, bpy.ops.object.laplaciandeform_bind, "is_bind")


def bind_peer(obj: bpy.types.Object, modifier, operator: Callable, bound: str) -> None:
    with bpy.context.temp_override(object=obj, active_object=obj):
        operator(modifier=modifier.name)
    update()
    if not getattr(modifier, bound):
        raise RuntimeError(f"{modifier.name} is not bound")


def linked(name: str, data: bpy.types.ID | None) -> bpy.types.Object:
    obj = bpy.data.objects.new(name, data)
    bpy.context.scene.collection.objects.link(obj)
    return obj


def peer_of(obj: bpy.types.Object) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A copy of the mesh without Sinew, and a control for it."""
    peer, control = linked("Peer", obj.data.copy()), linked("Peer Control", None)
    for group in obj.vertex_groups:
        peer.vertex_groups.new(name=group.name)
    update()
    return peer, control


def motion(number: int) -> Matrix:
    """The motion of a control in a frame: about a lift by .4 and a turn by 35 degrees, never the same."""
    turn = Matrix.Rotation(math.radians(35.0 + 2.0 * math.sin(number)), 4, "X")
    return Matrix.Translation((0.0, 0.0, 0.4 + 0.01 * math.cos(number))) @ turn


def read_back(obj: bpy.types.Object, flat: np.ndarray) -> np.ndarray:
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    attribute = mesh.attributes.get("position")
    attribute.data.foreach_get("vector", flat) if attribute else mesh.vertices.foreach_get("co", flat)
    return flat


class Frames:
    """Runs frames of one object, whose control starts at ``rest``."""

    def __init__(self, obj: bpy.types.Object, control: bpy.types.Object) -> None:
        self.obj, self.control = obj, control
        self.rest = control.matrix_world.copy()
        self.flat = np.empty(len(obj.data.vertices) * 3, dtype=np.float32)

    def __call__(self, number: int) -> None:
        self.control.matrix_world = motion(number) @ self.rest
        update()
        read_back(self.obj, self.flat)

    def moved(self) -> float:
        """The largest distance of a vertex from rest, to check that something moves in the timed frames."""
        rest = np.empty_like(self.flat)
        self.obj.data.vertices.foreach_get("co", rest)
        return float(np.abs(self.flat - rest).max())


class CageFrames(Frames):
    """Moves the vertices of a cage, as in Edit Mode, since Mesh Deform ignores moves of the cage object."""

    def __init__(self, obj: bpy.types.Object, cage: bpy.types.Object) -> None:
        super().__init__(obj, cage)
        self.points = np.array([(*vertex.co, 1.0) for vertex in cage.data.vertices])

    def __call__(self, number: int) -> None:
        mesh, posed = self.control.data, self.points @ np.array(motion(number)).T
        mesh.vertices.foreach_set("co", posed[:, :3].astype(np.float32).ravel())
        mesh.update()
        update()
        read_back(self.obj, self.flat)


@contextmanager
def dragged() -> Iterator[None]:
    """Let the handler do what it does in a window while a control is dragged."""
    handlers, ours = bpy.app.handlers.depsgraph_update_post, room("handlers.evaluation").on_depsgraph_update
    update_all = room("session.evaluation.evaluate").update

    def handler(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        update_all(depsgraph, preview=True, edit=True)

    handlers.remove(ours)
    handlers.append(handler)
    try:
        yield
    finally:
        handlers.remove(handler)
        handlers.append(ours)


timed = partial(timeit, number=1)  # the seconds of a call
SPENT: dict[str, float] = {}  # the seconds in functions, by their names, until it is cleared


def count(owner: object, name: str) -> None:
    """Let SPENT tell how long the calls of a function take. ``timed`` would add a tenth of a millisecond."""
    call = getattr(owner, name)

    def counted(*arguments, **keywords):
        begin = time.perf_counter()
        try:
            return call(*arguments, **keywords)
        finally:
            SPENT[name] = SPENT.get(name, 0.0) + time.perf_counter() - begin

    setattr(owner, name, counted)


def medians(ours: Frames, peer: Frames, rounds: int) -> dict[str, float]:
    """Medians of frames that run by turns; for ours also those of the native solve and of the rest."""
    rounds, warm = (1, 1) if SMALL else (rounds, 3)
    times: dict[str, list[float]] = {"ours": [], "peer": [], "native_ms": [], "around_ms": []}
    for number in range(rounds + warm):
        SPENT.clear()
        spent, native = timed(partial(ours, number)), SPENT.get("solve", 0.0)
        other = timed(partial(peer, number))
        if number >= warm:
            for name, value in zip(times, (spent, other, 1e3 * native, 1e3 * (spent - native))):
                times[name].append(value)
    if min(ours.moved(), peer.moved()) < 0.1:
        raise RuntimeError("nothing moved")
    return {name: float(np.median(values)) for name, values in times.items()}


def frame(method: str, repeat: int, drag: bool = False) -> dict[str, float]:
    """A whole frame, next to one of Laplacian Deform."""
    obj = plate()
    deformer = deformer_on(obj, method)
    peer, control = peer_of(obj)
    bind_laplacian_deform(peer, laplacian_deform_on(peer, control, repeat))
    with dragged() if drag else nullcontext():
        return medians(Frames(obj, deformer.handles[1].control), Frames(peer, control), 9)


def box_around(obj: bpy.types.Object) -> bpy.types.Object:
    """A closed cage of 296 vertices around the plate."""
    import bmesh  # it is part of bpy, and can be imported only after it

    mesh = bpy.data.meshes.new("Cage")
    made = bmesh.new()
    bmesh.ops.create_cube(made, size=2.0, matrix=Matrix.Diagonal((1.1, 1.1, 0.3, 1.0)))
    bmesh.ops.subdivide_edges(made, edges=made.edges[:], cuts=CAGE_CUTS, use_grid_fill=True)
    made.to_mesh(mesh)
    made.free()
    cage = linked("Cage", mesh)
    update()
    return cage


def cage_frame(method: str) -> dict[str, float]:
    """A whole frame with a cage, next to one of Mesh Deform."""
    obj = plate()
    peer, _control = peer_of(obj)
    cage, other = box_around(obj), box_around(obj)
    make_active(obj)
    bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name, method=method)
    modifier = peer.modifiers.new("Mesh Deform", "MESH_DEFORM")
    modifier.object, modifier.precision = other, 5
    bind_peer(peer, modifier, bpy.ops.object.meshdeform_bind, "is_bound")
    return medians(CageFrames(obj, cage), CageFrames(peer, other), 21)


def first_frame(method: str) -> dict[str, float]:
    """The bind and the first frame, next to the bind of Laplacian Deform, which takes 13 s."""
    ours, theirs = [], []
    for number in range(1 if SMALL else 2):
        obj = plate()
        deformer_on(obj, method)
        bpy.ops.sinew.unbind()
        frames = Frames(obj, obj.sinew.active.handles[1].control)
        make_active(obj)

        def bind_and_show(frames: Frames = frames, number: int = number) -> None:
            bpy.ops.sinew.bind()
            frames(number)

        ours.append(timed(bind_and_show))
        obj = plate()
        peer, control = peer_of(obj)
        modifier = laplacian_deform_on(peer, control, 1)
        theirs.append(timed(partial(bind_laplacian_deform, peer, modifier)))
    return {"ours": float(np.median(ours)), "peer": float(np.median(theirs))}


def rebind() -> dict[str, float]:
    """One more handle for a bound thin shell, next to a new bind."""
    times: dict[str, list[float]] = {"ours": [], "peer": []}
    obj = plate()
    deformer = deformer_on(obj, "thin_shell")
    bind, handles = room("session.actions.bind").bind, room("session.actions.handles.handles")
    for _ in range(1 if SMALL else 5):
        (handle,) = add_regions(obj, HANDLE="Patch")
        for name in times:
            if name == "peer":
                room("core.memory").forget_all()
            # The operator is not used, since Blender evaluates before it runs one, which would bind already.
            times[name].append(timed(partial(bind, obj, deformer)))
        index = next(i for i, other in enumerate(deformer.handles) if other.uid == handle.uid)
        handles.remove_handle(obj, deformer, index)
        bpy.ops.sinew.bind()
    return {name: float(np.median(values)) for name, values in times.items()}


def subdivision_frame() -> dict[str, float]:
    """What a frame of Fast Subdivision takes but for ``refine`` and the lattice, next to its bare write."""
    obj, times, names = (
        plate(20 if SMALL else 129),
        [],
        ("update", "_update_deformer", "refine", "write_positions"),
    )
    bpy.ops.sinew.lattice_add()
    obj.modifiers.new("Subdivision", "SUBSURF").levels = 3
    bpy.ops.sinew.fast_subdivision()
    evaluate, refined = (room(f"session.evaluation.{name}") for name in ("evaluate", "refined"))
    owners = evaluate, evaluate, room("backend.surfaces").RefinedSurface, refined
    for owner, name in zip(owners, names):
        count(owner, name)
    for number in range(1 if SMALL else 30):
        SPENT.clear()
        obj.sinew.active.controls[0].object.matrix_world @= motion(number)
        update()
        whole, lattice, refine, write = (SPENT[name] for name in names)
        times.append((whole - lattice - refine, write))
    return dict(zip(("ours", "peer"), map(float, np.median(times, axis=0))))


ROWS: dict[str, Callable[[], dict[str, float]]] = {
    "frame_thin_shell": lambda: frame("thin_shell", 1),
    "frame_arap": lambda: frame("arap", 3),
    "drag_arap": lambda: frame("arap", 3, drag=True),
    "frame_cage": lambda: cage_frame("mean_value"),
    "first_thin_shell": lambda: first_frame("thin_shell"),
    "rebind_handle": rebind,
    "frame_subdivision": subdivision_frame,
}


def main() -> None:
    count(room("backend.native").Factor, "solve")
    about = {"vertices": SIDE * SIDE, "blender": bpy.app.version_string}
    rows = [{"work": work, **about, **measure()} for work, measure in ROWS.items()]
    Path(sys.argv[-1]).write_text(json.dumps(rows), encoding="utf-8")
    os._exit(0)  # Blender as a module may hang or crash when it ends


main()

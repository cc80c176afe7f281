# SPDX-License-Identifier: GPL-3.0-or-later
"""What a frame, a bind and an edit cost in Blender, next to Blender's Laplacian Deform and Mesh Deform.

    blender -b --factory-startup -P benchmarks/blender_frame.py -- [ROW ...] [--small] [--json FILE]

or, with Blender as a module, ``python benchmarks/blender_frame.py`` with the same arguments. Each row
takes less than a minute. Sinew and the peer are measured by turns, and their medians are compared.

A frame moves a control, lets Blender evaluate, and reads the positions of the evaluated mesh into an array.
"""

import argparse
import json
import math
import os
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from pathlib import Path

import bpy
import numpy as np
from mathutils import Matrix

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "tests" / "blender" / "support")]

from installed import enable  # noqa: E402
from rigs.rig import make_active, update  # noqa: E402

ADDON = enable()
SMALL = "--small" in sys.argv  # for tests: a small plate and one round, since the times do not matter
SIDE = 40 if SMALL else 316  # vertices along a side: 99,856
LARGE_SIDE = 40 if SMALL else 1000
BORDER = 0.95  # vertices beyond this share of [-1, 1] are held
CAGE_CUTS = 6
PATCH = 10  # vertices along a side of the handle that is added later


def room(path: str):
    """Import a room of the add-on."""
    return sys.modules[f"{ADDON}.{path}"]


def plate(side: int) -> bpy.types.Object:
    """An uneven height field over [-1, 1]^2. Its groups are Top, Base, their union, and a patch inside."""
    bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
    random = np.random.default_rng(0)
    y, x = np.meshgrid(*[np.linspace(-1.0, 1.0, side)] * 2, indexing="ij")
    points = np.stack((x, y, 0.05 * np.sin(7.0 * x) * np.cos(5.0 * y)), axis=-1)
    points[1:-1, 1:-1, :2] += random.uniform(-0.3, 0.3, (side - 2, side - 2, 2)) / side
    number = np.arange(side * side, dtype=np.int32).reshape(side, side)
    corners = np.stack((number[:-1, :-1], number[:-1, 1:], number[1:, 1:], number[1:, :-1]), axis=-1)
    mesh = bpy.data.meshes.new("Plate")
    mesh.vertices.add(side * side)
    mesh.vertices.foreach_set("co", points.astype(np.float32).ravel())
    mesh.loops.add(corners.size)
    mesh.loops.foreach_set("vertex_index", corners.ravel())
    mesh.polygons.add(corners.size // 4)
    mesh.polygons.foreach_set("loop_start", np.arange(0, corners.size, 4, dtype=np.int32))
    mesh.polygons.foreach_set("loop_total", np.full(corners.size // 4, 4, dtype=np.int32))
    mesh.update(calc_edges=True)
    obj = bpy.data.objects.new("Plate", mesh)
    bpy.context.scene.collection.objects.link(obj)
    middle = slice(side // 2, side // 2 + PATCH)
    top, base = number[y > BORDER], number[y < -BORDER]
    groups = {
        "Top": top,
        "Base": base,
        "Anchors": np.concatenate((top, base)),
        "Patch": number[middle, middle],
    }
    for name, members in groups.items():
        obj.vertex_groups.new(name=name).add(members.ravel().tolist(), 1.0, "REPLACE")
    everywhere = obj.vertex_groups.new(name="Stiffness")
    everywhere.add(number.ravel().tolist(), 1.0, "REPLACE")
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
    return [
        handles.add_handle(obj, obj.sinew.active, handles.NewRegion(role, group))
        for role, group in groups.items()
    ]


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
    with bpy.context.temp_override(object=obj, active_object=obj):
        bpy.ops.object.laplaciandeform_bind(modifier=modifier.name)
    update()
    if not modifier.is_bind:
        raise RuntimeError("Laplacian Deform is not bound")


def peer_of(obj: bpy.types.Object) -> tuple[bpy.types.Object, bpy.types.Object]:
    """A copy of the mesh without Sinew, and a control for it."""
    peer = bpy.data.objects.new("Peer", obj.data.copy())
    for group in obj.vertex_groups:
        peer.vertex_groups.new(name=group.name)
    control = bpy.data.objects.new("Peer Control", None)
    for made in (peer, control):
        bpy.context.scene.collection.objects.link(made)
    update()
    return peer, control


def motion(number: int) -> Matrix:
    """The motion of a control in frame ``number``: about a lift by .4 and a turn by 35 degrees, never the
    same.
    """
    turn = Matrix.Rotation(math.radians(35.0 + 2.0 * math.sin(number)), 4, "X")
    return Matrix.Translation((0.0, 0.0, 0.4 + 0.01 * math.cos(number))) @ turn


def read_back(obj: bpy.types.Object, flat: np.ndarray) -> np.ndarray:
    """Read the positions of the evaluated mesh."""
    mesh = obj.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    attribute = mesh.attributes.get("position")
    if attribute is not None:
        attribute.data.foreach_get("vector", flat)
    else:
        mesh.vertices.foreach_get("co", flat)
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


class LatticeFrames(Frames):
    """Moves the points of a lattice, as in Edit Mode."""

    def __init__(self, obj: bpy.types.Object, lattice: bpy.types.Object) -> None:
        super().__init__(obj, lattice)
        self.points = np.array([(*point.co_deform, 1.0) for point in lattice.data.points])

    def __call__(self, number: int) -> None:
        data, posed = self.control.data, self.points @ np.array(motion(number)).T
        data.points.foreach_set("co_deform", posed[:, :3].astype(np.float32).ravel())
        data.update_tag()
        update()
        read_back(self.obj, self.flat)


class Bare:
    """A copy of the object that the add-on does not handle: it writes a shape, evaluates the modifier, and
    reads.
    """

    def __init__(self, obj: bpy.types.Object, deformer) -> None:
        compat, inputs = room("compat"), room("ids").Inputs
        shapes = [deformer.proxy, deformer.proxy_render]
        modifier = room("session.targets.modified").shown_by(obj, deformer).name
        self.obj = bpy.data.objects.new("Bare", obj.data)
        made = self.obj.modifiers.new(modifier, "NODES")
        empty, made.node_group = made.node_group, obj.modifiers[modifier].node_group
        if empty is not None:
            bpy.data.node_groups.remove(empty)
        for name in (inputs.INCOMING, inputs.INDEX):
            compat.set_modifier_input(made, name, f".bare_{name.replace(' ', '_')}")
        for name, shape in zip((inputs.PROXY_VIEWPORT, inputs.PROXY_RENDER), shapes, strict=True):
            compat.set_modifier_input(made, name, bpy.data.objects.new("Bare", shape.data.copy()))
        self.shape = compat.modifier_input(made, inputs.PROXY_VIEWPORT).data
        bpy.context.scene.collection.objects.link(self.obj)
        self.flat = np.empty(len(obj.data.vertices) * 3, dtype=np.float32)
        self.frames = []
        for height in (0.1, 0.2):
            points = np.empty_like(self.flat)
            obj.data.vertices.foreach_get("co", points)
            self.frames.append(np.concatenate((points + np.float32(height), np.float32((1.0, 0.0, 0.0)))))
        with silent():
            update()

    def __call__(self, number: int) -> None:
        flat = self.frames[number % 2]
        attribute = self.shape.attributes.get("position")
        if attribute is not None:
            attribute.data.foreach_set("vector", flat)
        else:
            self.shape.vertices.foreach_set("co", flat)
        self.shape.update_tag()
        update()
        read_back(self.obj, self.flat)
        if abs(self.flat[0] - flat[0]) > 1e-5:
            raise RuntimeError("the written shape is not shown")


@contextmanager
def silent() -> Iterator[None]:
    """Remove all handlers for a while."""
    handlers = bpy.app.handlers.depsgraph_update_post
    kept = list(handlers)
    handlers.clear()
    try:
        yield
    finally:
        handlers.extend(kept)


@contextmanager
def evaluated(**how: bool) -> Iterator[None]:
    """Let the handler do what it does in a window: with ``preview`` and ``edit`` while a control is dragged,
    with ``draft`` while frames play and *Playback* is *Draft*."""
    handlers, ours = bpy.app.handlers.depsgraph_update_post, room("handlers.evaluation").on_depsgraph_update
    update_all = room("session.evaluation.evaluate").update

    def handler(_scene: bpy.types.Scene, depsgraph: bpy.types.Depsgraph) -> None:
        update_all(depsgraph, **how)

    handlers.remove(ours)
    handlers.append(handler)
    try:
        yield
    finally:
        handlers.remove(handler)
        handlers.append(ours)


class Spent:
    """Counts the seconds that functions of the add-on take, in the modules that call them."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self.reports: list = []

    def around(self, owner: object, name: str) -> None:
        """Count the seconds of ``owner.name``."""
        inner = getattr(owner, name)

        def timed(*arguments, **keywords):
            begin = time.perf_counter()
            try:
                result = inner(*arguments, **keywords)
            finally:
                self.seconds += time.perf_counter() - begin
            self.reports.append(result)
            return result

        setattr(owner, name, timed)

    def take(self) -> float:
        """The seconds since the last call."""
        seconds, self.seconds, self.reports = self.seconds, 0.0, self.reports[-1:]
        return seconds


SOLVE = Spent()
SOLVE.around(room("backend.native").Factor, "solve")


def timed(call: Callable[[], object]) -> float:
    """The time of a call, in milliseconds."""
    begin = time.perf_counter()
    call()
    return (time.perf_counter() - begin) * 1000.0


def medians(calls: dict[str, Callable[[int], object]], rounds: int, warm: int = 3) -> dict[str, float]:
    """Medians of calls that run by turns; for "ours" also those of the native solve and of the rest."""
    rounds, warm = (1, 1) if SMALL else (rounds, warm)
    times: dict[str, list[float]] = {name: [] for name in (*calls, "native", "around")}
    for number in range(rounds + warm):
        for name, call in calls.items():
            SOLVE.take()
            spent = timed(lambda call=call, number=number: call(number))
            if number < warm:
                continue
            times[name].append(spent)
            if name == "ours":
                times["native"].append(SOLVE.take() * 1000.0)
                times["around"].append(spent - times["native"][-1])
    return {f"{name}_ms": float(np.median(values)) for name, values in times.items() if values}


def frame(
    method: str, repeat: int, drag: bool = False, draft: bool = False, goal: float = 0.0, **parameters: object
) -> dict[str, object]:
    """A whole frame, next to one of Laplacian Deform."""
    obj = plate(SIDE)
    deformer = deformer_on(obj, method)
    for name, value in parameters.items():
        setattr(deformer.parameters, name, value)
    deformer.playback = "DRAFT" if draft else "FULL"
    peer, control = peer_of(obj)
    bind_laplacian_deform(peer, laplacian_deform_on(peer, control, repeat))
    ours, theirs = Frames(obj, deformer.handles[1].control), Frames(peer, control)
    with evaluated(preview=True, edit=True) if drag else evaluated(draft=True) if draft else nullcontext():
        found = medians({"ours": ours, "peer": theirs}, 9)
    if min(ours.moved(), theirs.moved()) < 0.1:
        raise RuntimeError("nothing moved")
    report = SOLVE.reports[-1][1]
    found |= {"iterations": report.iterations, "peer_repeat": repeat}
    return {**found, "ratio": found["peer_ms"] / found["ours_ms"], "goal": goal}


def box_around(obj: bpy.types.Object) -> bpy.types.Object:
    """A closed cage of 296 vertices around the plate."""
    import bmesh  # it is part of bpy, and can be imported only after it

    mesh = bpy.data.meshes.new("Cage")
    made = bmesh.new()
    bmesh.ops.create_cube(made, size=2.0, matrix=Matrix.Diagonal((1.1, 1.1, 0.3, 1.0)))
    bmesh.ops.subdivide_edges(made, edges=made.edges[:], cuts=CAGE_CUTS, use_grid_fill=True)
    made.to_mesh(mesh)
    made.free()
    cage = bpy.data.objects.new("Cage", mesh)
    bpy.context.scene.collection.objects.link(cage)
    update()
    return cage


def cage_frame(method: str) -> dict[str, object]:
    """A whole frame with a cage, next to one of Mesh Deform."""
    obj = plate(SIDE)
    peer, _control = peer_of(obj)
    cage, other = box_around(obj), box_around(obj)
    make_active(obj)
    bpy.ops.sinew.cage_add(source="OBJECT", cage=cage.name, method=method)
    modifier = peer.modifiers.new("Mesh Deform", "MESH_DEFORM")
    modifier.object, modifier.precision = other, 5
    with bpy.context.temp_override(object=peer, active_object=peer):
        bpy.ops.object.meshdeform_bind(modifier=modifier.name)
    update()
    if not modifier.is_bound:
        raise RuntimeError("Mesh Deform is not bound")
    ours, theirs = CageFrames(obj, cage), CageFrames(peer, other)
    found = medians({"ours": ours, "peer": theirs}, 21)
    if min(ours.moved(), theirs.moved()) < 0.1:
        raise RuntimeError("nothing moved")
    found["cage_vertices"] = len(cage.data.vertices)
    return {**found, "ratio": found["peer_ms"] / found["ours_ms"], "goal": 1.0}


def overhead(method: str, rounds: int, drag: bool = False) -> dict[str, object]:
    """A frame without its native solve, next to writing a shape and evaluating it once."""
    obj = plate(SIDE)
    deformer = deformer_on(obj, method)
    ours, bare = Frames(obj, deformer.handles[1].control), Bare(obj, deformer)

    def unheard(number: int) -> None:
        with silent():
            bare(number)

    with evaluated(preview=True, edit=True) if drag else nullcontext():
        found = medians({"ours": ours, "bare": unheard}, rounds)
    if ours.moved() < 0.1:
        raise RuntimeError("nothing moved")
    return {**found, "ratio": found["around_ms"] / found["bare_ms"], "goal": 1.2, "at_most": True}


def lattice_around(obj: bpy.types.Object) -> bpy.types.Object:
    """A lattice of 4 x 4 x 4 points and B-splines around the plate."""
    lattice = bpy.data.objects.new("Lattice", bpy.data.lattices.new("Lattice"))
    lattice.data.points_u = lattice.data.points_v = lattice.data.points_w = 4
    lattice.scale = (0.75, 0.75, 0.2)
    bpy.context.scene.collection.objects.link(lattice)
    update()
    return lattice


def lattice_frame(bare: bool) -> dict[str, object]:
    """A frame with a lattice of a million vertices: ``warp`` next to Blender's Lattice modifier alone.

    Or, ``bare``, what else it takes, next to writing a shape and evaluating it once.

    The modifier alone is half of what two more of them add to a frame.
    """
    obj = plate(LARGE_SIDE)
    lattice = lattice_around(obj)
    make_active(obj)
    bpy.ops.sinew.lattice_add(source="OBJECT", lattice=lattice.name)
    ours = LatticeFrames(obj, lattice)
    if bare:
        alone = Bare(obj, obj.sinew.active)

        def unheard(number: int) -> None:
            with silent():
                alone(number)

        found = medians({"ours": ours, "bare": unheard}, 9) | {"vertices": len(obj.data.vertices)}
        return {**found, "ratio": found["around_ms"] / found["bare_ms"], "goal": 1.3, "at_most": True}
    calls: dict[str, Callable[[int], object]] = {"ours": ours}
    for name, count in (("one", 1), ("three", 3)):
        peer, _control = peer_of(obj)
        other = lattice_around(peer)
        for _ in range(count):
            peer.modifiers.new("Lattice", "LATTICE").object = other
        calls[name] = LatticeFrames(peer, other)
    found = medians(calls, 9)
    if min(call.moved() for call in calls.values()) < 0.1:
        raise RuntimeError("nothing moved")
    found |= {"vertices": len(obj.data.vertices), "peer_ms": 0.5 * (found["three_ms"] - found["one_ms"])}
    return {**found, "ratio": found["peer_ms"] / found["native_ms"], "goal": 3.0}


def bind(method: str, rounds: int = 3) -> dict[str, object]:
    """The bind and the first frame, next to the bind of Laplacian Deform."""
    ours, theirs = [], []
    rounds = 2 if SMALL else rounds
    for number in range(rounds):
        obj = plate(SIDE)
        deformer_on(obj, method)
        bpy.ops.sinew.unbind()
        control = obj.sinew.active.handles[1].control
        frames = Frames(obj, control)
        make_active(obj)

        def first_frame(frames: Frames = frames, number: int = number) -> None:
            bpy.ops.sinew.bind()
            frames(number)

        ours.append(timed(first_frame))
        if number == rounds - 1:
            continue  # it takes 13 s per round
        obj = plate(SIDE)
        peer, control = peer_of(obj)
        modifier = laplacian_deform_on(peer, control, 1)
        theirs.append(timed(lambda peer=peer, modifier=modifier: bind_laplacian_deform(peer, modifier)))
    found = {"ours_ms": float(np.median(ours)), "peer_ms": float(np.median(theirs))}
    return {**found, "ratio": found["peer_ms"] / found["ours_ms"], "goal": 10.0}


def reading(method: str) -> dict[str, object]:
    """Reading a large mesh with its vertex groups, next to the whole bind."""
    obj = plate(LARGE_SIDE)
    make_active(obj)
    bpy.ops.sinew.deformer_add(method=method)
    add_regions(obj, FIXED="Base", HANDLE="Top")
    spent = Spent()
    steps = [
        (room("session.datablocks.shapes.capture"), "rest_meshes"),
        (room("session.datablocks.rest_frame"), "read"),
        (room("session.controls.handles.kind"), "request"),
    ]
    for owner, name in steps:
        spent.around(owner, name)
    whole = timed(bpy.ops.sinew.bind)
    if len(spent.reports) != len(steps):
        raise RuntimeError("a step of reading was not timed")
    found = {"vertices": len(obj.data.vertices), "reading_ms": spent.take() * 1000.0, "bind_ms": whole}
    return {**found, "ratio": found["reading_ms"] / whole, "goal": 0.1, "at_most": True}


def rebind(what: str, rounds: int = 5) -> dict[str, object]:
    """One more handle, or painted stiffness, for a bound thin shell, next to a new bind.

    ``native`` is the time in the native module, the rest is Blender's and ours.
    """
    times: dict[str, list[float]] = {"edit": [], "new": [], "edit_native": [], "new_native": []}
    obj = plate(SIDE)
    deformer = deformer_on(obj, "thin_shell")
    if what == "stiffness":
        deformer.thin_shell.bending_group = "Stiffness"
        bpy.ops.sinew.bind()
    bind, sessions = room("session.actions.bind").bind, room("session.state.sessions")
    for number in range(1 if SMALL else rounds):
        if what == "handle":
            (handle,) = add_regions(obj, HANDLE="Patch")
        else:
            first = SIDE * SIDE // 2 + number * PATCH**2
            members = list(range(first, first + PATCH**2))
            obj.vertex_groups["Stiffness"].add(members, 0.5, "REPLACE")
        for which in ("edit", "new"):
            if which == "new":
                room("core.memory").forget_all()
            # The operator is not used, since Blender evaluates before it runs one, which would bind already.
            times[which].append(timed(lambda: bind(obj, deformer)))
            times[f"{which}_native"].append(sessions.find(deformer.uid).bound.milliseconds)
        if what == "handle":
            index = next(i for i, other in enumerate(deformer.handles) if other.uid == handle.uid)
            room("session.actions.handles.handles").remove_handle(obj, deformer, index)
            bpy.ops.sinew.bind()
    found = {f"{name}_ms": float(np.median(values)) for name, values in times.items()}
    return {**found, "ratio": found["new_ms"] / found["edit_ms"], "goal": 2.0}


ROWS: dict[str, Callable[[], dict[str, object]]] = {
    "frame thin_shell": lambda: frame("thin_shell", 1, goal=20.0),
    "frame laplacian_editing": lambda: frame("laplacian_editing", 1, goal=10.0),
    "frame explicit laplacian_editing": lambda: frame(
        "laplacian_editing", 1, goal=10.0, transforms="explicit"
    ),
    "frame arap": lambda: frame("arap", 3, goal=8.0),
    "frame short arap": lambda: frame("arap", 3, goal=8.0, max_iterations=3),
    "frame draft arap": lambda: frame("arap", 3, draft=True, goal=8.0),
    "frame cage": lambda: cage_frame("mean_value"),
    "frame lattice": lambda: lattice_frame(bare=False),
    "overhead lattice": lambda: lattice_frame(bare=True),
    "drag arap": lambda: frame("arap", 3, drag=True, goal=8.0),
    "overhead thin_shell": lambda: overhead("thin_shell", 101),
    "overhead drag arap": lambda: overhead("arap", 31, drag=True),
    "bind thin_shell": lambda: bind("thin_shell"),
    "bind arap": lambda: bind("arap"),
    "reading thin_shell": lambda: reading("thin_shell"),
    "reading arap": lambda: reading("arap"),
    "rebind handle": lambda: rebind("handle"),
    "rebind stiffness": lambda: rebind("stiffness"),
}


def main() -> None:
    arguments = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("rows", nargs="*", help=f"beginnings of: {', '.join(ROWS)}; without, all")
    parser.add_argument("--small", action="store_true", help="each row once, on a little plate")
    parser.add_argument("--json", type=Path, help="where to store the rows")
    options = parser.parse_args(arguments if bpy.app.binary_path else sys.argv[1:])
    rows = []
    for name, measure in ROWS.items():
        if options.rows and not name.startswith(tuple(options.rows)):
            continue
        row = {"row": name, "blender": bpy.app.version_string, "vertices": SIDE * SIDE, **measure()}
        rows.append(row)
        met = row["ratio"] <= row["goal"] if row.get("at_most") else row["ratio"] >= row["goal"]
        times = "  ".join(f"{key[:-3]} {row[key]:.2f}" for key in row if key.endswith("_ms"))
        mark = "" if met else f"  misses {row['goal']}"
        print(f"{name:20} {bpy.app.version_string:10} {row['ratio']:8.3f}{mark}   ms: {times}", flush=True)
        if options.json:
            options.json.write_text(json.dumps({"rows": rows}, indent=1) + "\n", encoding="utf-8")
    os._exit(0)  # Blender as a module may hang or crash when it ends


if __name__ == "__main__":  # system_frame.py takes parts of it
    main()

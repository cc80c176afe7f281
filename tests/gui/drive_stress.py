# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: playback, viewport render, F12 during a drag, a long render while the
viewport lives on, unlocked, and Blender's own autosave.
"""

import os
import sys
import threading
import time
from collections.abc import Callable

import bpy
import numpy as np
from driving import MODULE, OUTPUT, binding, enable, in_view, play, seen, sessions, until, viewport, window
from mathutils import Matrix

enable()

from expected import Expected  # noqa: E402 - needs the add-on
from probe import Probe  # noqa: E402
from rigs.rig import Rig, grid_object, make_active  # noqa: E402

FRAMES = int(os.environ["SINEW_STRESS_FRAMES"])
STEP = 1.0 / FRAMES  # what the control rises in one frame
# Cycles shows its image through OpenGL, from threads of its own: in Mesa's software driver that crashes
# now and then, whatever it renders. So most frames go to an engine that draws nothing.
CYCLES_FRAMES = FRAMES // 10
TILT = 0.3
# Moves at any moment: that crashes Blender itself, see docs/developer/decisions/unlocked-renders.md.
WILD = "SINEW_STRESS_WILD" in os.environ


class Stage:
    """The plate, and what it must show."""

    def __init__(self) -> None:
        for obj in list(bpy.data.objects):
            bpy.data.objects.remove(obj)
        self.rig = Rig(grid_object("Plate", cells=24))
        self.rig.bind("thin_shell")
        self.expected = Expected.of_rig(self.rig)
        self.rig.obj.rotation_euler.x = TILT  # else the camera sees an edge
        self.dragged = Rig(grid_object("Dragged", cells=16))
        self.dragged.bind("arap")
        self.dragged_expected = Expected.of_rig(self.dragged, "arap")
        self.dragged.obj.location.x = 50.0
        control = self.rig.control
        self._add_follower(control)
        for frame in (0, FRAMES):
            control.location.z = STEP * frame
            control.keyframe_insert("location", frame=frame)
        for curve in curves_of(control):
            for key in curve.keyframe_points:
                key.interpolation = "LINEAR"
        scene = bpy.context.scene
        scene.camera = bpy.data.objects.new("Camera", bpy.data.cameras.new("Camera"))
        scene.collection.objects.link(scene.camera)
        scene.camera.data.type, scene.camera.data.ortho_scale = "ORTHO", 6.0
        scene.camera.matrix_world = Matrix.Translation((0.0, -10.0, 0.0)) @ Matrix.Rotation(np.pi / 2, 4, "X")
        scene.render.resolution_x = scene.render.resolution_y = 16
        scene.render.resolution_percentage = 100
        scene.render.filepath = str(OUTPUT / "frames" / "f")
        scene.render.use_file_extension = True
        if hasattr(scene, "cycles"):
            scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = 1, False, "CPU"
        make_active(self.dragged.obj)

    def _add_follower(self, control: bpy.types.Object) -> None:
        """A mesh that follows a lattice, which the control of the plate moves, too."""
        self.lattice = bpy.data.objects.new("Lattice", bpy.data.lattices.new("Lattice"))
        self.follower = grid_object("Follower", cells=4)
        self.follower.scale = 0.2, 0.2, 0.2
        bpy.context.scene.collection.objects.link(self.lattice)
        for obj in (self.lattice, self.follower):
            obj.location.x = 30.0
        self.follower.modifiers.new("Lattice", "LATTICE").object = self.lattice
        bpy.context.view_layer.update()
        self.follower_rest = shown(self.follower)
        make_active(self.lattice)
        control.select_set(True)
        bpy.ops.sinew.point_add(source="SELECTED", method="mls")

    def follower_error(self, height: float, places: np.ndarray | None = None) -> float:
        places = shown(self.follower) if places is None else places
        rise = height / self.follower.scale.z * np.array((0.0, -np.sin(TILT), np.cos(TILT)))
        return float(np.abs(places - self.follower_rest - rise).max())

    def drag(self, moment: int) -> None:
        """The user moves a control that has no keys.

        Blender forbids a timer to write while the render makes an engine: then the move is left out.
        """
        try:
            self.dragged.control.location.z = 0.01 * (moment % 100)
        except AttributeError:
            return
        bpy.context.view_layer.update()

    def dragged_error(self) -> float:
        height = self.dragged.control.location.z
        return float(np.abs(shown(self.dragged.obj) - self.dragged_expected.lifted(height)).max())

    def error(self, height: float) -> float:
        return float(np.abs(shown(self.rig.obj) - self.expected.lifted(height)).max())


def shown(obj: bpy.types.Object) -> np.ndarray:
    """What the window shows, without asking for another evaluation."""
    evaluated = obj.evaluated_get(bpy.context.evaluated_depsgraph_get())
    flat = np.empty(len(evaluated.data.vertices) * 3, dtype=np.float32)
    evaluated.data.vertices.foreach_get("co", flat)
    return flat.reshape(-1, 3).astype(float)


def curves_of(obj: bpy.types.Object) -> list:
    action = obj.animation_data.action
    if hasattr(action, "fcurves"):
        return list(action.fcurves)
    return [c for layer in action.layers for s in layer.strips for bag in s.channelbags for c in bag.fcurves]


class Turns:
    """The user moves things while an engine is at work, as nearly always in a render that takes its time.

    Between two of these tiny frames Blender frees a dependency graph and builds another, while a move would
    look for it: so the engine waits for a turn of the user in each frame.
    """

    PATIENCE = 2.0  # seconds

    def __init__(self) -> None:
        self._open, self._taken = threading.Event(), threading.Event()

    def give(self, *_args: object) -> None:
        """In the engine: wait until the user has moved things."""
        self._taken.clear()
        self._open.set()
        self._taken.wait(self.PATIENCE)
        self._open.clear()

    def take(self, act: Callable[[], None]) -> None:
        """In the main thread: ``act`` if it is the user's turn."""
        if self._open.is_set() or WILD:
            self._open.clear()
            act()
            self._taken.set()


def note_writers() -> list[bool]:
    """Whether, from now on, each write to a shape mesh is done by the main thread."""
    shape, found = sys.modules[f"{MODULE}.mesh_io.shape"], []
    write = shape.write_positions

    def noted(*arguments: object) -> None:
        found.append(threading.current_thread() is threading.main_thread())
        write(*arguments)

    shape.write_positions = noted
    return found


def playback(stage: Stage):
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.frame_set(1)
    errors = []
    with in_view():
        bpy.ops.screen.animation_play()
    seen["plays"] = bool(window().screen.is_animation_playing)
    for _ in range(40):
        yield
        errors.append(stage.error(STEP * scene.frame_current))
    frames = scene.frame_current
    with in_view():
        bpy.ops.screen.animation_play()
    yield
    seen["played_frames"] = frames - 1
    seen["playback_error"] = max(errors)


def viewport_render(stage: Stage):
    """``render.opengl`` shows what the viewport shows."""
    scene = bpy.context.scene
    rows = []
    for frame in (1, FRAMES):
        scene.frame_set(frame)
        yield
        path = OUTPUT / f"viewport_{frame}.png"
        scene.render.filepath, kept = str(path), scene.render.filepath
        scene.render.resolution_x = scene.render.resolution_y = 96
        with in_view():
            bpy.ops.render.opengl(write_still=True, view_context=False)
        scene.render.filepath = kept
        scene.render.resolution_x = scene.render.resolution_y = 16
        image = bpy.data.images.load(str(path))
        pixels = np.array(image.pixels[:]).reshape(96, 96, -1)[:, :, :3].sum(axis=2)
        different = np.abs(pixels - pixels[2, 2]) > 0.1
        rows.append(float(np.flatnonzero(different.any(axis=1)).max()))
        bpy.data.images.remove(image)
    seen["opengl_rows"] = rows
    seen["opengl_rise"] = float(np.cos(TILT)) * STEP * (FRAMES - 1) * 96 / 6.0


def f12_during_a_drag(stage: Stage):
    """The control stands where no key has it; the render is of the keys, the viewport keeps the drag."""
    scene = bpy.context.scene
    scene.frame_set(10)
    stage.rig.control.location.z = 0.7
    yield
    seen["dragged_error"] = stage.error(0.7)
    Probe.seen, Probe.frames, Probe.subframes = [], [], (0.0,)
    scene.render.engine = Probe.bl_idname
    yield from rendered(lambda: None)
    shape = Probe.seen[-1]["Plate"]
    seen["f12_error"] = float(np.abs(shape - stage.expected.lifted(STEP * 10)).max())
    seen["viewport_after_f12_error"] = stage.error(0.7)
    scene.frame_set(10)
    yield


def rendered(act, **options):
    """Render as F12 does, until the job has ended; ``act`` in each moment.

    The job begins only when Blender has ended other jobs, so that waiting counts renders that ended.
    """
    before = ended[0]
    bpy.ops.render.render("INVOKE_DEFAULT", **options)

    def is_done() -> bool:
        if ended[0] > before and not bpy.app.is_job_running("RENDER"):
            return True
        act()
        return False

    yield from until(is_done, 350.0)


ended = [0]  # how many renders ended


def count_ended(*_scene: bpy.types.Scene) -> None:
    ended[0] += 1


def stress(stage: Stage, engine: str, last: int, writers: list[bool]):
    """An animation, while the user orbits and poses another mesh, which is solved again and again."""
    scene = bpy.context.scene
    scene.render.engine = engine
    scene.render.use_lock_interface = False
    scene.frame_start, scene.frame_end = 1, last
    scene.frame_set(1)
    Probe.seen, Probe.frames, Probe.subframes = [], [], (0.0,)
    done: list[int] = []
    note = lambda scene, *_rest: done.append(scene.frame_current)  # noqa: E731
    bpy.app.handlers.render_post.append(note)
    moves, turns = 0, Turns()
    if engine == Probe.bl_idname:
        Probe.at_work = None if WILD else turns.give
    elif not WILD:
        bpy.app.handlers.render_stats.append(turns.give)  # Cycles tells how far it is

    def move() -> None:
        nonlocal moves
        for _ in range(5):
            moves += 1
            stage.drag(moves)

    def live() -> None:
        turns.take(move)
        viewport().spaces.active.region_3d.view_location.x = 0.01 * (moves % 50)
        viewport().tag_redraw()

    writers.clear()
    begin = time.monotonic()
    seen[f"{engine}_unlocked"] = not scene.render.use_lock_interface
    yield from rendered(live, animation=True)
    bpy.app.handlers.render_post.remove(note)
    Probe.at_work = None
    if turns.give in bpy.app.handlers.render_stats:
        bpy.app.handlers.render_stats.remove(turns.give)
    seen[f"{engine}_seconds"] = round(time.monotonic() - begin, 1)
    seen[f"{engine}_frames"] = len(done)
    seen[f"{engine}_moves"] = moves
    seen[f"{engine}_writes"], seen[f"{engine}_writes_elsewhere"] = len(writers), writers.count(False)
    yield from until(lambda: not sessions().unsettled() and not binding().busy(), 10.0)
    yield
    seen[f"{engine}_dragged_error"] = stage.dragged_error()
    seen[f"{engine}_viewport_error"] = stage.error(STEP * scene.frame_current)
    seen[f"{engine}_follower_error"] = stage.follower_error(STEP * scene.frame_current)
    if engine == Probe.bl_idname:
        errors = [
            float(np.abs(shapes["Plate"] - stage.expected.lifted(STEP * frame)).max())
            for frame, shapes in zip(Probe.frames, Probe.seen, strict=True)
        ]
        seen["probe_error"] = max(errors)
        seen["probe_follower_error"] = max(
            stage.follower_error(STEP * frame, shapes["Follower"])
            for frame, shapes in zip(Probe.frames, Probe.seen, strict=True)
        )
        Probe.seen = []
    for frame in (1, last // 2, last):
        scene.frame_set(frame)
        yield
        seen[f"{engine}_after_{frame}"] = stage.error(STEP * frame)


def remember(stage: Stage) -> None:
    """An undo step in the middle of the animation: an autosave writes the last step of the history."""
    bpy.context.scene.frame_set(FRAMES // 2)
    bpy.ops.ed.undo_push(message="Middle")
    seen["autosave_height"] = stage.rig.control.location.z


def autosave():
    """Blender writes it by itself after a minute, without our handlers, and not while an operator runs."""
    for x in range(5):  # the ended render lets go with the next event
        window().event_simulate("MOUSEMOVE", "NOTHING", x=100 + x, y=100)
        yield
    yield from until(lambda: any(OUTPUT.glob("*autosave.blend")), 90.0)
    yield from until(lambda: False, 1.0)  # until it is written to its end
    seen["autosave"] = str(next(OUTPUT.glob("*autosave.blend"), ""))


def journey():
    paths = bpy.context.preferences.filepaths
    paths.temporary_directory, paths.auto_save_time = str(OUTPUT), 1
    bpy.context.preferences.view.render_display_type = "NONE"
    stage = Stage()
    for handlers in (bpy.app.handlers.render_complete, bpy.app.handlers.render_cancel):
        handlers.append(count_ended)
    yield
    writers = note_writers()
    remember(stage)
    yield from playback(stage)
    yield from viewport_render(stage)
    yield from f12_during_a_drag(stage)
    yield from stress(stage, Probe.bl_idname, FRAMES, writers)
    yield from stress(stage, "CYCLES", CYCLES_FRAMES, writers)
    yield from autosave()


play(journey(), pause=0.02)

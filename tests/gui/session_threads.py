# SPDX-License-Identifier: GPL-3.0-or-later
"""Operators that stay while a thread works; renders of other counts; playback and renders beside a viewport
that lives on; autosave.
"""

import os
import threading
from collections.abc import Callable, Iterator

import bpy
import numpy as np
from driving import OUTPUT, above, apart, claim, near, pace, rest, run, seen, settled, until, works
from expected import Expected
from hand import glide, keys, open_sidebar, press
from inside import inner
from mathutils import Matrix
from probe import Probe
from rigs import rig as scenes
from rigs.rig_of_curves import polyline
from scenes import deformer, empty_scene, head, heavy_grid, new_camera, only_head, shown
from window import button, in_view, middle, view, viewport, window

QUICK = 0.1  # the margin of a cage that is made in a moment


def plain(levels: int = 0) -> None:
    """A head with a group at each side, alone in the scene."""
    obj = only_head()
    if levels:
        obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
        bpy.ops.object.modifier_apply(modifier="Subdivision")
    scenes.add_group(obj, "Ear.L", lambda point: point[0] > 1.0)
    scenes.add_group(obj, "Ear.R", lambda point: point[0] < -1.0)


def held() -> None:
    plain()
    bpy.ops.sinew.handle_add(kind="FIXED", vertex_group="Ear.R")
    bpy.ops.sinew.handle_add(kind="HANDLE", vertex_group="Ear.L")


def caged(method: str = "harmonic", faces: int = 100) -> None:
    plain()
    bpy.ops.sinew.cage_add(method=method, faces=faces, margin=QUICK)


def inside_out() -> None:
    caged("mean_value")
    deformer().cage.data.flip_normals()


def boxed() -> None:
    plain()
    bpy.ops.sinew.lattice_add()


def with_curve() -> None:
    plain()
    polyline(np.linspace((-1.5, -0.5, 0.2), (1.5, -0.5, 0.2), 4))


def wired() -> None:
    with_curve()
    bpy.ops.sinew.wire_add(curve="Wire")


def twins() -> None:
    plain()
    other = scenes.linked(bpy.data.objects.new("Twin", head().data.copy()))
    other.data.transform(other.matrix_world.Scale(1.5, 4))


def pressed(name: str, **options: object) -> Callable[[], set[str]]:
    return lambda: button(name, **options)


def another_method() -> set[str]:
    """An evaluation begins the bind, and a timer calls the operator that watches it."""
    deformer().method = "thin_shell_nonlinear"
    bpy.context.view_layer.update()
    return {"RUNNING_MODAL"} if inner.binding.busy() else set()


CASES = {
    "handle_add": (plain, pressed("handle_add", kind="HANDLE", vertex_group="Ear.L")),
    "handle_mirror": (held, pressed("handle_mirror")),
    "bind": (held, pressed("bind")),
    "watch": (held, another_method),
    "cage_add": (plain, pressed("cage_add", faces=100, margin=QUICK)),
    "cage_add harmonic": (plain, pressed("cage_add", faces=100, margin=QUICK, method="harmonic")),
    "cage_set_rest": (lambda: caged("mean_value"), pressed("cage_set_rest")),
    "cage_flip": (inside_out, pressed("cage_flip")),
    "cage_faces": (caged, pressed("cage_faces", faces=60)),
    "lattice_add": (plain, pressed("lattice_add")),
    "lattice_set_rest": (boxed, pressed("lattice_set_rest")),
    "point_add": (plain, pressed("point_add", source="CURSOR", method="rigid_cells")),
    "wire_add": (with_curve, pressed("wire_add", curve="Wire")),
    "control_set_rest": (wired, pressed("control_set_rest")),
    "tool_add": (plain, pressed("tool_add")),
    "morph": (twins, pressed("morph", target="Twin")),
    "bake": (held, pressed("bake", target="SHAPE_KEYS", frame_start=1, frame_end=3)),
}


def waiting() -> Iterator[None]:
    """Each operator that stays while a thread works, and beyond: called later, it is freed memory."""
    yield from open_sidebar()
    yield from one_cage_at_a_time()
    limit, inner.binding.HEAVY = inner.binding.HEAVY, 0.0  # now every mesh is above the limit
    for name in CASES:
        yield from to_its_end(name)
    with claim("another file ends the operators that wait"):
        for name in ("cage_add", "bind"):
            prepare, call = CASES[name]
            prepare()
            yield from rest()
            call()
            bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
            yield from rest(4)
        assert len(bpy.data.objects) == 0
    inner.binding.HEAVY = limit


def to_its_end(name: str) -> Iterator[None]:
    """One operator, with events before and after its end."""
    print("case:", name, flush=True)  # the last one that is printed is the one that ends Blender
    prepare, call = CASES[name]
    prepare()
    bpy.context.view_layer.objects.active = head()
    yield from rest()
    with claim("an operator that waits for threads ends once"):
        assert call() == {"RUNNING_MODAL"}, name
        if name == "cage_faces":  # asks first
            yield from rest()
            press("RET")
            yield from until(works, 10.0)
        yield from rest()
        yield from until(lambda: not works() and deformer() is not None)
        x, y = middle()
        yield from glide([(x + step, y) for step in range(6)])  # what Blender has freed is called by events
        bound = [row.is_bound for row in head().sinew.deformers]
        assert bound, name
        assert all(bound), (name, bound)
        assert deformer().status_level == "INFO", (name, deformer().status)


def one_cage_at_a_time() -> Iterator[None]:
    """A second click while a cage is made for two objects, the X in the panel of the other, another cage."""
    plain(levels=2)
    bpy.ops.mesh.primitive_cube_add(location=(3.0, 0.0, 0.0))
    other = bpy.context.object
    yield from rest()
    with claim("objects get one cage at a time, and the panel of each cancels it"):
        for cages in (0, 1):
            scenes.make_active(head(), other)
            button("cage_add", faces=200, method="harmonic")
            for obj in (head(), other):
                bpy.context.view_layer.objects.active = obj
                with in_view():
                    assert not bpy.ops.sinew.cage_add.poll(), obj.name
            yield from rest()
            if cages == 0:
                with in_view():
                    bpy.ops.sinew.cancel()
            yield from until(lambda: not works(), 60.0)
            yield from rest(4)
            assert sum(obj.name.startswith("Head Cage") for obj in bpy.data.objects) == cages
            assert [len(obj.sinew.deformers) for obj in (head(), other)] == [cages, cages]
        assert deformer().status_level == "INFO"
        bpy.context.view_layer.objects.active = head()
        assert bpy.ops.sinew.cage_faces.poll()


def heavy() -> Iterator[None]:
    """A mesh that binds in a thread: the window lives on, Esc cancels, Bind starts again."""
    with in_view():
        obj = heavy_grid("thin_shell", size=2.0)
    button("handle_add", kind="HANDLE", vertex_group="Left")
    made = obj.sinew.active

    def is_done() -> bool:
        return inner.binding.job(made.uid) is None

    with claim("a heavy mesh binds in a thread, and Esc cancels"):
        assert not is_done()
        yield from until(is_done)
        assert "160,801 vertices, 1 handle, 1 still, " in made.status
        yield
        bpy.context.view_layer.objects.active = obj
        obj.data.vertices[0].co.z += 0.5  # else the factor stays, and nothing is left to cancel
        button("bind")
        yield from keys("ESC")
        assert "cancelled" in made.status
        button("bind")
        yield from until(is_done)
        yield
        assert "bound in" in made.status


EXACT = 1e-5


def sheet(level: int) -> scenes.Rig:
    """A lifted handle on a sheet that has a level in the viewport and in renders."""
    rig = scenes.Rig.plate(5)
    scenes.subdivided(rig.obj, level, level)
    rig.bind()
    rig.lift(0.5)
    return rig


def counts() -> Iterator[None]:
    """F12 after settings that count in renders alone were changed."""
    empty_scene()
    wanted = {}
    for level in (0, 1, 3):
        rig = sheet(level)
        yield from rest()
        wanted[level] = scenes.evaluated_points(rig.obj)
        bpy.data.objects.remove(rig.obj)
    rig = sheet(2)
    new_camera(8)
    yield from rest(8)
    modifier = rig.obj.modifiers[0]

    def change(**settings: object) -> Iterator[np.ndarray]:
        """Change the modifier; what a render beside the window then shows."""
        for name, value in settings.items():
            setattr(modifier, name, value)
        yield from rest(10)
        Probe.seen.clear()
        bpy.context.scene.render.engine = Probe.bl_idname
        with in_view():
            bpy.ops.render.render("INVOKE_DEFAULT")
        yield from until(lambda: Probe.seen and not bpy.app.is_job_running("RENDER"))
        yield from rest()
        return Probe.seen[-1][rig.name]

    with claim("F12 is bound for its own counts"):
        for level, settings in (
            (3, {"render_levels": 3}),
            (0, {"show_render": False}),
            (1, {"show_render": True, "render_levels": 1}),
            (3, {"levels": 1, "render_levels": 3}),
        ):
            near((yield from change(**settings)), wanted[level], EXACT)


# Where the user moves things at any moment, Blender itself, without any add-on, crashes about once in 50 such
# frames: see docs/developer/decisions/unlocked-renders.md. So the engine gives the user a turn in each frame.
# SINEW_STRESS_WILD=1 does without turns, SINEW_STRESS_FRAMES=1000 renders more.
WILD = "SINEW_STRESS_WILD" in os.environ
FRAMES = int(os.environ.get("SINEW_STRESS_FRAMES", "100"))
STEP = 1.0 / FRAMES  # what the control rises in one frame
# Cycles shows its image through OpenGL, from threads of its own: in Mesa's software driver that crashes
# now and then, whatever it renders. So most frames go to an engine that draws nothing.
CYCLES_FRAMES = FRAMES // 10
TILT = 0.3
FLOAT32 = 4e-6
FOLLOWS = 2e-5  # five times that, in the small frame of what the lattice moves
ITERATIVE = 1e-3  # what an iterative method's own tolerance leaves


class Stage:
    """The plate, and what it must show."""

    def __init__(self) -> None:
        empty_scene()
        self.rig = scenes.Rig(scenes.grid_object("Plate", cells=24)).bind("thin_shell")
        self.expected = Expected.of_rig(self.rig)
        self.rig.obj.rotation_euler.x = TILT  # else the camera sees an edge
        self.dragged = scenes.Rig(scenes.grid_object("Dragged", cells=16)).bind("arap")
        self.dragged_expected = Expected.of_rig(self.dragged, "arap")
        self.dragged.obj.location.x = 50.0
        self._add_follower()
        scenes.key_heights(self.rig.control, {0: 0.0, FRAMES: 1.0}, linear=True)
        scene, camera = bpy.context.scene, new_camera(16)
        camera.data.type, camera.data.ortho_scale = "ORTHO", 6.0
        camera.matrix_world = Matrix.Translation((0.0, -10.0, 0.0)) @ Matrix.Rotation(np.pi / 2, 4, "X")
        scene.render.resolution_percentage = 100
        scene.render.filepath = str(OUTPUT / "frames" / "f")
        scene.render.use_file_extension = True
        scene.cycles.samples, scene.cycles.use_denoising, scene.cycles.device = 1, False, "CPU"
        scenes.make_active(self.dragged.obj)

    def _add_follower(self) -> None:
        """A mesh that follows a lattice, which the control of the plate moves, too."""
        lattice = scenes.linked(bpy.data.objects.new("Lattice", bpy.data.lattices.new("Lattice")))
        self.follower = scenes.grid_object("Follower", cells=4)
        self.follower.scale = 0.2, 0.2, 0.2
        for obj in (lattice, self.follower):
            obj.location.x = 30.0
        self.follower.modifiers.new("Lattice", "LATTICE").object = lattice
        bpy.context.view_layer.update()
        self.follower_rest = shown(self.follower)
        scenes.make_active(lattice, self.rig.control)
        bpy.ops.sinew.point_add(source="SELECTED", method="mls")

    def drag(self, moment: int) -> None:
        """The user moves a control without keys, unless Blender forbids a timer to write now."""
        try:
            self.dragged.control.location.z = 0.01 * (moment % 100)
        except AttributeError:
            return
        bpy.context.view_layer.update()

    def assert_right(self, height: float, shapes: dict[str, np.ndarray]) -> None:
        """Of the plate and of what follows it, with the control at that height."""
        near(shapes["Plate"], self.expected.lifted(height), FLOAT32)
        rise = height / self.follower.scale.z * np.array((0.0, -np.sin(TILT), np.cos(TILT)))
        near(shapes["Follower"], self.follower_rest + rise, FOLLOWS)

    def assert_shows(self, height: float) -> None:
        self.assert_right(height, {obj.name: shown(obj) for obj in (self.rig.obj, self.follower)})


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
    shape, found = inner.mesh_io.shape, []
    write = shape.write_positions

    def noted(*arguments: object) -> None:
        found.append(threading.current_thread() is threading.main_thread())
        write(*arguments)

    shape.write_positions = noted
    return found


def stress() -> Iterator[None]:
    """Playback, viewport render, F12 during a drag, a long render while the viewport lives on, autosave."""
    paths = bpy.context.preferences.filepaths
    paths.temporary_directory, paths.auto_save_time = str(OUTPUT), 1
    bpy.context.preferences.view.render_display_type = "NONE"
    pace[0] = 0.02
    stage = Stage()
    for handlers in (bpy.app.handlers.render_complete, bpy.app.handlers.render_cancel):
        handlers.append(count_ended)
    yield
    writers = note_writers()
    bpy.context.scene.frame_set(FRAMES // 2)
    bpy.ops.ed.undo_push(message="Middle")  # an autosave writes the last step of the history
    seen["autosave_height"] = stage.rig.control.location.z
    yield from playback(stage)
    yield from viewport_render(stage)
    yield from f12_during_a_drag(stage)
    yield from unlocked(stage, Probe.bl_idname, FRAMES, writers)
    yield from unlocked(stage, "CYCLES", CYCLES_FRAMES, writers)
    # Blender autosaves by itself after a minute, without our handlers, and not while an operator runs.
    yield from glide([(100 + step, 100) for step in range(5)])  # the ended render lets go with the next event
    yield from until(lambda: any(OUTPUT.glob("*autosave.blend")), 90.0)
    yield from until(lambda: False, 1.0)  # until it is written to its end
    seen["autosave"] = str(next(OUTPUT.glob("*autosave.blend"), ""))


def playback(stage: Stage) -> Iterator[None]:
    scene = bpy.context.scene
    scene.frame_start, scene.frame_end = 1, FRAMES
    scene.frame_set(1)
    with in_view():
        bpy.ops.screen.animation_play()
    with claim("playback shows the pose of each frame"):
        assert window().screen.is_animation_playing
        for _ in range(40):
            yield
            stage.assert_shows(STEP * scene.frame_current)
        above(scene.frame_current - 1, 9)
    with in_view():
        bpy.ops.screen.animation_play()
    yield


def viewport_render(stage: Stage) -> Iterator[None]:
    """``render.opengl`` shows what the viewport shows."""
    scene, rows = bpy.context.scene, []
    render, size = scene.render, 96
    kept = render.filepath
    for frame in (1, FRAMES):
        scene.frame_set(frame)
        yield
        render.filepath = str(OUTPUT / f"viewport_{frame}.png")
        render.resolution_x = render.resolution_y = size
        with in_view():
            bpy.ops.render.opengl(write_still=True, view_context=False)
        image = bpy.data.images.load(render.filepath)
        pixels = np.array(image.pixels[:]).reshape(size, size, -1)[:, :, :3].sum(axis=2)
        different = np.abs(pixels - pixels[2, 2]) > 0.1
        rows.append(float(np.flatnonzero(different.any(axis=1)).max()))
        bpy.data.images.remove(image)
    render.filepath, render.resolution_x, render.resolution_y = kept, 16, 16
    with claim("a viewport render shows the pose"):
        rise = float(np.cos(TILT)) * STEP * (FRAMES - 1) * size / scene.camera.data.ortho_scale
        assert abs(rows[1] - rows[0] - rise) < 1.5, rows


def f12_during_a_drag(stage: Stage) -> Iterator[None]:
    """The control stands where no key has it; the render is of the keys, the viewport keeps the drag."""
    scene = bpy.context.scene
    scene.frame_set(10)
    stage.rig.control.location.z = 0.7
    yield
    with claim("F12 shows the keys, and the viewport keeps the drag"):
        stage.assert_shows(0.7)
        Probe.seen, Probe.frames, Probe.subframes = [], [], (0.0,)
        scene.render.engine = Probe.bl_idname
        yield from rendered(lambda: None)
        stage.assert_right(STEP * 10, Probe.seen[-1])
        stage.assert_shows(0.7)
    scene.frame_set(10)
    yield


ended = [0]  # how many renders ended


def count_ended(*_scene: bpy.types.Scene) -> None:
    ended[0] += 1


def rendered(act: Callable[[], None], **options: bool) -> Iterator[None]:
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


def takes_writes() -> bool:
    """Whether Blender lets Python write: a panel drawn beside the Python of a render can forbid that."""
    try:
        bpy.context.scene.render.use_lock_interface = False
    except AttributeError:
        return False
    return True


def unlocked(stage: Stage, engine: str, last: int, writers: list[bool]) -> Iterator[None]:
    """An animation, while the user orbits and poses another mesh, which is solved again and again."""
    scene = bpy.context.scene
    yield from until(takes_writes)
    if engine != Probe.bl_idname and not takes_writes():
        return  # for good, after an engine in Python: docs/developer/decisions/unlocked-renders.md
    scene.render.engine = engine
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

    def pose() -> None:
        nonlocal moves
        for _ in range(5):
            moves += 1
            stage.drag(moves)

    def live() -> None:
        turns.take(pose)
        view().view_location.x = 0.01 * (moves % 50)
        viewport().tag_redraw()

    writers.clear()
    with claim("many frames with an unlocked viewport do not crash"):
        assert not scene.render.use_lock_interface
        yield from rendered(live, animation=True)
        assert len(done) == last
        above(moves, 2 * last)
    bpy.app.handlers.render_post.remove(note)
    Probe.at_work = None
    if turns.give in bpy.app.handlers.render_stats:
        bpy.app.handlers.render_stats.remove(turns.give)
    with claim("only the main thread writes shapes in an unlocked render, those of the render thread too"):
        above(len(writers), 3 * last - 1)  # of two meshes in each frame, and of one in each move
        assert all(writers)
    yield from settled()
    with claim("the viewport is right after an unlocked render"):
        height = stage.dragged.control.location.z
        assert apart(shown(stage.dragged.obj), stage.dragged_expected.lifted(height)) < ITERATIVE
        stage.assert_shows(STEP * scene.frame_current)
        for frame in (1, last // 2, last):
            scene.frame_set(frame)
            yield
            stage.assert_shows(STEP * frame)
    if engine == Probe.bl_idname:
        with claim("each frame of an unlocked render is right"):
            assert len(Probe.seen) == last
            for frame, shapes in zip(Probe.frames, Probe.seen, strict=True):
                stage.assert_right(STEP * frame, shapes)
        Probe.seen = []


run(waiting, heavy, counts, stress)

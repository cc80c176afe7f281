# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs inside a Blender with a window: each operator that stays while a thread works, to its end and beyond.

An operator that Blender calls after its end is freed memory: that ends Blender, some events later.
"""

import bpy
from driving import (
    OUTPUT,
    binding,
    enable,
    in_view,
    middle,
    move,
    only_head,
    open_tab,
    play,
    press,
    rest,
    screenshot,
    seen,
    until,
    viewport,
    works,
)

QUICK = 0.1  # the margin of a cage that is made in a moment


def head() -> bpy.types.Object:
    return bpy.data.objects["Head"]


def deformer():
    return head().sinew.active


def plain(levels: int = 0) -> None:
    """A head with a group at each side, alone in the scene."""
    obj = only_head()
    if levels:
        obj.modifiers.new("Subdivision", "SUBSURF").levels = levels
        bpy.ops.object.modifier_apply(modifier="Subdivision")
    for name, side in (("Ear.L", 1.0), ("Ear.R", -1.0)):
        members = [vertex.index for vertex in obj.data.vertices if side * vertex.co.x > 1.0]
        obj.vertex_groups.new(name=name).add(members, 1.0, "REPLACE")


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


def wired() -> None:
    with_curve()
    bpy.ops.sinew.wire_add(curve="Wire")


def with_curve() -> None:
    plain()
    curve = bpy.data.curves.new("Wire", "CURVE")
    curve.dimensions = "3D"
    spline = curve.splines.new("POLY")
    spline.points.add(3)
    for index, point in enumerate(spline.points):
        point.co = (index - 1.5, -0.5, 0.2, 1.0)
    bpy.context.scene.collection.objects.link(bpy.data.objects.new("Wire", curve))


def tooled() -> None:
    plain()
    bpy.ops.sinew.tool_add()


def twins() -> None:
    plain()
    other = bpy.data.objects.new("Twin", head().data.copy())
    other.data.transform(other.matrix_world.Scale(1.5, 4))
    bpy.context.scene.collection.objects.link(other)


def invoked(name: str, **options: object):
    """The operator, called as a button does."""
    return lambda: getattr(bpy.ops.sinew, name)("INVOKE_DEFAULT", **options)


def another_method() -> None:
    """An evaluation begins the bind, and a timer calls the operator that watches it."""
    deformer().method = "thin_shell_nonlinear"
    bpy.context.view_layer.update()
    return ["RUNNING_MODAL"] if binding().busy() else []


CASES = {
    "handle_add": (plain, invoked("handle_add", kind="HANDLE", vertex_group="Ear.L")),
    "handle_mirror": (held, invoked("handle_mirror")),
    "bind": (held, invoked("bind")),
    "watch": (held, another_method),
    "cage_add": (plain, invoked("cage_add", faces=100, margin=QUICK)),
    "cage_add harmonic": (plain, invoked("cage_add", faces=100, margin=QUICK, method="harmonic")),
    "cage_set_rest": (lambda: caged("mean_value"), invoked("cage_set_rest")),
    "cage_flip": (inside_out, invoked("cage_flip")),
    "cage_faces": (caged, invoked("cage_faces", faces=60)),
    "lattice_add": (plain, invoked("lattice_add")),
    "lattice_set_rest": (boxed, invoked("lattice_set_rest")),
    "point_add": (plain, invoked("point_add", source="CURSOR", method="rigid_cells")),
    "wire_add": (with_curve, invoked("wire_add", curve="Wire")),
    "control_set_rest": (wired, invoked("control_set_rest")),
    "tool_add": (plain, invoked("tool_add")),
    "morph": (twins, invoked("morph", target="Twin")),
    "bake": (held, invoked("bake", target="SHAPE_KEYS", frame_start=1, frame_end=3)),
}


def run(name: str):
    """One operator, with events before and after its end."""
    print("case:", name, flush=True)  # the last one that is printed is the one that ends Blender
    prepare, call = CASES[name]
    prepare()
    bpy.context.view_layer.objects.active = head()
    yield from rest()
    with in_view():
        found = seen[name] = {"stays": list(call() or ())}
    if name == "cage_faces":  # asks first
        yield from rest()
        press("RET")
        yield from until(works, 10.0)
    yield from rest()
    yield from until(lambda: not works() and deformer() is not None)
    for step in range(6):  # what Blender has freed is called by events
        move(middle()[0] + step, middle()[1])
        yield
    found["bound"] = [row.is_bound for row in head().sinew.deformers]
    found["status"] = deformer().status
    found["level"] = deformer().status_level


def one_cage_at_a_time():
    """A second click while a cage is made for two objects, the X in the panel of the other, another cage."""
    plain(levels=2)
    bpy.ops.mesh.primitive_cube_add(location=(3.0, 0.0, 0.0))
    other = bpy.context.object
    yield from rest()
    found = seen["one at a time"] = {}
    for end in ("cancelled", "made"):
        for obj in (other, head()):
            obj.select_set(True)
            bpy.context.view_layer.objects.active = obj
        offered = found[f"offered while {end}"] = []
        with in_view():
            bpy.ops.sinew.cage_add("INVOKE_DEFAULT", faces=200, method="harmonic")
            for obj in (head(), other):
                bpy.context.view_layer.objects.active = obj
                offered.append(bpy.ops.sinew.cage_add.poll())
        yield from rest()
        screenshot(f"1-while-{end}")
        if end == "cancelled":
            with in_view():
                bpy.ops.sinew.cancel()
        yield from until(lambda: not works(), 60.0)
        yield from rest(4)
        found[f"cages when {end}"] = sum(obj.name.startswith("Head Cage") for obj in bpy.data.objects)
        found[f"deformers when {end}"] = [len(obj.sinew.deformers) for obj in (head(), other)]
        screenshot(f"2-{end}")
    found["status"] = deformer().status_level
    bpy.context.view_layer.objects.active = head()
    found["offered afterwards"] = bpy.ops.sinew.cage_faces.poll()


def another_file():
    """Blender ends the operators when another file is opened."""
    for name in ("cage_add", "bind"):
        CASES[name][0]()
        yield from rest()
        with in_view():
            CASES[name][1]()
        bpy.ops.wm.read_homefile(use_empty=True, use_factory_startup=True)
        yield from rest(4)
    seen["objects in the other file"] = len(bpy.data.objects)


def steps():
    enable()
    viewport().spaces.active.show_region_ui = True
    yield from rest()
    yield from open_tab()
    yield from rest()
    yield from one_cage_at_a_time()
    limit, binding().HEAVY = binding().HEAVY, 0.0  # now every mesh is above the limit
    for name in CASES:
        yield from run(name)
    yield from another_file()
    binding().HEAVY = limit


OUTPUT.mkdir(parents=True, exist_ok=True)
play(steps())

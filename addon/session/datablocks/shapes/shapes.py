# SPDX-License-Identifier: GPL-3.0-or-later
"""The hidden meshes of a deformer.

Only operators, scripts and timers on the main thread may call this.
"""

import uuid
from dataclasses import replace

import bpy
import numpy as np
from bpy.types import Mesh, Object, Scene

from ....ids import Datablocks, Keys
from ....mesh_io import copy_shape, replace_rest, resize_shape, shape_mesh, write_shape
from ....properties import SinewDeformer, deformers_of
from ...state import render_writes, sessions
from ...targets.kinds import kind_of
from ...targets.modified import KEY_LENGTH
from .. import references

_REST = ("rest",)


def new_key() -> str:
    """A key that no other deformer has, in this file or another."""
    return uuid.uuid4().hex[:KEY_LENGTH]


def ensure(obj: Object, deformer: SinewDeformer, vertex_count: int, render_count: int | None = None) -> None:
    """Make sure that there are shape meshes of the right size, and a modifier or a shape key that shows them.

    What is right already stays as it is. ``render_count`` is given if another number of vertices enters in
    renders.
    """
    kind = kind_of(obj)
    shows = kind.ensure(obj, deformer) if kind.STAYS_UNBOUND or deformer.is_bound else None
    render_count = vertex_count if render_count is None else render_count
    for mode, count in (("VIEWPORT", vertex_count), ("RENDER", render_count)):
        shape = deformer.shape(mode)
        if shape is not None and len(shape.data.vertices) != count + 1:
            sessions.forget_shape(deformer.uid, mode)  # it is about to be emptied
    deformer.proxy = _shape_object(deformer.shape("VIEWPORT"), Datablocks.PROXY_VIEWPORT, vertex_count)
    deformer.proxy_render = _shape_object(deformer.shape("RENDER"), Datablocks.PROXY_RENDER, render_count)
    mark(deformer)
    if shows is not None:
        kind.connect(shows, deformer)


def mark(deformer: SinewDeformer) -> None:
    """Let the shape meshes say whose they are, so that ``restore`` finds them."""
    for proxy, owner in _owners(deformer):
        if proxy is not None and not is_linked(proxy) and proxy.data.get(Keys.SHAPE) != owner:
            proxy.data[Keys.SHAPE] = owner


def _owners(deformer: SinewDeformer) -> tuple[tuple[Object | None, str], tuple[Object | None, str]]:
    """The two shape objects, each with what its mesh says."""
    return (deformer.proxy, f"{deformer.uid} VIEWPORT"), (deformer.proxy_render, f"{deformer.uid} RENDER")


def restore(obj: Object, deformer: SinewDeformer) -> None:
    """Find the shapes again, if undo or redo put the target in their place.

    Blender reads a changed object into new memory, then moves it to where it was, and takes each of its
    pointers to the new memory for one to itself. But these still are the addresses of the time when the step
    was stored, and a shape that was removed since may have been there.
    """
    lost = [owner for proxy, owner in _owners(deformer) if proxy == obj]
    if not lost:
        return
    for shape in bpy.data.objects:
        owner = shape.data.get(Keys.SHAPE) if shape.type == "MESH" and shape.library is None else None
        if owner in lost:
            setattr(deformer, "proxy_render" if owner.endswith("RENDER") else "proxy", shape)
    kind = kind_of(obj)
    shows = kind.shown_by(obj, deformer)
    if shows is not None:
        kind.connect(shows, deformer)


def is_linked(proxy: Object | None) -> bool:
    """Whether this shape object or its mesh comes from a library: Blender ignores writes to it then."""
    return isinstance(proxy, Object) and (
        proxy.library is not None or (proxy.data is not None and proxy.data.library is not None)
    )


def hide_overrides(*proxies: Object | None) -> None:
    """Take shape objects out of the scene that Blender put there, because it overrides all that it finds."""
    for proxy in proxies:
        if proxy is not None and proxy.override_library is not None:
            for collection in proxy.users_collection:
                collection.objects.unlink(proxy)


def _shape_object(proxy: Object | None, name: str, vertex_count: int) -> Object:
    if proxy is None or is_linked(proxy):
        return bpy.data.objects.new(name, shape_mesh(name, vertex_count))
    if len(proxy.data.vertices) != vertex_count + 1:
        if proxy.data.users == 1:
            resize_shape(proxy.data, vertex_count)
        else:
            proxy.data = shape_mesh(name, vertex_count)
    return proxy


def session_of(deformer: SinewDeformer, mode: str) -> sessions.Session:
    """The session of a deformer. If other vertices enter in renders, these have a session of their own."""
    session = sessions.open_session(deformer.uid)
    if mode == "RENDER" and deformer.renders_differ:
        return sessions.open_render_session(deformer.uid)
    return session


def show_rest(deformer: SinewDeformer, mode: str, scene: Scene | None = None) -> None:
    """Show the incoming shape unchanged. This only writes an array, so handlers may call it.

    A handler names its ``scene``, and holds the lock of the session.
    """
    proxy = deformer.shape(mode)
    session = session_of(deformer, mode)
    shown = session.view(mode)
    if proxy is None or shown.signature == _REST:
        return
    zeros = np.zeros((len(proxy.data.vertices), 3), dtype=np.float32)
    mesh = proxy.data
    if scene is None:
        write_shape(mesh, zeros, 0.0, False)
    else:
        render_writes.write(scene, lambda: write_shape(mesh, zeros, 0.0, False), session.lock)
    shown.signature, shown.converged = _REST, True
    shown.hold(None)


def render_as_shown(deformer: SinewDeformer, scene: Scene | None = None) -> bool:
    """Let renders show what the viewport shows; False if other vertices enter there.

    This only writes an array, so handlers may call it. A handler names its ``scene``, and holds the lock of
    the session.
    """
    shown, rendered = deformer.shape("VIEWPORT"), deformer.shape("RENDER")
    if shown is None or rendered is None or is_linked(rendered):
        return True
    source, mesh = shown.data, rendered.data
    if deformer.renders_differ or deformer.topology_changed or len(source.vertices) != len(mesh.vertices):
        return False
    session = sessions.open_session(deformer.uid)
    if scene is None:
        copy_shape(source, mesh)
    else:
        render_writes.write(scene, lambda: copy_shape(source, mesh), session.lock)
    # Without a signature, the next render solves if it can.
    session.shown["RENDER"] = replace(session.view("VIEWPORT"), signature=(), converged=True)
    return True


def remove(obj: Object, deformer: SinewDeformer) -> None:
    """Remove the modifier or shape key, and what only this deformer used."""
    kind_of(obj).remove(obj, deformer)
    release_rest(deformer)
    references.release_curves(deformer)
    for proxy in (deformer.shape("VIEWPORT"), deformer.shape("RENDER")):
        free_shape(proxy)


def free_shape(proxy: Object | None) -> None:
    """Remove a shape object, unless a copy of the target still shows it or a user put it into a scene."""
    if proxy is None or is_linked(proxy) or _shape_owners(proxy) > 1 or proxy.users_scene:
        return
    mesh = proxy.data
    bpy.data.objects.remove(proxy)
    if mesh.users == 0:
        bpy.data.meshes.remove(mesh)


def _shape_owners(proxy: Object) -> int:
    return sum(
        proxy in (deformer.proxy, deformer.proxy_render)
        for obj in bpy.data.objects
        for deformer in deformers_of(obj)
    )


def hold_rest(deformer: SinewDeformer, meshes: tuple[Mesh, Mesh | None]) -> None:
    """Store the rest meshes in the datablocks that the deformer has already; ``meshes`` are used up.

    Blender's undo skips objects that two steps agree on. If a timer replaced the mesh of such an object by a
    new one in between, undo would remove the mesh and leave a pointer to it.
    """
    shown, rendered = meshes
    lent = sum(
        row.rest == deformer.rest
        for obj in bpy.data.objects
        for other in deformers_of(obj)
        for row in other.companions
        if deformer.companions
    )
    deformer.rest = put_mesh(deformer.rest, shown, lent)
    hold_rendered_rest(deformer, rendered)


def hold_rendered_rest(deformer: SinewDeformer, rendered: Mesh | None) -> None:
    """Store the rest mesh for renders, which is used up; None if it is the one for viewports."""
    deformer.rest_render = put_mesh(deformer.rest_render, rendered or bpy.data.meshes.new(Datablocks.REST))


def put_mesh(held: Mesh | None, new: Mesh, lent: int = 0) -> Mesh:
    """What to hold from now on: ``held`` with the contents of ``new``, or ``new`` if others use ``held``.

    ``lent``: how many of the users are to have the new contents, too.
    """
    if not isinstance(held, Mesh) or held.library is not None or held.users != 1 + lent:
        return new
    replace_rest(held, new)
    bpy.data.meshes.remove(new)
    return held


def release_rest(deformer: SinewDeformer) -> None:
    """Forget the rest meshes of a deformer. Those that a copy of the target uses stay in the file."""
    companions = [row.rest for row in deformer.companions]
    deformer.companions.clear()
    meshes, deformer.rest, deformer.rest_render = (deformer.rest, deformer.rest_render), None, None
    free_meshes(*meshes, *companions)


def free_meshes(*meshes: Mesh | None) -> None:
    """Remove the hidden meshes that have no user any more."""
    for mesh in meshes:
        if isinstance(mesh, Mesh) and mesh.library is None and mesh.users == 0:
            bpy.data.meshes.remove(mesh)

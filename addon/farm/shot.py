# SPDX-License-Identifier: GPL-3.0-or-later
"""Opens a shot without a window and without its scripts, and finds in it what to bake."""

import hashlib
import os
from pathlib import Path

import bpy
from bpy.types import Object

from ..backend import availability, limit_memory, limit_threads
from ..bake import Origin, missing_frames
from ..core.errors import BackendMissingError, OutOfMemoryError, SinewError
from ..ids import VERSION
from ..properties import SinewDeformer, deformers_of
from ..session.datablocks.owners import owners
from ..session.state import sessions
from ..session.targets import modified

try:
    import resource
except ImportError:  # Windows does not tell
    resource = None

_GIGABYTE = 1024**3
_BLOCK = 1 << 20


def origin_of(shot: str, wanted: str) -> Origin:
    """What chunks are made from. Raises an error if there is no such file, or no native module."""
    module = availability().module
    if module is None:
        raise BackendMissingError(availability().remedy, remedy=BackendMissingError.remedy.NONE)
    path, digest = os.path.abspath(shot), hashlib.sha256()
    try:
        with Path(path).open("rb") as file:
            while block := file.read(_BLOCK):
                digest.update(block)
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", error)
        raise SinewError(f"Cannot read {shot}: {reason} - give the path of a .blend file") from None
    kernels = module.instructions().lower().replace("-", "")
    version = bpy.app.version_string
    return Origin(digest.hexdigest(), path, {}, VERSION, version, kernels, wanted)


def open_shot(path: str) -> None:
    """Open a .blend file. No script in the file runs."""
    try:
        bpy.ops.wm.open_mainfile(filepath=path, load_ui=False, use_scripts=False)
    except RuntimeError as error:
        raise SinewError(f"Blender cannot open {path}: {' '.join(str(error).split())}") from error
    for library in bpy.data.libraries:
        path = bpy.path.abspath(library.filepath, library=library.parent)
        if library.packed_file is None and not os.path.isfile(path):
            raise SinewError(f"The library {path} that the shot links is missing - put it there")


def own_object(name: str) -> Object:
    """An object of the shot itself, or an override."""
    obj = bpy.data.objects.get((name, None))
    if obj is None:
        is_linked = any(other.name == name for other in bpy.data.objects)
        remedy = "is linked - make a library override of it" if is_linked else "is not in the shot"
        raise SinewError(f"The object {name} {remedy}")
    return obj


def last_deformer(obj: Object, frames: range) -> SinewDeformer:
    """The last of an object's deformers in the stack, all of which have to be bound and shown."""
    deformers = deformers_of(obj)
    if not deformers:
        raise SinewError(f"{obj.name} has no deformer - add one, or leave the object out")
    stack = list(obj.modifiers)
    for deformer in deformers:
        shows = modified.shown_by(obj, deformer)
        if not deformer.is_bound:
            raise SinewError(f"{deformer.name} of {obj.name} is not bound - press Bind, and save the shot")
        if not deformer.live and not deformer.bake.is_baked:
            raise SinewError(f"{deformer.name} of {obj.name} is not live - switch Live on, and save the shot")
        if shows is None or not (shows.show_viewport or deformer.bake.is_baked):
            raise SinewError(
                f"{deformer.name} of {obj.name} is off in the viewport - switch its modifier on or remove "
                "the deformer, and save the shot"
            )
        lost = missing_frames(bpy.context.scene, obj, deformer, frames)
        if lost:
            raise SinewError(lost[0])
    return max(deformers, key=lambda each: stack.index(modified.shown_by(obj, each)))


def bind_seconds() -> float:
    """How long all binds in this process have taken."""
    known = [sessions.find(deformer.uid) for obj in owners() for deformer in obj.sinew.deformers]
    return sum(each.bound.milliseconds for each in known if each is not None and each.bound) / 1000.0


def peak_memory() -> int:
    """The most bytes that this process has taken so far; 0 where the system does not tell."""
    status = Path("/proc/self/status")
    if status.is_file():
        for line in status.read_text().splitlines():
            if line.startswith("VmHWM:"):
                return int(line.split()[1]) * 1024
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss if resource else 0  # in bytes on macOS


def limit(threads: int, gigabytes: float) -> None:
    """Let the library use so many threads, and what is left of the memory. 0 is no limit."""
    limit_threads(threads)
    if gigabytes:
        require_memory(gigabytes)
    limit_memory(max(1, round(gigabytes * _GIGABYTE) - peak_memory()) if gigabytes else 0)


def require_memory(gigabytes: float) -> None:
    """Raise an error if this process has taken more than its limit; 0 is no limit."""
    taken = peak_memory() / _GIGABYTE
    if 0.0 < gigabytes < taken:
        raise OutOfMemoryError(
            f"The process takes {taken:.2f} GB, and --memory allows {gigabytes:g} - allow more, or bake "
            "fewer objects at once"
        )

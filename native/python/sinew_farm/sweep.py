# SPDX-License-Identifier: GPL-3.0-or-later
"""Sweeps of meshes x poses x parameters on a Dask cluster, without Blender.

A sweep has two functions: ``bind(mesh, **parameters)`` prepares a mesh, ``solve(bound, pose)`` gives its
points in a pose. Each worker keeps what it has bound, so poses of one mesh share a factorisation. Each result
is a file with a manifest beside it, both put in place by renaming: a sweep that was stopped goes on where it
was.
"""

import hashlib
import io
import itertools
import json
import os
import re
import threading
from collections import OrderedDict
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from distributed import Client, as_completed

from .errors import FarmError

Bind = Callable[..., Any]
Solve = Callable[[Any, Any], np.ndarray]
CACHE_BYTES = 1_000_000_000  # of what one worker keeps bound


@dataclass(frozen=True)
class Mesh:
    """A mesh at rest, with its handles.

    points   (n, 3) positions, in any unit
    faces    a tuple (counts (m,), indices (sum of counts,)), as ``sinew_native.SurfaceMesh`` takes it
    handles  vertex indices of each handle, or nothing for functions that need none
    """

    points: np.ndarray
    faces: tuple[np.ndarray, np.ndarray]
    handles: Sequence[np.ndarray] = ()

    def hash(self, parameters: Mapping[str, Any]) -> str:
        """SHA-256 of points, faces and handles, and of the parameters of a bind."""
        found = hashlib.sha256(json.dumps(parameters, sort_keys=True, default=str).encode())
        arrays = [np.ascontiguousarray(self.points, np.float64)]
        arrays += [np.ascontiguousarray(part, np.int64) for part in (*self.faces, *self.handles)]
        for array in arrays:
            found.update(repr(array.shape).encode())
            found.update(array.tobytes())
        return found.hexdigest()


@dataclass(frozen=True)
class Bound:
    """A method of ``sinew_native`` that holds its factors, and how many bytes these take."""

    method: Any
    nbytes: int


def bind_surface(mesh: Mesh, method: str = "arap", **options: Any) -> Bound:
    """Binds a surface method to the mesh and its handles.

    ``method`` is the name of its class in small letters, as ``sinew_native.deform`` takes it, and ``options``
    are those of the class. Raises what the class and ``set_handles`` raise, and FarmError for no such class.
    """
    import sinew_native

    name = method.title().replace("_", "")
    if not issubclass(getattr(sinew_native, name, object), sinew_native.SurfaceMethod):
        raise FarmError(f"method: sinew_native has no surface method '{method}'")
    made = getattr(sinew_native, name)(sinew_native.SurfaceMesh(mesh.points, mesh.faces), **options)
    report = made.set_handles(list(mesh.handles))
    return Bound(made, int(report.factor_bytes) + mesh.points.nbytes)


def solve_surface(bound: Bound, pose: np.ndarray) -> np.ndarray:
    """The (n, 3) points of a bound surface method for a (k, 3, 4) affine map of each handle."""
    return bound.method.solve(pose)[0]


class Cache:
    """What one worker has bound, by hash. What was used longest ago goes where the bytes pass a limit."""

    def __init__(self) -> None:
        self.kept: OrderedDict[str, Any] = OrderedDict()
        self.lock = threading.Lock()

    def get(self, key: str, make: Callable[[], Any], limit: int) -> Any:
        with self.lock:
            if key not in self.kept:
                self.kept[key] = make()
            self.kept.move_to_end(key)
            while len(self.kept) > 1 and sum(_bytes_of(each) for each in self.kept.values()) > limit:
                self.kept.popitem(last=False)
            return self.kept[key]


def _bytes_of(bound: Any) -> int:
    """As an array and ``Bound`` state it."""
    return int(getattr(bound, "nbytes", 0))


CACHE = Cache()  # of this process


@dataclass(frozen=True)
class Sweep:
    """What to compute, and where it goes.

    ``parameters`` are values by name, of which every combination is bound. ``format`` is "npy" or "obj".
    ``bind`` and ``solve`` have to be importable on the workers.
    """

    meshes: Mapping[str, Mesh]
    poses: Mapping[str, Any]
    out: Path
    parameters: Mapping[str, Sequence[Any]] | None = None
    format: str = "npy"
    bind: Bind = bind_surface
    solve: Solve = solve_surface
    cache_bytes: int = CACHE_BYTES

    def run(self, client: Client, tell: Callable[[Path], None] = lambda file: None) -> list[Path]:
        """Computes what is missing, and returns the files of all results, in the order of the sweep.

        ``tell`` hears of each file once it is there. Raises FarmError where results failed, which names the
        first of them with its reason, after all others are there.
        """
        if self.format not in WRITERS:
            raise FarmError(f"format: '{self.format}' is neither {' nor '.join(WRITERS)}")
        self.out.mkdir(parents=True, exist_ok=True)
        tasks, failed = {}, []
        for title, mesh in self.meshes.items():
            shared = client.submit(_same, mesh, key=f"mesh-{mesh.hash({})}")
            for result in self._results(title, mesh):
                tasks[client.submit(_Result.make, result, shared, pure=False)] = result.file
        files = list(tasks.values())
        if len(set(files)) < len(files):
            raise FarmError("meshes, parameters or poses have names that make the same file")
        for task in as_completed(list(tasks), raise_errors=False):
            file = tasks[task]
            if task.status == "finished":
                tell(file)
            else:
                failed.append(
                    f"{file.name}: {task.exception() if task.status == 'error' else 'scheduler lost'}"
                )
        if failed:
            raise FarmError(f"{len(failed)} of {len(files)} results failed; {failed[0]}")
        return files

    def _results(self, title: str, mesh: Mesh) -> Iterator["_Result"]:
        names = list(self.parameters or {})
        for values in itertools.product(*(self.parameters or {}).values()):
            chosen = dict(zip(names, values))
            key = mesh.hash({"": _name(self.bind), **chosen})
            for pose, posed in self.poses.items():
                words = [title, *(f"{name}={value}" for name, value in chosen.items()), pose]
                file = self.out.resolve() / (re.sub(r"[^\w.,=+-]", "_", ",".join(words)) + f".{self.format}")
                yield _Result(self.bind, self.solve, self.cache_bytes, chosen, posed, key, file)


@dataclass(frozen=True)
class _Result:
    """One result of a sweep, as a worker makes it."""

    bind: Bind
    solve: Solve
    cache_bytes: int
    chosen: dict[str, Any]
    posed: Any
    key: str
    file: Path

    def make(self, mesh: Mesh) -> None:
        """Writes the file and its manifest, unless they are there and valid."""
        manifest = self.file.with_name(self.file.name + ".json")
        made_from = {"bind": self.key, "solve": _name(self.solve), "pose": _hash_of(self.posed)}
        if _is_valid(self.file, manifest, made_from):
            return
        bound = CACHE.get(self.key, lambda: self.bind(mesh, **self.chosen), self.cache_bytes)
        points = self.solve(bound, self.posed)
        stream = io.BytesIO()
        WRITERS[self.file.suffix[1:]](stream, points, mesh)
        content = stream.getvalue()
        _put(self.file, content)
        told = {**made_from, "parameters": self.chosen, "points": len(points), "sha256": _sha(content)}
        _put(manifest, json.dumps(told, default=str).encode())


def _same(mesh: Mesh) -> Mesh:
    """A task of its own, so that a mesh is sent once, and again where its worker dies."""
    return mesh


def _is_valid(file: Path, manifest: Path, made_from: Mapping[str, str]) -> bool:
    try:
        told = json.loads(manifest.read_bytes())
        return told.items() >= made_from.items() and told["sha256"] == _sha(file.read_bytes())
    except (OSError, ValueError, KeyError, AttributeError):
        return False


def _put(file: Path, content: bytes) -> None:
    """Writes a file as a whole, or nothing."""
    part = file.with_name(f".{file.name}.{os.getpid()}-{threading.get_ident()}")
    try:
        part.write_bytes(content)
        part.replace(file)
    finally:
        part.unlink(missing_ok=True)


def _write_npy(stream: io.BytesIO, points: np.ndarray, mesh: Mesh) -> None:
    np.save(stream, points, allow_pickle=False)


def _write_obj(stream: io.BytesIO, points: np.ndarray, mesh: Mesh) -> None:
    counts, indices = mesh.faces
    lines = ["v {} {} {}".format(*point) for point in np.asarray(points).tolist()]
    for face in np.split(np.asarray(indices) + 1, np.cumsum(counts)[:-1]):
        lines.append("f " + " ".join(map(str, face.tolist())))
    stream.write("\n".join([*lines, ""]).encode())


WRITERS = {"npy": _write_npy, "obj": _write_obj}


def _hash_of(value: Any) -> str:
    if isinstance(value, np.ndarray):
        return _sha(f"{value.dtype}{value.shape}".encode() + np.ascontiguousarray(value).tobytes())
    return _sha(json.dumps(value, sort_keys=True, default=repr).encode())


def _sha(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _name(function: Callable) -> str:
    return f"{function.__module__}.{getattr(function, '__qualname__', function)}"

# SPDX-License-Identifier: GPL-3.0-or-later
"""Chunks: PC2 files with some frames of one object, each beside a manifest that says what the chunk holds.

Processes and machines bake chunks side by side, and a join writes the file that one Bake writes. A chunk
without a manifest that fits its content counts as missing, so one that a killed process left is made anew.
"""

import hashlib
import json
import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass
from pathlib import Path

import bpy
import numpy as np
from bpy.types import Depsgraph, Object, Scene

from ..core.errors import SinewError
from ..session.state import sessions
from . import files, paths
from .files import CacheFile
from .job import Baking, Part, Request

FOLDER = "chunks"
_PLAIN = frozenset(b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_- ")
_HEADER = 32  # bytes of a PC2 file before its samples
_LONGEST = 65_536  # bytes of a manifest
_ALIKE = ("shot", "wedge", "sinew", "blender", "kernels", "rate")  # in all chunks of a join


@dataclass(frozen=True)
class Origin:
    """What a process makes chunks from: the .blend ``file`` and its SHA-256, ``shot``; the values of a
    ``wedge``; the versions of Sinew and of Blender; the instructions that the ``kernels`` use; and the
    ``format`` of the end.
    """

    shot: str
    file: str
    wedge: Mapping[str, str]
    sinew: str
    blender: str
    kernels: str
    format: str


@dataclass(frozen=True)
class Manifest(Origin):
    """What one chunk holds. ``frames`` are the first, the last and the step, ``rate`` is the number of frames
    per second, and ``points`` is the SHA-256 of the samples.
    """

    object: str = ""
    frames: Sequence[int] = (0, 0, 1)
    rate: float = 0.0
    vertices: int = 0
    points: str = ""

    @property
    def range(self) -> range:
        """The frames in the chunk."""
        first, last, step = self.frames
        return range(first, last + 1, step)


@dataclass(frozen=True)
class Chunk:
    """A chunk on the disk, whose content fits its manifest."""

    path: Path
    manifest: Manifest

    def samples(self) -> np.ndarray:
        """The positions, float32 (frames, n, 3), which are read from the disk as they are used."""
        shape = (len(self.manifest.range), self.manifest.vertices, 3)
        return np.memmap(self.path, dtype="<f4", mode="r", offset=_HEADER, shape=shape)


def file_name(text: str, plain: bytes = b"") -> str:
    """A name that is one file in any system, and another one for each text. What is not ``plain`` is %XX."""
    kept = _PLAIN.union(plain)
    return "".join(chr(byte) if byte in kept else f"%{byte:02X}" for byte in text.encode())


def chunk_path(folder: Path, name: str, frames: range) -> Path:
    """The path of the chunk of an object. Raises an error if a link leads outside the folder."""
    return paths.below(folder, FOLDER, f"{file_name(name)}.{frames[0]}-{frames[-1]}.pc2")


def find(path: Path) -> Chunk | None:
    """The chunk at a path, if it is complete and as its manifest says."""
    manifest = _manifest(path)
    if manifest is None or path.is_symlink():
        return None
    try:
        chunk = Chunk(path, manifest)
        size = _HEADER + 12 * len(manifest.range) * manifest.vertices
        if path.stat().st_size != size or hashlib.sha256(chunk.samples()).hexdigest() != manifest.points:
            return None
    except (OSError, ValueError):
        return None
    return chunk


def find_all(folder: Path, name: str) -> list[Chunk]:
    """All chunks of an object in a folder, by their first frames."""
    found = [find(path) for path in sorted(paths.below(folder, FOLDER).glob(f"{file_name(name)}.*.pc2"))]
    ours = [chunk for chunk in found if chunk is not None and chunk.manifest.object == name]
    return sorted(ours, key=lambda chunk: chunk.manifest.frames[0])


def is_made(path: Path, name: str, frames: range, origin: Origin) -> bool:
    """Whether the chunk of an object is there already, made from the same shot by the same versions."""
    chunk = find(path)
    return chunk is not None and (
        chunk.manifest.object == name
        and chunk.manifest.range == frames
        and all(getattr(chunk.manifest, key) == getattr(origin, key) for key in _ALIKE[:4])
    )


def difference(one: Manifest, other: Manifest, of_one_object: bool) -> str:
    """The first thing in which two chunks of a join may not differ, or an empty text."""
    keys = (*_ALIKE, "vertices") if of_one_object else _ALIKE
    return next((key for key in reversed(keys) if getattr(one, key) != getattr(other, key)), "")


def _manifest(path: Path) -> Manifest | None:
    """What the manifest beside a chunk says; None if it is not there, or no manifest."""
    try:
        with open(_beside(path), encoding="utf-8") as file:
            found = Manifest(**json.JSONDecoder().decode(file.read(_LONGEST)))
        texts = (found.shot, found.file, found.sinew, found.blender, found.kernels, found.object)
        is_right = (
            all(isinstance(text, str) for text in (*texts, *found.wedge, *found.wedge.values()))
            and all(type(number) is int for number in (*found.frames, found.vertices))
            and len(found.range) > 0 < found.vertices
            and float(found.rate) > 0.0
        )
    except (OSError, TypeError, ValueError, AttributeError, OverflowError, RecursionError):
        return None
    return found if is_right else None


def _beside(path: Path) -> Path:
    return path.with_suffix(".json")


class _ChunkFile(CacheFile):
    """A chunk that is being written, and the digest of its samples so far."""

    def __init__(self, path: Path, frames: range, rate: float) -> None:
        super().__init__(path, "PC2", frames, rate)
        self.rate, self.points, self.vertices = rate, hashlib.sha256(), 0
        self.begun = os.fstat(self._file.fileno()).st_mtime

    def append(self, positions: np.ndarray) -> None:
        super().append(positions)
        self.points.update(np.ascontiguousarray(positions, dtype="<f4"))
        self.vertices = len(positions)


class ChunkBaking(Baking):
    """Bakes the same frames of several objects into a chunk each. Call ``keep`` in place of ``finish``.

    The scene stays at the last frame, as the next chunk begins with a frame of its own.
    """

    def __init__(
        self, deformers: tuple[tuple[str, str], ...], frames: range, folder: Path, origin: Origin
    ) -> None:
        self._folder, self._origin = folder, origin
        super().__init__(Request(deformers, "PC2", frames), bpy.context.scene)

    def _place(self, part: Part, scene: Scene) -> str:
        if self._origin.format == "shape_keys":
            self._check_keys(part.reader, part.reader.owner(), part.reader.deformer(), scene)
        return str(chunk_path(self._folder, part.reader.object, self.request.frames))

    def _make_file(self, part: Part, rate: float) -> CacheFile:
        return _ChunkFile(Path(part.filepath), self.request.frames, rate)

    def _restore_frame(self) -> None:
        """There is nobody to look at the frame, and each frame takes a solve."""

    def keep(self) -> list[Path]:
        """Move the chunks to their places, each with its manifest, and end the bake. Returns their paths."""
        frames, made = self.request.frames, []
        for part in self._parts:
            part.file.close()
            told = asdict(self._origin) | {
                "object": part.reader.object,
                "frames": (frames[0], frames[-1], frames.step),
                "rate": part.file.rate,
                "vertices": part.file.vertices,
                "points": part.file.points.hexdigest(),
            }
            with files.replacing(_beside(part.file.path)) as manifest:
                files.write(manifest, json.dumps(told, indent=1).encode())
                part.file.commit()
            _clear_away(part.file)
            made.append(part.file.path)
            part.file = None
        self.cancel()
        return made


def _clear_away(made: _ChunkFile) -> None:
    """Delete what killed processes have left of a chunk: what nobody has written to since it was begun."""
    path = made.path
    with suppress(OSError):
        for part in path.parent.iterdir():
            is_part = part.name.startswith(f".{path.stem}.") and ".part." in part.name
            if is_part and part.lstat().st_mtime < made.begun:
                part.unlink()


class ChunkShowing(Baking):
    """Bakes what chunks hold, without solving anything, to shape keys or to files that modifiers play.

    ``samples`` float32 (frames, n, 3) by the name of the object. ``folder`` is where the files go.
    """

    def __init__(self, request: Request, samples: Mapping[str, Sequence[np.ndarray]], folder: Path) -> None:
        self._samples, self._folder = samples, folder
        super().__init__(request, bpy.context.scene)

    def _place(self, part: Part, scene: Scene) -> str:
        return str(files.partial(self._folder / f"{file_name(part.reader.object)}.pc2"))

    def _read(self, part: Part, depsgraph: Depsgraph) -> np.ndarray:
        return self._samples[part.reader.object][self.done]

    @contextmanager
    def shown(self) -> Iterator[None]:
        """Bake all frames, and delete the files that modifiers play in the end."""
        try:
            with sessions.suspended():
                while self.step():
                    pass
            self.finish()
            yield
        finally:
            self.cancel()
            for part in self._parts:
                if part.filepath:
                    Path(part.filepath).unlink(missing_ok=True)


def write_object(path: Path, obj: Object) -> None:
    """Write an object with all that it needs into a .blend file of its own."""
    with files.replacing(path) as made:
        bpy.data.libraries.write(str(made), {obj}, path_remap="ABSOLUTE", fake_user=True)


def write_joined(path: Path, target: str, frames: range, rate: float, samples: Sequence[np.ndarray]) -> None:
    """Write samples, float32 (n, 3) per frame, into one PC2 or MDD file."""
    file = CacheFile(path, target, frames, rate)
    try:
        for positions in samples:
            file.append(positions)
        file.close()
        file.commit()
    except SinewError:
        file.discard()
        raise

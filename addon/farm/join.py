# SPDX-License-Identifier: GPL-3.0-or-later
"""Joins chunks into what one Bake of all frames makes, to the last bit."""

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path

import bpy
import numpy as np

from ..bake import (
    SUFFIXES,
    Chunk,
    ChunkShowing,
    Request,
    difference,
    export_alembic,
    file_name,
    find_all,
    write_joined,
    write_object,
)
from ..core.errors import SinewError
from . import shot, wedge

Tell = Callable[..., None]
_SUFFIXES = {name.lower(): suffix for name, suffix in SUFFIXES.items()} | {"shape_keys": ".blend"}
_NEVER = "vertices"  # of one object: no file holds several numbers of them


class IncompleteError(SinewError):
    """Chunks are missing, or were not made from the same shot by the same versions and instructions."""


class _Samples(Sequence[np.ndarray]):
    """The shape in each wanted frame, float32 (n, 3), from the chunk that holds it."""

    def __init__(self, frames: range, chunks: Sequence[Chunk]) -> None:
        self._frames, self._chunks = frames, chunks
        self._arrays = {chunk.path: chunk.samples() for chunk in chunks}

    def __len__(self) -> int:
        return len(self._frames)

    def __getitem__(self, index: int) -> np.ndarray:
        chunk, frame = self._chunks[index], self._frames[index]
        return np.array(self._arrays[chunk.path][chunk.manifest.range.index(frame)])


def join(words: argparse.Namespace, tell: Tell) -> None:
    """Write one file per object, from chunks that hold all frames and are alike."""
    folder, (frames,), names = Path(words.folder), words.frames, words.objects
    if not folder.is_dir():
        raise SinewError(f"{folder} is no folder")
    out, suffix = Path(words.out), _SUFFIXES[words.format]
    is_file = len(names) == 1 and out.suffix.lower() == suffix
    targets = {name: out if is_file else out / f"{file_name(name)}{suffix}" for name in names}
    chosen = {name: _choose(folder, name, frames) for name in names}
    _require_alike([chunk for chunks in chosen.values() for chunk in chunks], words.mixed)
    tell("start", frames=list(frames), objects=names, chunks=sum(map(len, map(set, _paths(chosen)))))
    samples = {name: _Samples(frames, chunks) for name, chunks in chosen.items()}
    if words.format in ("pc2", "mdd"):
        for name, path in targets.items():
            rate = chosen[name][0].manifest.rate
            write_joined(path, words.format.upper(), frames, rate, samples[name])
    else:
        _open(words, chosen[names[0]][0])
        _write_by_blender(words.format, frames, targets, samples)
    tell("done", files=[str(path) for path in targets.values()])


def _paths(chosen: Mapping[str, Sequence[Chunk]]) -> Iterator[list[Path]]:
    for chunks in chosen.values():
        yield [chunk.path for chunk in chunks]


def _choose(folder: Path, name: str, frames: range) -> list[Chunk]:
    """The chunk of each frame. Raises an error that names the frames without one."""
    found = find_all(folder, name)
    holding = [next((chunk for chunk in found if frame in chunk.manifest.range), None) for frame in frames]
    lost = [str(frame) for frame, chunk in zip(frames, holding, strict=True) if chunk is None]
    if lost:
        more = f" and {len(lost) - 8} more" if len(lost) > 8 else ""
        raise IncompleteError(
            f"No whole chunk in {folder} holds frame {', '.join(lost[:8])}{more} of {name} - bake them"
        )
    return [chunk for chunk in holding if chunk is not None]


def _require_alike(chunks: Sequence[Chunk], mixed: bool) -> None:
    """Refuse chunks that differ. Those of one object always have to have the same vertices."""
    first: dict[str, Chunk] = {}
    for chunk in chunks:
        name = chunk.manifest.object
        for other in (first.setdefault(name, chunk), chunks[0]):
            what = difference(chunk.manifest, other.manifest, name == other.manifest.object)
            if what and (not mixed or (what == _NEVER)):
                one, two = (getattr(each.manifest, what) for each in (other, chunk))
                raise IncompleteError(
                    f"{other.path} has {what} {one}, but {chunk.path} has {two} - bake one of them again, "
                    "or accept both by --mixed"
                )


def _open(words: argparse.Namespace, chunk: Chunk) -> None:
    """Open the shot that the chunks were made from, with the values of their wedge."""
    manifest = chunk.manifest
    path = words.shot or manifest.file
    if shot.origin_of(path, words.format).shot != manifest.shot:
        raise SinewError(f"{path} is not the shot that the chunks were made from - give it by --shot")
    shot.open_shot(path)
    for name in words.objects:
        wedge.Cell(Path(words.folder), dict(manifest.wedge)).apply(shot.own_object(name))


def _write_by_blender(
    wanted: str, frames: range, targets: Mapping[str, Path], samples: Mapping[str, Sequence[np.ndarray]]
) -> None:
    """Show the samples in the open shot instead of its deformers, and let Blender write each object."""
    objects = {name: shot.own_object(name) for name in targets}
    deformers = tuple((name, shot.last_deformer(obj, frames).uid) for name, obj in objects.items())
    keys = wanted == "shape_keys"
    request = Request(deformers, "SHAPE_KEYS" if keys else "PC2", frames)
    folder = next(iter(targets.values())).parent
    with ChunkShowing(request, samples, folder).shown():
        for name, path in targets.items():
            if keys:
                write_object(path, objects[name])
            else:
                export_alembic(bpy.context, [objects[name]], frames, str(path))

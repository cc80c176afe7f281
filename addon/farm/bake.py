# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes frames of a shot into chunks. Each frame depends on itself and its keys alone.

So frames may be baked in any order, in any process, again and again, and have the same bits.
"""

import argparse
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path

import bpy

from ..bake import ChunkBaking, Origin, chunk_path, is_made, require_exportable
from ..core.memory import forget_all
from . import shot, wedge

Tell = Callable[..., None]


def bake(words: argparse.Namespace, tell: Tell) -> None:
    """Make the chunks that are missing: for each combination of a wedge, in a folder of its own."""
    out, origin = Path(words.out), shot.origin_of(words.shot, words.format)
    cells = wedge.cells(out, words.wedge)
    tell(
        "start",
        frames=[frame for frames in words.frames for frame in frames],
        objects=words.objects,
        chunks=len(list(_split(words))) * len(words.objects) * len(cells),
        folders=[str(cell.folder) for cell in cells],
    )
    for cell in cells:
        _bake_cell(words, cell, replace(origin, wedge=cell.values), tell)
    if words.wedge:
        tell("sheet", file=str(wedge.write_sheet(out, cells)))
    tell("done")


def _split(words: argparse.Namespace) -> Iterator[range]:
    """The frames of each chunk."""
    for frames in words.frames:
        size = words.chunk or len(frames)
        yield from (frames[at : at + size] for at in range(0, len(frames), size))


def _bake_cell(words: argparse.Namespace, cell: wedge.Cell, origin: Origin, tell: Tell) -> None:
    todo: list[tuple[range, list[str]]] = []
    for frames in _split(words):
        paths = {name: chunk_path(cell.folder, name, frames) for name in words.objects}
        made = [name for name, path in paths.items() if is_made(path, name, frames, origin)]
        for name in made:
            tell("chunk", file=str(paths[name]), skipped=True)
        todo.append((frames, [name for name in paths if name not in made]))
    todo = [(frames, names) for frames, names in todo if names]
    if not todo and cell.is_rendered():
        return
    _open(words, cell)
    is_bound = False
    for frames, names in todo:
        baking = ChunkBaking(_deformers(words, frames, names), frames, cell.folder, origin)
        try:
            has_more = True
            while has_more:
                has_more = baking.step()
                if not is_bound:
                    is_bound = True
                    tell("bound", seconds=shot.bind_seconds(), bytes=shot.peak_memory())
                shot.require_memory(words.memory)
                tell("frame", frame=frames[baking.done - 1])
            for path in baking.keep():
                tell("chunk", file=str(path), skipped=False)
        finally:
            baking.cancel()
    if cell.values:
        cell.render(words.frames[-1][-1], words.objects)


def _open(words: argparse.Namespace, cell: wedge.Cell) -> None:
    """Open the shot with the values of a wedge, and bind for them anew, as another process would."""
    shot.limit(words.threads, words.memory)
    shot.open_shot(words.shot)
    shot.require_memory(words.memory)
    if cell.values:
        for name in words.objects:
            cell.apply(shot.own_object(name))
        forget_all()
        bpy.context.view_layer.update()


def _deformers(words: argparse.Namespace, frames: range, names: list[str]) -> tuple[tuple[str, str], ...]:
    """The deformers to read, each as the name of its object and its key."""
    found = [(name, shot.last_deformer(shot.own_object(name), frames).uid) for name in names]
    if words.format == "alembic":
        require_exportable([shot.own_object(name) for name in names], frames)
    return tuple(found)

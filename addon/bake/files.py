# SPDX-License-Identifier: GPL-3.0-or-later
"""Point cache files, frame after frame, each replaced in one step: a reader never meets half a file.

PC2: ``POINTCACHE2``, int version, int points, float start, float rate, int samples, all little-endian, then
the samples (points, 3). MDD: big-endian, int samples, int points, float times in seconds, then the samples.
"""

import contextlib
import os
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..core.errors import SinewError

SUFFIXES = {"PC2": ".pc2", "MDD": ".mdd", "ALEMBIC": ".abc"}


class CacheFile:
    """A file being written. It takes its place by ``commit``, and leaves no trace by ``discard``."""

    def __init__(self, path: Path, target: str, frames: range, rate: float) -> None:
        self.path = path
        self._target, self._frames, self._rate = target, frames, rate
        self._part = partial(path)
        self._folders: list[Path] = []
        self._file = None
        with _explained(path):
            self._folders = _make_folders(path.parent)
            self._file = open(self._part, "wb")  # noqa: SIM115 (kept open from frame to frame)

    def append(self, positions: np.ndarray) -> None:
        """One more frame, float32 (n, 3). The first one decides n."""
        with _explained(self.path):
            if self._file.tell() == 0:
                self._file.write(self._header(len(positions)))
            self._file.write(positions.astype("<f4" if self._target == "PC2" else ">f4").tobytes())

    def _header(self, points: int) -> bytes:
        samples = len(self._frames)
        if self._target == "PC2":
            start, rate = float(self._frames.start), float(self._frames.step)
            return struct.pack("<12siiffi", b"POINTCACHE2\0", 1, points, start, rate, samples)
        times = np.array(self._frames, dtype=np.float64) / self._rate
        return struct.pack(">ii", samples, points) + times.astype(">f4").tobytes()

    def close(self) -> None:
        """Everything is on the disk, under its temporary name."""
        with _explained(self.path):
            self._file.flush()
            os.fsync(self._file.fileno())
            self._file.close()

    def commit(self) -> None:
        """Take the place of an older file."""
        with _explained(self.path):
            os.replace(self._part, self.path)

    def discard(self) -> None:
        """Leave the disk as it was."""
        if self._file is not None:
            with contextlib.suppress(OSError):  # a full disk refuses what is still in the buffer
                self._file.close()
            self._part.unlink(missing_ok=True)
        for folder in self._folders:
            with contextlib.suppress(OSError):  # another file came into it meanwhile
                folder.rmdir()


def partial(path: Path) -> Path:
    """Where a file is written before it takes its place: in the same folder, with the same ending."""
    return path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")


def _make_folders(folder: Path) -> list[Path]:
    """Make a folder and those above it; the new ones, the deepest first."""
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    for each in reversed(missing):
        each.mkdir(exist_ok=True)
    return missing


@contextlib.contextmanager
def _explained(path: Path) -> Iterator[None]:
    """What the disk refuses is said to the user."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise SinewError(f"Cannot write {path}: {reason} - choose another place, or make room") from error


def exchange(path: Path, made: Path) -> None:
    """Let a finished file ``made`` take the place of ``path``."""
    with _explained(path):
        os.replace(made, path)


def prepare_folder(path: Path) -> None:
    """The folder of a file that another writer makes."""
    with _explained(path):
        _make_folders(path.parent)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Point cache files, written frame after frame. A file replaces an older one only when it is complete.

PC2: ``POINTCACHE2``, int version, int points, float start, float rate, int samples, all little-endian, then
the samples (points, 3). MDD: big-endian, int samples, int points, float times in seconds, then the samples.
"""

import contextlib
import errno
import os
import struct
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from ..core.errors import SinewError

SUFFIXES = {"PC2": ".pc2", "MDD": ".mdd", "ALEMBIC": ".abc"}


class CacheFile:
    """A file that is being written. ``commit`` moves it to its path, and ``discard`` deletes it."""

    def __init__(self, path: Path, target: str, frames: range, rate: float) -> None:
        self.path = path
        self._target, self._frames, self._rate = target, frames, rate
        self._part = partial(path)
        self._folders: list[Path] = []
        self._file = None
        with _readable_errors(path):
            self._folders = _make_folders(path.parent)
            self._part.unlink(missing_ok=True)  # of a process with the same number that was killed
            self._file = open(self._part, "xb")  # noqa: SIM115 (kept open from frame to frame; no link)

    def append(self, positions: np.ndarray) -> None:
        """Write one more frame, float32 (n, 3). The first frame decides n."""
        with _readable_errors(self.path):
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
        """Write everything to the disk, still under the temporary name."""
        with _readable_errors(self.path):
            self._file.flush()
            os.fsync(self._file.fileno())
            self._file.close()

    def commit(self) -> None:
        """Move the file to its path, where it replaces an older file."""
        with _readable_errors(self.path):
            os.replace(self._part, self.path)

    def discard(self) -> None:
        """Delete the file and the folders that were made for it."""
        if self._file is not None:
            with contextlib.suppress(OSError):  # on a full disk the rest of the buffer cannot be written
                self._file.close()
            self._part.unlink(missing_ok=True)
        _remove(self._folders)


def write(path: Path, content: bytes) -> None:
    """Write a small new file at once, down to the disk."""
    with _readable_errors(path), open(path, "xb") as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())


def partial(path: Path) -> Path:
    """The temporary path of a file that is being written: in the same folder, with the same suffix."""
    return path.with_name(f".{path.stem}.{os.getpid()}.part{path.suffix}")


def _make_folders(folder: Path) -> list[Path]:
    """Make a folder and its missing parents. Returns the new folders, the deepest first."""
    missing = [each for each in (folder, *folder.parents) if not each.exists()]
    for each in reversed(missing):
        each.mkdir(exist_ok=True)
    return missing


@contextlib.contextmanager
def _readable_errors(path: Path) -> Iterator[None]:
    """Turn an error of the operating system into one that the artist can read."""
    try:
        yield
    except OSError as error:
        reason = error.strerror or str(error)
        raise SinewError(
            f"Cannot write {path}: {reason} - choose another folder, or free some disk space"
        ) from error


@contextlib.contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """The temporary path of a file that is written meanwhile, which then replaces an older one at ``path``.

    If Blender fails, neither the file stays nor the folders that were made for it.
    """
    made, folders = partial(path), []
    try:
        with _readable_errors(path):
            folders = _make_folders(path.parent)
            made.unlink(missing_ok=True)
            yield made
            if not made.is_file():
                raise OSError(errno.EIO, "Blender could not write it")
            os.replace(made, path)
    except RuntimeError as error:
        raise SinewError(f"Blender could not write {path}: {error}") from error
    finally:
        made.unlink(missing_ok=True)
        _remove(folders)


def _remove(folders: list[Path]) -> None:
    """Remove the folders that are empty."""
    for folder in folders:
        with contextlib.suppress(OSError):  # the folder holds another file by now
            folder.rmdir()

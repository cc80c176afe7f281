# SPDX-License-Identifier: GPL-3.0-or-later
"""Reads and writes zips and wheels as dictionaries of path -> content. Equal content gives equal bytes."""

import base64
import contextlib
import hashlib
import os
import shutil
import zipfile
from collections.abc import Iterator
from pathlib import Path

FIRST_DAY = (1980, 1, 1, 0, 0, 0)
PACKED_ALREADY = (".whl", ".png", ".jpg", ".webp", ".blend")


@contextlib.contextmanager
def written_whole(target: Path) -> Iterator[Path]:
    """A file to write, in the folder of ``target``, whose place it takes once all is written."""
    part = target.with_name(f".{target.name}.{os.getpid()}")
    try:
        yield part
        part.replace(target)
    finally:
        part.unlink(missing_ok=True)


def read_folder(folder: Path) -> dict[str, bytes]:
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def read_zip(source: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(source) as archive:
        return {name: archive.read(name) for name in archive.namelist() if not name.endswith("/")}


def unpack(source: Path, target: Path) -> Path:
    """Unpacks a zip into a folder that holds nothing else then."""
    shutil.rmtree(target, ignore_errors=True)
    with zipfile.ZipFile(source) as archive:
        archive.extractall(target)
    return target


def write_zip(target: Path, files: dict[str, bytes]) -> Path:
    """Writes a zip. Whoever reads it at the same time finds the whole of the old or of the new one."""
    target.parent.mkdir(parents=True, exist_ok=True)
    with written_whole(target) as part, zipfile.ZipFile(part, "w") as archive:
        for name in sorted(files):
            entry = zipfile.ZipInfo(name, FIRST_DAY)
            entry.external_attr = 0o100644 << 16
            entry.create_system = 3  # Unix, on every system
            packed = name.endswith(PACKED_ALREADY)
            entry.compress_type = zipfile.ZIP_STORED if packed else zipfile.ZIP_DEFLATED
            archive.writestr(entry, files[name])
    return target


def write_wheel(target: Path, files: dict[str, bytes]) -> Path:
    """Does the same as write_zip(), and writes the RECORD of the wheel again."""
    record = next(name for name in files if name.endswith(".dist-info/RECORD"))
    rows = sorted((name, content) for name, content in files.items() if name != record)
    digests = [base64.urlsafe_b64encode(hashlib.sha256(content).digest()) for _name, content in rows]
    hashes = [digest.rstrip(b"=").decode() for digest in digests]
    lines = [f"{name},sha256={digest},{len(content)}\n" for (name, content), digest in zip(rows, hashes)]
    return write_zip(target, files | {record: "".join([*lines, f"{record},,\n"]).encode()})

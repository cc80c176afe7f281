# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs commands, and remembers what was already done."""

import contextlib
import fcntl
import hashlib
import json
import os
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from .places import BUILD, ROOT

TIMED_OUT = 124
_set_ups = 0  # how many calls of one_at_a_time() enclose this place


def say(text: str) -> None:
    print(text, flush=True)


def jobs() -> int:
    return len(os.sched_getaffinity(0))


@contextlib.contextmanager
def one_at_a_time() -> Iterator[None]:
    """Lets only one process at a time install or build something in this checkout. It may be nested."""
    global _set_ups
    BUILD.mkdir(exist_ok=True)
    with (BUILD / "set-up.lock").open("w") as lock:
        if _set_ups == 0:
            fcntl.flock(lock, fcntl.LOCK_EX)
        _set_ups += 1
        try:
            yield
        finally:
            _set_ups -= 1


def environment(extra: Mapping[str, str | Path] | None = None) -> dict[str, str]:
    """The environment of this process, without variables that would disturb a build or a Blender."""
    disturbing = ("PYTHONPATH", "PYTHONHOME", "PYTHONSTARTUP", "VIRTUAL_ENV", "LD_LIBRARY_PATH", "LD_PRELOAD")
    kept = {name: value for name, value in os.environ.items() if name not in disturbing}
    kept |= compiler_cache() | {"PYTHONDONTWRITEBYTECODE": "1"}
    return kept | {name: str(value) for name, value in (extra or {}).items()}


def compiler_cache() -> dict[str, str]:
    """The settings of ccache, which CMakePresets.json states for calls of CMake by hand."""
    presets = json.loads((ROOT / "CMakePresets.json").read_text(encoding="utf-8"))["configurePresets"]
    settings = next(preset["environment"] for preset in presets if preset["name"] == "base")
    return {name: value.replace("${sourceDir}", str(ROOT)) for name, value in settings.items()}


def run(
    command: Iterable[str | Path],
    *,
    env: Mapping[str, str | Path] | None = None,
    cwd: Path = ROOT,
    timeout: float | None = None,
    quiet: bool = False,
) -> int:
    """Runs a command and returns its exit status. After ``timeout`` the command is stopped, with all
    processes that it started. ``quiet`` shows its output only if it fails."""
    sink = subprocess.PIPE if quiet else None
    with subprocess.Popen(
        [str(word) for word in command],
        cwd=cwd,
        env=environment(env),
        stdin=subprocess.DEVNULL,
        stdout=sink,
        stderr=subprocess.STDOUT if quiet else None,
        text=True,
        errors="replace",
        start_new_session=True,
    ) as process:
        output = ""
        try:
            output, _ = process.communicate(timeout=timeout)
            status = process.returncode
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            output, _ = process.communicate()
            status = TIMED_OUT
            say(f"stopped after {timeout:.0f} s")
        except KeyboardInterrupt:
            os.killpg(process.pid, signal.SIGTERM)
            raise
    if quiet and status != 0:
        sys.stderr.write(output or "")
    return status


def must(command: Iterable[str | Path], *, lacking: str = "", **options) -> None:
    """Does the same as run(), but ends the tool if the command fails. ``lacking`` says what cannot be had
    then; without it the command itself is named."""
    words = [str(word) for word in command]
    status = run(words, **options)
    if status != 0:
        raise SystemExit(lacking or f"failed with {status}: {' '.join(words)}")


def said(command: Iterable[str | Path], **options) -> str:
    """What a command prints, which has to succeed."""
    words = [str(word) for word in command]
    return subprocess.run(words, stdout=subprocess.PIPE, text=True, check=True, **options).stdout


def git(*words: str) -> str:
    """What git says about this checkout; nothing where it cannot tell."""
    if not shutil.which("git"):
        return ""
    return subprocess.run(["git", *words], cwd=ROOT, stdout=subprocess.PIPE, text=True).stdout.strip()


def fingerprint(paths: Iterable[Path], *words: str) -> str:
    """A digest of the names and contents of files, also those in folders, and of some words."""
    digest = hashlib.sha256("\0".join(words).encode())
    for path in sorted(set(_files(paths))):
        digest.update(str(path.relative_to(ROOT)).encode() + b"\0")
        digest.update(hashlib.sha256(path.read_bytes()).digest())
    return digest.hexdigest()


def _files(paths: Iterable[Path]) -> Iterable[Path]:
    for path in paths:
        if path.is_dir():
            yield from (f for f in path.rglob("*") if f.is_file() and "__pycache__" not in f.parts)
        elif path.is_file():
            yield path


class Stamp:
    """A file that records what a result was made from. The result is fresh while this has not changed."""

    def __init__(self, file: Path, content: str) -> None:
        self._file = file
        self._content = content

    def is_fresh(self) -> bool:
        return self._file.is_file() and self._file.read_text(encoding="utf-8") == self._content

    def forget(self) -> None:
        self._file.unlink(missing_ok=True)

    def write(self) -> None:
        self._file.parent.mkdir(parents=True, exist_ok=True)
        self._file.write_text(self._content, encoding="utf-8")

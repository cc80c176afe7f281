# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts one bake, or one join, of Sinew in Blender: what every engine runs on its machines.

This file uses the standard library alone, so that an engine can carry the file to a machine and run it there:
``python atom.py [--openjd] --blender "COMMAND LINE" bake|join WORDS...``
"""

import argparse
import json
import os
import re
import shlex
import subprocess
import sys
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache

DONE, WORDS, REFUSED, SPACE, MISSING = 0, 2, 3, 4, 5
FINAL = (WORDS, REFUSED, MISSING)  # another try would end in the same way
CRASHED = 1  # how an engine ends after a bake that crashed in every try
MARK = '{"sinew":'  # how a line of progress begins
WHERE_THE_ADDON_IS = "import importlib.util as u; print('sinew is in', u.find_spec('sinew').origin)"


@dataclass(frozen=True)
class End:
    """How a bake or a join ended: its exit code, and a sentence about it unless that is 0."""

    code: int
    message: str = ""


def frames_of(text: str) -> range:
    """The frames that a user names as ``7``, ``1-24`` or ``1-24x2``.

    Raises ValueError for any other text, and where the last frame is before the first one.
    """
    found = re.fullmatch(r"(-?\d+)(?:-(-?\d+)(?:x([1-9]\d*))?)?", text.strip())
    if found is None:
        raise ValueError(f'"{text}" names no frames: write 7, 1-24 or 1-24x2')
    first = int(found[1])
    frames = range(first, int(found[2] or first) + 1, int(found[3] or 1))
    if not frames:
        raise ValueError(f'"{text}" names no frames: the last one is before the first one')
    return frames


def chunks_of(frames: range, size: int) -> list[str]:
    """The frames in runs of ``size``, the last one shorter, each written as ``frames_of`` reads it."""
    runs = [frames[start : start + size] for start in range(0, len(frames), size)]
    step = f"x{frames.step}" if frames.step > 1 else ""
    return [f"{run[0]}-{run[-1]}{step}" if len(run) > 1 else f"{run[0]}" for run in runs]


def command(blender: str, name: str, words: Sequence[str]) -> list[str]:
    """The command line of ``bake`` or ``join`` in a Blender of any release.

    ``blender`` is a command line: that of a Blender with Sinew, or one that ends with the ``farm/command.py``
    of the add-on. Raises OSError where there is no such program.
    """
    program = shlex.split(blender, posix=os.name != "nt") or [""]
    if program[-1].endswith("command.py"):
        return [*program, name, *words]
    script = _script_of(tuple(program))
    if script:
        return [*program, "--background", "--python", script, "--", name, *words]
    return [*program, "--command", f"sinew_{name}", *words]


@cache
def _script_of(program: tuple[str, ...]) -> str:
    """The script of the add-on for a Blender before 4.2; nothing for later ones, which know commands."""
    release = re.search(r"Blender (\d+)\.(\d+)", _said([*program, "--version"]))
    if release is None or (int(release[1]), int(release[2])) >= (4, 2):
        return ""
    found = re.search(
        r"sinew is in (.*)", _said([*program, "--background", "--python-expr", WHERE_THE_ADDON_IS])
    )
    return os.path.join(os.path.dirname(found[1].strip()), "farm", "command.py") if found else ""


def _said(words: list[str]) -> str:
    return subprocess.run(words, capture_output=True, text=True, errors="replace").stdout


def run(
    blender: str, name: str, words: Sequence[str], tell: Callable[[dict], None] = lambda event: None
) -> End:
    """Starts ``bake`` or ``join`` in Blender and waits for its end.

    ``tell`` gets each line of progress as a dictionary. Where this process is killed, that of Blender ends
    with its next line, since nobody reads it.
    """
    try:
        process = subprocess.Popen(
            command(blender, name, words),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
        )
    except OSError as error:
        return End(REFUSED, f"{blender}: {error.strerror}")
    others: deque[str] = deque(maxlen=12)
    message, told = "", False
    with process:
        assert process.stdout is not None
        for line in process.stdout:
            event = event_of(line)
            if event is None:
                others.append(line.rstrip())
                continue
            told = True
            if event["sinew"] == "error":
                message = str(event.get("message", ""))
            tell(event)
    code = process.returncode
    if not told and 0 < code < 128 and code != WORDS:
        return End(REFUSED, _sentence(f"{blender} does not know Sinew: enable the add-on in it", others))
    if code in (DONE, WORDS, REFUSED, SPACE, MISSING):
        return End(code, message or ("" if code == DONE else _sentence("", others)))
    return End(CRASHED, message or _sentence(f"Blender ended with status {code}", others))


def event_of(line: str) -> dict | None:
    """What a line of progress says; None for any other line, and for a line that was cut."""
    if not line.startswith(MARK):
        return None
    try:
        return json.loads(line)
    except ValueError:
        return None


def _sentence(begin: str, lines: deque[str]) -> str:
    last = " | ".join(line for line in list(lines)[-3:] if line)
    return ": ".join(filter(None, (begin, last)))


def main() -> None:
    parser = argparse.ArgumentParser(prog="atom.py", description=__doc__)
    parser.add_argument("--openjd", action="store_true", help="also tell the progress as OpenJD reads it")
    parser.add_argument("--blender", default="blender")
    parser.add_argument("name", choices=("bake", "join"))
    parser.add_argument("words", nargs=argparse.REMAINDER)
    asked = parser.parse_args()
    frames = next((frames_of(asked.words[i + 1]) for i, word in enumerate(asked.words) if word == "--frames"))
    baked = 0

    def tell(event: dict) -> None:
        nonlocal baked
        print(json.dumps(event), flush=True)
        if asked.openjd and event["sinew"] == "frame":
            baked += 1
            print(f"openjd_progress: {min(100.0, 100.0 * baked / len(frames)):.1f}", flush=True)

    end = run(asked.blender, asked.name, asked.words, tell)
    if end.message:
        print(f"openjd_fail: {end.message}" if asked.openjd else end.message, flush=True)
    sys.exit(end.code)


if __name__ == "__main__":
    main()

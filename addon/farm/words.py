# SPDX-License-Identifier: GPL-3.0-or-later
"""The words of the two commands, as argparse understands them."""

import argparse
import math
import re
from collections.abc import Sequence
from typing import NoReturn

from ..properties import MAX_FRAME

FORMATS = ("pc2", "mdd", "alembic", "shape_keys")
_FRAMES = re.compile(r"(-?\d+)(?:-(-?\d+)(?:x(\d+))?)?")
_LONGEST = 7  # digits of a frame


class WordsError(Exception):
    """The words are not understood. The message has the usage."""


class _Parser(argparse.ArgumentParser):
    def error(self, message: str) -> NoReturn:
        raise WordsError(f"{message} - {' '.join(self.format_usage().split())}")


def parse(action: str, words: Sequence[str]) -> argparse.Namespace:
    """The words of ``bake`` or ``join``. Raises ``WordsError``, and ``SystemExit`` for ``--help``."""
    parser = _Parser(prog=f"sinew_{action}", allow_abbrev=False)
    shared = {
        "--frames": {
            "required": True,
            "type": _frames,
            "help": "1-24, 1-24x2 for every second, 7, or a list",
        },
        "--objects": {"required": True, "action": "append", "help": "names with commas between, repeatable"},
        "--format": {"default": "pc2", "choices": FORMATS},
        "--out": {"required": True, "help": "the folder; for a join of one object also its file"},
    }
    if action == "bake":
        parser.add_argument("shot", help="the .blend file")
        shared["--chunk"] = {"type": _count, "help": "frames per chunk; all of --frames if it is not given"}
        shared["--wedge"] = {"action": "append", "default": [], "type": _wedge, "help": "PATH=VALUE,VALUE..."}
        shared["--threads"] = {"type": _count, "default": 0, "help": "at most so many; else all"}
        shared["--memory"] = {"type": _gigabytes, "default": 0.0, "help": "GB that the process may take"}
    elif action == "join":
        parser.add_argument("folder", help="the --out of the bakes")
        shared["--mixed"] = {"action": "store_true", "help": "join chunks of different origin, too"}
        shared["--shot"] = {"default": "", "help": "the .blend file, if it was moved since the bake"}
    else:
        raise WordsError(f"{action or 'No word'} is no command - the commands are bake and join")
    for name, how in shared.items():
        parser.add_argument(name, **how)
    found = parser.parse_args(list(words))
    names = [name for text in found.objects for name in text.split(",") if name]
    found.objects = list(dict.fromkeys(names))
    if not found.objects:
        parser.error("--objects names no object")
    if action == "join" and len(found.frames) > 1:
        parser.error("one file holds one range of frames")
    return found


def _frames(text: str) -> list[range]:
    """The ranges in a text like ``8,1-24x2``, in its order. Raises an error for what is no range."""
    ranges = []
    for part in text.split(","):
        match = _FRAMES.fullmatch(part)
        if match is None or any(len(number or "") > _LONGEST for number in match.groups()):
            raise argparse.ArgumentTypeError(f"{part!r} is no frame and no range such as 1-24 or 1-24x2")
        first = int(match[1])
        found = range(first, int(match[2] or first) + 1, int(match[3] or 1) or 1)
        is_step = match[3] is None or int(match[3]) > 0
        if not is_step or not len(found) or max(abs(first), abs(found[-1])) > MAX_FRAME:
            raise argparse.ArgumentTypeError(f"{part!r} holds no frame, or frames that Blender does not have")
        ranges.append(found)
    return ranges


def _wedge(text: str) -> tuple[str, list[str]]:
    """The path of a property and its values, from ``path=value,value``."""
    path, _sign, values = text.rpartition("=")
    found = list(dict.fromkeys(value.strip() for value in values.split(",")))
    if not path or not all(found):
        raise argparse.ArgumentTypeError(f"{text!r} is no PATH=VALUE,VALUE...")
    return path.strip(), found


def _count(text: str) -> int:
    number = int(text)
    if not 1 <= number <= MAX_FRAME:
        raise argparse.ArgumentTypeError(f"{text} is no count from 1 on")
    return number


def _gigabytes(text: str) -> float:
    number = float(text)
    if not (number > 0.0 and math.isfinite(number)):
        raise argparse.ArgumentTypeError(f"{text} is no number of gigabytes")
    return number

# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts a Blender with a window for a session, and reads what it noted."""

import json
import os
import shutil
import subprocess
from collections.abc import Sequence
from pathlib import Path

import pytest

HERE = Path(__file__).parent


def blender(script: str, *arguments: object, options: Sequence[str] = ()) -> list[str]:
    """The command that runs a script of this folder, with the modules beside it and those of ``blender/``."""
    command = ["blender", "--factory-startup", "--python-exit-code", "1", *options]
    if "PYTHONPATH" in os.environ:
        command.append("--python-use-system-env")
    modules = [str(HERE), str(HERE.parent / "blender" / "support")]
    command += ["--python-expr", f"import sys; sys.path[:0] = {modules}", "--python", str(HERE / script)]
    return [*command, "--", *map(str, arguments)]


def drive(script: str, output: Path, timeout: float, size: tuple[int, int]) -> dict:
    """What the script noted in ``seen.json``, with all that Blender printed as ``said``.

    All goes to ``output``, or, where SINEW_TEST_OUTPUT is set, to a folder in that, which is emptied first.
    """
    if "DISPLAY" not in os.environ:
        pytest.skip("no display: start it under xvfb-run")
    if "SINEW_TEST_OUTPUT" in os.environ:
        output = Path(os.environ["SINEW_TEST_OUTPUT"]) / Path(script).stem
        shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True, exist_ok=True)
    window = ["--enable-event-simulate", "-noaudio", "--window-geometry", "0", "0", *map(str, size)]
    command = blender(script, output, options=window)
    ended = subprocess.run(command, timeout=timeout, capture_output=True, text=True, check=False)
    said = ended.stdout + ended.stderr
    answer = output / "seen.json"
    stack = "".join(file.read_text(encoding="utf-8") for file in output.rglob("*.crash.txt"))
    assert answer.is_file(), f"Blender crashed ({ended.returncode}): {said[-2000:]}{stack}"
    assert "Traceback" not in said, said[-3000:]
    return {**json.loads(answer.read_text(encoding="utf-8")), "said": said}

# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs that run in a second Blender of the same version, with or without the add-on."""

import ctypes
import json
import os
import subprocess
import sys
import textwrap
import threading
from pathlib import Path

import bpy
import numpy as np

_HERE = Path(__file__).parent

_PROGRAM = """
import json, os, sys, traceback
sys.path.insert(0, {here!r})
{prelude}
import bpy, addon_utils
import numpy as np
from rigs.rig import Rig, base_points, evaluated_points, make_active, move_world, update
seen = {{}}
def run():
    if {addon!r}:
        addon_utils.enable({addon!r}, default_set=True)
{script}
try:
    run()
finally:
    seen["error"] = traceback.format_exc() if sys.exc_info()[0] else ""
    open({answer!r}, "w", encoding="utf-8").write(json.dumps(seen))
    sys.stdout.flush()
    os._exit(0)
"""

# For each line, a path and a name, it writes into a file what the viewport shows of the object, what a render
# does, and the viewport once more. It ends with the process that started it.
_LOOKS = """
import json, os, sys
sys.path.insert(0, {here!r})
{prelude}
import bpy, addon_utils
import probe
from rigs.rig import evaluated_points
if {addon!r}:
    addon_utils.enable({addon!r}, default_set=True)
for line in sys.stdin:
    path, name, answer = json.loads(line)
    bpy.ops.wm.open_mainfile(filepath=path)
    obj = bpy.data.objects[name]
    seen = [evaluated_points(obj).tolist(), probe.render()[-1][name].tolist(), evaluated_points(obj).tolist()]
    with open(answer, "w", encoding="utf-8") as file:
        json.dump(seen, file)
    print({done!r}, flush=True)
sys.stdout.flush()
os._exit(0)
"""
_DONE = "looked at it"
_lookers: dict[tuple[str, str], subprocess.Popen] = {}


def another_blender(script: str, folder: Path, addon_name: str = "", prelude: str = "") -> dict:
    """Run ``script`` after ``prelude`` in a new Blender, with the add-on or without; what it has ``seen``."""
    program, answer = folder / "script.py", folder / "seen.json"
    body = textwrap.indent(textwrap.dedent(script), "    ")
    program.write_text(
        _PROGRAM.format(here=str(_HERE), prelude=prelude, addon=addon_name, script=body, answer=str(answer)),
        encoding="utf-8",
    )
    said = run_blender([], program)
    found = json.loads(answer.read_text(encoding="utf-8"))
    assert not found["error"], found["error"]
    assert "Traceback" not in said, said
    return found


def look_elsewhere(
    path: str, name: str, folder: Path, addon_name: str = "", prelude: str = ""
) -> list[np.ndarray]:
    """What another Blender shows of an object in the viewport and in a render, with or without the add-on.

    One Blender of each kind opens one file after the other: starting it takes longer than all that it does.
    """
    looker = _lookers.get((addon_name, prelude)) or _looker(folder, addon_name, prelude)
    answer = folder / "looked.json"
    answer.unlink(missing_ok=True)
    late = threading.Timer(120.0, looker.kill)
    late.start()
    print(json.dumps([path, name, str(answer)]), file=looker.stdin, flush=True)
    said: list[str] = []
    for line in looker.stdout:
        said.append(line)
        if line.strip() == _DONE:
            break
    late.cancel()
    if not answer.is_file():
        del _lookers[addon_name, prelude]
    assert answer.is_file(), "".join(said)
    assert "Traceback" not in "".join(said), "".join(said)
    before, rendered, after = map(np.array, json.loads(answer.read_text(encoding="utf-8")))
    assert np.array_equal(before, after)
    return [before, rendered]


def _looker(folder: Path, addon_name: str, prelude: str) -> subprocess.Popen:
    program = folder / "looks.py"
    text = _LOOKS.format(here=str(_HERE), prelude=prelude, addon=addon_name, done=_DONE)
    program.write_text(text, encoding="utf-8")
    pipes = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "stderr": subprocess.STDOUT}
    _lookers[addon_name, prelude] = subprocess.Popen(_command([], program), text=True, **pipes)
    return _lookers[addon_name, prelude]


def run_blender(arguments: list[str], program: Path, timeout: float = 120.0) -> str:
    """A Python file in a new background process of this Blender; what it printed."""
    command = _command(arguments, program)
    ended = subprocess.run(command, timeout=timeout, capture_output=True, text=True, check=False)
    return ended.stdout + ended.stderr


def _command(arguments: list[str], program: Path) -> list[str]:
    if not is_executable():
        return [sys.executable, str(program), *arguments]
    command = [bpy.app.binary_path, "-b", "--factory-startup", *arguments]
    command += ["--python-use-system-env"] if "PYTHONPATH" in os.environ else []
    return [*command, "-P", str(program)]


def is_executable() -> bool:
    return Path(bpy.app.binary_path).name.lower().startswith("blender")


def is_wine() -> bool:
    """Wine runs this Blender for Windows."""
    return os.name == "nt" and hasattr(ctypes.windll.ntdll, "wine_get_version")


_SET_UP = """
import sys
sys.path.insert(0, {here!r})
import addon_utils, bpy
addon_utils.enable({addon!r}, default_set=True)
import probe
bpy.context.scene.render.engine = probe.Probe.bl_idname
"""

_TELL = """
import json, probe
names = [shapes[{name!r}].tolist() for shapes in probe.Probe.seen]
open({answer!r}, "w", encoding="utf-8").write(json.dumps([probe.Probe.frames, names]))
"""


def by_command_line(path: str, folder: Path, addon_name: str, name: str) -> tuple[list[int], list]:
    """``blender -b FILE -P set_up -f 11 -a -P tell``: frames, and the points of the object at each."""
    answer = folder / "answer.json"
    set_up, tell = folder / "set_up.py", folder / "tell.py"
    set_up.write_text(_SET_UP.format(here=str(Path(__file__).parent), addon=addon_name), encoding="utf-8")
    tell.write_text(_TELL.format(name=name, answer=str(answer)), encoding="utf-8")
    said = run_blender([path, "-P", str(set_up), "-f", "11", "-a"], tell)
    assert "Traceback" not in said, said
    frames, shapes = json.loads(answer.read_text(encoding="utf-8"))
    return frames, [np.array(shape) for shape in shapes]

# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sessions claim, which drive a Blender by mouse and keys in a real window. Needs a display."""

import ast
import json
import os
import shutil
import subprocess
from collections.abc import Callable, Sequence
from pathlib import Path

import pytest

HERE = Path(__file__).parent
TIMEOUT = 600.0  # seconds for a session: several times as many as on a quiet machine
LARGE, SMALL = (1280, 800), (800, 500)
SESSIONS = {"start": LARGE, "handles": LARGE, "shapes": LARGE, "tools": LARGE, "threads": SMALL}
FLOAT32 = 4e-6

Seen = Callable[[str], dict]


def claims(session: str) -> list[str]:
    """The texts of ``with claim("..."):`` in a session."""
    module = ast.parse((HERE / f"session_{session}.py").read_text(encoding="utf-8"))
    calls = [node for node in ast.walk(module) if isinstance(node, ast.Call)]
    made = [call for call in calls if getattr(call.func, "id", "") == "claim"]
    return [ast.literal_eval(call.args[0]) for call in sorted(made, key=lambda call: call.lineno)]


CLAIMS = [(session, text) for session in SESSIONS for text in claims(session)]


def blender(script: str, *arguments: object, options: Sequence[str] = ()) -> list[str]:
    """The command that runs a script of this folder, with the modules beside it and those of ``blender/``."""
    command = ["blender", "--factory-startup", "--python-exit-code", "1", *options]
    if "PYTHONPATH" in os.environ:
        command.append("--python-use-system-env")
    modules = [str(HERE), str(HERE.parent / "blender" / "support")]
    command += ["--python-expr", f"import sys; sys.path[:0] = {modules}", "--python", str(HERE / script)]
    return [*command, "--", *map(str, arguments)]


def drive(session: str, output: Path) -> dict:
    """What the session noted in ``seen.json``, with all that Blender printed as ``said``.

    All goes to ``output``, or, where SINEW_TEST_OUTPUT is set, to a folder in that, which is emptied first.
    """
    if "DISPLAY" not in os.environ:
        pytest.skip("no display: start it under xvfb-run")
    script = f"session_{session}.py"
    if "SINEW_TEST_OUTPUT" in os.environ:
        output = Path(os.environ["SINEW_TEST_OUTPUT"]) / Path(script).stem
        shutil.rmtree(output, ignore_errors=True)
    output.mkdir(parents=True, exist_ok=True)
    size = map(str, SESSIONS[session])
    options = ["--enable-event-simulate", "-noaudio", "--window-geometry", "0", "0", *size]
    command = blender(script, output, options=options)
    ended = subprocess.run(command, timeout=TIMEOUT, capture_output=True, text=True, check=False)
    said = ended.stdout + ended.stderr
    answer = output / "seen.json"
    stack = "".join(file.read_text(encoding="utf-8") for file in output.rglob("*.crash.txt"))
    assert answer.is_file(), f"Blender crashed ({ended.returncode}): {said[-2000:]}{stack}"
    return {**json.loads(answer.read_text(encoding="utf-8")), "said": said}


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> Seen:
    """What a session noted. It runs when the first of its claims is asked for."""
    found: dict[str, dict] = {}

    def of(session: str) -> dict:
        if session not in found:
            found[session] = {"error": "the session ended before its time", "claims": {}, "said": ""}
            found[session] = drive(session, tmp_path_factory.mktemp(session))
        return found[session]

    return of


@pytest.mark.parametrize(("session", "claim"), CLAIMS)
def test_in_a_window(seen: Seen, session: str, claim: str):
    found = seen(session)
    outcomes = found["claims"].get(claim)
    assert outcomes, found.get("error", "the session did not come to this claim")
    assert not any(outcomes), "\n".join(outcomes)


@pytest.mark.parametrize("session", SESSIONS)
def test_a_session_comes_to_its_end_without_a_complaint(seen: Seen, session: str):
    assert "error" not in seen(session), seen(session)["error"]
    for complaint in ("Traceback", "Dependency cycle"):
        assert complaint not in seen(session)["said"], seen(session)["said"][-3000:]


def test_blenders_own_autosave_opens_with_the_pose_and_lives_on(seen: Seen, tmp_path: Path):
    """In another Blender, as after a crash."""
    autosave, answer = seen("threads").get("autosave"), tmp_path / "seen.json"
    assert autosave, seen("threads").get("error")
    command = blender("recover.py", autosave, answer, options=["-b"])
    ended = subprocess.run(command, timeout=60, capture_output=True, text=True, check=False)
    said = ended.stdout + ended.stderr
    assert "Traceback" not in said, said[-3000:]
    found = json.loads(answer.read_text(encoding="utf-8"))
    assert found["height"] == pytest.approx(seen("threads")["autosave_height"], abs=1e-6)
    assert found["error"] < FLOAT32
    assert found["later_error"] < FLOAT32

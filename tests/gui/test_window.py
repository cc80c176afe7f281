# SPDX-License-Identifier: GPL-3.0-or-later
"""What the sessions claim, which drive a Blender by mouse and keys in a real window. Needs a display."""

import ast
import json
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest
from blender_window import HERE, blender, drive

LARGE, SMALL = (1280, 800), (800, 500)
SESSIONS = {  # the size of the window, and seconds: several times as many as on a quiet machine
    "start": (LARGE, 600.0),
    "handles": (LARGE, 600.0),
    "shapes": (LARGE, 600.0),
    "tools": (LARGE, 600.0),
    "threads": (SMALL, 600.0),
}
FLOAT32 = 4e-6

Seen = Callable[[str], dict]


def claims(session: str) -> Iterator[str]:
    """The texts of ``with claim("..."):`` in a session."""
    module = ast.parse((HERE / f"session_{session}.py").read_text(encoding="utf-8"))
    for node in ast.walk(module):
        if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "claim":
            yield ast.literal_eval(node.args[0])


CLAIMS = [(session, text) for session in SESSIONS for text in claims(session)]


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> Seen:
    """What a session noted. It runs when the first of its claims is asked for."""
    found: dict[str, dict] = {}

    def of(session: str) -> dict:
        if session not in found:
            size, timeout = SESSIONS[session]
            found[session] = {"error": "the session ended before its time", "claims": {}, "said": ""}
            found[session] = drive(f"session_{session}.py", tmp_path_factory.mktemp(session), timeout, size)
        return found[session]

    return of


@pytest.mark.parametrize(("session", "claim"), CLAIMS)
def test_in_a_window(seen: Seen, session: str, claim: str):
    found = seen(session)
    outcomes = found["claims"].get(claim)
    assert outcomes, found.get("error", "the session did not come to this claim")
    assert not any(outcomes), "\n".join(outcomes)


@pytest.mark.parametrize("session", SESSIONS)
def test_a_session_comes_to_its_end(seen: Seen, session: str):
    assert "error" not in seen(session), seen(session)["error"]
    assert "Dependency cycle" not in seen(session)["said"]


def test_a_render_that_nothing_was_bound_for_says_so_in_the_terminal(seen: Seen):
    assert "Warning: Thin Shell: In the render: Topology changed - Rebind" in seen("start")["said"]


def test_blenders_own_autosave_opens_with_the_pose_and_lives_on(seen: Seen, tmp_path: Path):
    """In another Blender, as after a crash."""
    autosave, answer = seen("threads")["autosave"], tmp_path / "seen.json"
    assert autosave
    command = blender("recover.py", autosave, answer, options=["-b"])
    ended = subprocess.run(command, timeout=60, capture_output=True, text=True, check=False)
    said = ended.stdout + ended.stderr
    assert "Traceback" not in said, said[-3000:]
    found = json.loads(answer.read_text(encoding="utf-8"))
    assert found["height"] == pytest.approx(seen("threads")["autosave_height"], abs=1e-6)
    assert found["error"] < FLOAT32
    assert found["later_error"] < FLOAT32

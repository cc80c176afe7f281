# SPDX-License-Identifier: GPL-3.0-or-later
"""Programs that tests run in a process of their own: a crash there is a failure here."""

import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]


def output_of(program: str, *arguments: str, timeout: float | None = 120) -> str:
    """What Python says, in the root of the checkout."""
    command = [sys.executable, "-c", program, *arguments]
    done = subprocess.run(command, capture_output=True, text=True, timeout=timeout, check=False, cwd=ROOT)
    assert done.returncode == 0, f"ended with {done.returncode}: {done.stdout}{done.stderr[-2000:]}"
    return done.stdout

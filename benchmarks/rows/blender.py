# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs scripts in Debian's Blender and in the newest one; the frames and binds that scripts/blender_frame.py
measures there.
"""

import contextlib
import io
import json
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from record import Row
from workshop import blenders, debian, environments, shell

SCRIPTS = Path(__file__).resolve().parents[1] / "scripts"
BLENDERS = ("3.4", "5.2")
LONGEST = 900.0  # seconds, for one script


@contextmanager
def output_of(version: str, script: str, *words: object) -> Iterator[Path]:
    """Run a script in a Blender that has the add-on; the file that it writes, which is its last argument."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "out"
        with contextlib.redirect_stdout(io.StringIO()):
            command, env = _installed(version, SCRIPTS / script)
        status = shell.run([*command, *words, out], env=env, timeout=LONGEST, quiet=True)
        if not out.is_file():
            raise SystemExit(f"{script} in Blender {version} wrote nothing (status {status})")
        yield out


def _installed(version: str, script: Path) -> tuple[list[object], dict[str, object]]:
    """The command that runs a script in this Blender, and an environment with the installed add-on."""
    name = f"benchmarks-{version}"
    if version == "3.4":
        debian.install(debian.BLENDER)
        return [*blenders.HEADLESS, script, "--"], blenders.install_legacy(name)
    newest = environments.newest_blender().make()
    return [newest.python, script, "--"], blenders.install_extension(newest, name)


def frames(size: int, _threads: Sequence[int]) -> list[Row]:
    rows = []
    for version in BLENDERS:
        small = ["--small"] if size < 100_000 else []
        with output_of(version, "blender_frame.py", *small) as out:
            rows += [{**row, "case": version} for row in json.loads(out.read_text(encoding="utf-8"))]
    return rows

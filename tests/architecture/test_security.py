# SPDX-License-Identifier: GPL-3.0-or-later
from pathlib import Path

import pytest

from .security import ALLOWED, security_offences
from .tree import ROOT, grow


def test_nothing_is_allowed_that_is_not_there() -> None:
    for name, what in ALLOWED:
        assert what in (ROOT / "addon" / name).read_text(encoding="utf-8"), name


@pytest.mark.parametrize(
    "line",
    [
        "import pickle",
        "import os.path, subprocess",
        "from urllib.request import urlopen",
        "eval(text)",
        "run = exec",
        "__import__(name)",
        "os.system(text)",
        "bpy.ops.script.python_file_run(filepath=path)",
        "importlib.import_module(name)",
        "np.load(path)",
        "driver.expression = text",
        "bpy.app.driver_namespace['f'] = f",
        "json.loads(text)",
        "file = open(path)",
        "path.unlink()",
    ],
)
def test_code_from_data_is_found(tmp_path: Path, line: str) -> None:
    (offence,) = security_offences(grow(tmp_path, {"addon/a.py": f"x = 1\n{line}\n"}))
    assert offence.startswith("addon/a.py:2:")


@pytest.mark.parametrize(
    "line",
    ["import os", "evaluate(x)", "from . import pickle_like", "a.executes()", "bpy.ops.object.delete()"],
)
def test_innocent_lines_are_left_alone(tmp_path: Path, line: str) -> None:
    assert security_offences(grow(tmp_path, {"addon/a.py": line, "addon/bake/b.py": "open(path)"})) == []

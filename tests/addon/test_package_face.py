# SPDX-License-Identifier: GPL-3.0-or-later
"""What Blender reads before it runs the add-on: one version everywhere, a manifest by the rules."""

import ast
import tomllib
from pathlib import Path

from sinew import ids

ADDON = Path(__file__).parents[2] / "addon"
MANIFEST = tomllib.loads((ADDON / "blender_manifest.toml").read_text(encoding="utf-8"))


def test_manifest_and_legacy_face():
    source = ast.parse((ADDON / "__init__.py").read_text(encoding="utf-8")).body
    (info,) = (row.value for row in source if isinstance(row, ast.Assign) and row.targets[0].id == "bl_info")
    assert ast.literal_eval(info)["blender"] == (3, 4, 0)
    assert MANIFEST["id"] == "sinew"
    assert MANIFEST["schema_version"] == "1.0.0"
    assert len(MANIFEST["tagline"]) <= 64
    assert not MANIFEST["tagline"].endswith(".")
    assert MANIFEST["license"] == ["SPDX:GPL-3.0-or-later"]
    assert MANIFEST["wheels"] == []


def test_operator_names_follow_one_pattern():
    names = [value for key, value in vars(ids.Operators).items() if key.isupper()]
    assert all(name.startswith("sinew.") for name in names)
    assert len(set(names)) == len(names)


def test_methods_are_named_in_the_registry_only():
    """Menus, properties and sessions come from rows: a method's id stands in its row and tables of core."""
    from sinew.core.methods import METHODS

    tables = [ADDON / "core" / f"{name}.py" for name in ("rigs", "tasks", "templates")]
    for path in ADDON.rglob("*.py"):
        if path.parent.name == "methods" or path in tables or "_native" in path.parts:
            continue
        text = path.read_text(encoding="utf-8")
        for method in METHODS:
            assert f'"{method.id}"' not in text, f"{path} names {method.id}"
            assert f'"{method.native}"' not in text, f"{path} names {method.native}"

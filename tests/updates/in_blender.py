# SPDX-License-Identifier: GPL-3.0-or-later
"""What an artist does in one Blender with nothing but the address of a repository: ``install|reopen ADDRESS
FOLDER`` writes what is seen to the folder, and asks for ``ADDRESS/publish`` when an update is due."""

import importlib
import json
import os
import sys
import urllib.request
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).parents[1] / "blender" / "support"))
from rigs.rig import Rig, evaluated_points, load, save

# isort: split
import addon_utils  # comes with bpy, not before it

step, address, folder = sys.argv[1], sys.argv[2], Path(sys.argv[3])
seen: dict[str, object] = {}


def repository() -> bpy.types.UserExtensionRepo:
    repositories = bpy.context.preferences.extensions.repos
    return next(each for each in repositories if each.remote_url.startswith(address))


def fetch() -> str:
    """Installs the version that Blender lists now, over an older one if there is one."""
    folder = repository().directory
    bpy.ops.extensions.repo_sync(repo_directory=folder)
    index = json.loads(Path(folder, ".blender_ext", "index.json").read_text(encoding="utf-8"))
    bpy.ops.extensions.package_install(repo_directory=folder, pkg_id="sinew", enable_on_install=True)
    return next(row["version"] for row in index["data"] if row["id"] == "sinew")


def module_name() -> str:
    return f"bl_ext.{repository().module}.sinew"


def preferences() -> bpy.types.AddonPreferences:
    return bpy.context.preferences.addons[module_name()].preferences


def look() -> dict[str, object]:
    """What there is of Sinew, what it tells, and what it shows of the plate."""
    rig = Rig.called("Plate")
    native = importlib.import_module(f"{module_name()}.backend").availability()
    presets = Path(bpy.utils.user_resource("SCRIPTS", path="presets/sinew/thin_shell"))
    sheets = importlib.import_module("rigs.sheet")
    return {
        "version": importlib.import_module(f"{module_name()}.ids").VERSION,
        "native": native.module and native.module.__version__,
        "points": evaluated_points(rig.obj).tolist(),
        "handles": [handle.name for handle in rig.deformer.handles],
        "budget": preferences().drag_budget,
        "presets": sorted(path.name for path in presets.glob("*.py")),
        "page": sheets.draw_page(module_name()).texts(),
        "panel": sheets.draw_panel().texts(),
    }


def add_repository() -> None:
    bpy.context.preferences.system.use_online_access = True
    bpy.ops.preferences.extension_repo_add(
        name="Sinew", remote_url=f"{address}/stable/index.json", type="REMOTE"
    )


def install() -> None:
    add_repository()
    seen["listed"] = [fetch()]
    preferences().drag_budget = 123.0
    rig = Rig.plate().bind("thin_shell")
    bpy.ops.sinew.preset_add(name="Mine")
    rig.lift(0.5)
    seen["installed"] = look()
    save(folder / "rig.blend")
    urllib.request.urlopen(f"{address}/publish").close()
    seen["listed"].append(fetch())
    seen["updated"] = look()
    rig.lift(0.25)
    seen["lifted"] = look()
    save(folder / "lifted.blend")
    bpy.ops.wm.save_userpref()
    stored = Path(bpy.utils.user_resource("CONFIG"), "userpref.blend").read_bytes()
    seen["stored"] = [word for word in (module_name(), "drag_budget") if word.encode() in stored]


def reopen() -> None:
    add_repository()  # a Blender that is a Python module starts without the preferences that it saved
    addon_utils.enable(module_name(), default_set=True)
    for name in ("rig.blend", "lifted.blend"):
        load(folder / name)
        seen[name] = look()


{"install": install, "reopen": reopen}[step]()
(folder / f"{step}.json").write_text(json.dumps(seen), encoding="utf-8")
sys.stdout.flush()
os._exit(0)  # Blender as a module may hang or crash while it ends

# SPDX-License-Identifier: GPL-3.0-or-later
"""The installation: the button that checks it, the script that does, and what is wrong with a broken one."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from types import ModuleType

import bpy
import numpy as np
import pytest
from inside import native
from registry import METHODS
from rigs.kinds import HandleRig
from rigs.rig import close, refused, save
from rigs.sheet import Sheet, draw_page
from second_blender import another_blender, is_executable

SELF_CHECK = Path(__file__).parents[3] / "tools" / "self_check"
SUPPORT = Path(__file__).parents[1] / "support"
ODD = "Übung – 日本 a b"  # as the folder of a user may be called


def blocks() -> dict[str, int]:
    """How many datablocks there are of each type."""
    names = [p.identifier for p in bpy.data.bl_rna.properties if p.type == "COLLECTION"]
    return {name: len(getattr(bpy.data, name)) for name in names}


def icon_of(sheet: Sheet, words: str) -> str:
    """The icon before a line."""
    lines = [keywords for name, _args, keywords, _settings in sheet.calls if name == "label"]
    return next(keywords["icon"] for keywords in lines if words in keywords["text"])


@pytest.fixture
def reports(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The folder that the reports of this test go to."""
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    return tmp_path


def test_the_button_writes_a_report_and_leaves_the_file_alone(
    posed_plate: HandleRig, addon_name: str, reports: Path
):
    before, shown = blocks(), posed_plate.points()
    assert bpy.ops.sinew.check_installation() == {"FINISHED"}
    assert blocks() == before
    assert np.array_equal(posed_plate.points(), shown)
    (report,) = reports.glob("sinew-check-*.txt")
    text = report.read_text(encoding="utf-8")
    assert bpy.app.version_string in text
    for method in METHODS:
        assert f"\n{method.id}: " in text
    assert "known answers are right" in text
    assert "WRONG" not in text
    sheet = draw_page(addon_name)
    assert icon_of(sheet, "known answers are right") == "CHECKMARK"
    assert dict(sheet.operators())["wm.path_open"].filepath == str(report)


def test_wrong_answers_of_the_module_are_shown(
    addon_name: str, reports: Path, monkeypatch: pytest.MonkeyPatch
):
    right = native().SurfaceMethod.solve

    def wrong(self, *args: object, **options: object) -> tuple:
        shape, report = right(self, *args, **options)
        return 1.001 * shape, report

    monkeypatch.setattr(native().SurfaceMethod, "solve", wrong)
    refused("known answers are wrong", "check_installation")
    (report,) = reports.glob("sinew-check-*.txt")
    assert "WRONG" in report.read_text(encoding="utf-8")
    assert icon_of(draw_page(addon_name), "known answers are wrong") == "ERROR"


def test_no_place_for_the_report(reports: Path, monkeypatch: pytest.MonkeyPatch):
    with monkeypatch.context() as patch:
        patch.setattr(tempfile, "tempdir", str(reports / "nowhere"))
        refused("cannot be written", "check_installation")


@pytest.fixture
def copied(addon: ModuleType, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> tuple[Path, Path]:
    """The installed add-on and its native module, copied to a folder whose name has spaces and other letters.

    A second Blender finds them there.
    """
    here, home = Path(addon.__file__).parent, tmp_path / ODD
    for name in ("TMPDIR", "TEMP", "TMP"):
        monkeypatch.setenv(name, str(tmp_path))
    if (here / "_native").is_dir():
        root, copy = here, home / "scripts" / "addons" / "sinew"
        folders = {"SCRIPTS": home / "scripts", "CONFIG": home / "config"}
    else:  # Blender installs the module of an extension elsewhere in the folder of the user
        root, copy = Path(bpy.utils.resource_path("USER")), home
        folders = {"RESOURCES": home}
    for name, folder in folders.items():
        monkeypatch.setenv(f"BLENDER_USER_{name}", str(folder))
    cached = shutil.ignore_patterns("__pycache__")
    shutil.copytree(root, copy, ignore=cached, copy_function=shutil.copyfile)  # Wine 8 has not that of copy2
    return copy / here.relative_to(root), copy / Path(native().__file__).relative_to(root)


BROKEN = """
import ctypes, os, sys
from pathlib import Path
sys.path.insert(0, here)
from rigs.sheet import draw_page
module, addon_folder = Path(module), Path(addon_folder)
kept = module.with_name("kept")
READ, OPEN_EXISTING = 0x80000000, 3  # of CreateFile

def look(fault):
    assert addon_utils.enable(addon, default_set=True) is not None
    bpy.ops.wm.open_mainfile(filepath=file)
    obj = bpy.data.objects[target]
    bpy.context.scene.frame_set(7)
    said = {"points": evaluated_points(obj).tolist(), "page": draw_page(addon).texts()}
    said["status"] = obj.sinew.deformers[0].status
    try:
        bpy.ops.sinew.check_installation()
        said["check"] = "right"
    except RuntimeError as refusal:
        said["check"] = str(refusal)
    seen[fault] = said
    if fault == "none":
        return
    addon_utils.disable(addon)
    for loaded in [loaded for loaded in sys.modules if loaded.startswith(addon)]:
        del sys.modules[loaded]

addon_utils.enable(addon, default_set=True)  # Blender looks at the wheels of a new folder
addon_utils.disable(addon)
module.replace(kept)
legacy, wheels = addon_folder / "_native", addon_folder / "wheels"
for fitting in wheels.glob("*.whl"):
    fitting.rename(fitting.with_suffix(".kept"))
look("missing")
other = legacy / "sinew_native.cp399-win_amd64.pyd"
if not legacy.is_dir():
    other = wheels / "sinew_native-0-cp399-cp399-win_amd64.whl"
other.touch()
look("of another system")
other.unlink()
for fitting in wheels.glob("*.kept"):
    fitting.rename(fitting.with_suffix(".whl"))
module.write_bytes(bytes([127]) + b"ELF" + bytes(60))
look("damaged")
if os.name == "nt":
    python = f"python3{sys.version_info.minor}.dll"
    module.write_bytes(kept.read_bytes().replace(python.encode(), b"nowhere" + python[7:].encode()))
    look("without a DLL")
    module.replace(module.with_name("refused"))  # it stays open
kept.replace(module)
if os.name == "nt":  # as a virus scanner keeps it
    hold = ctypes.windll.kernel32.CreateFileW
    hold.restype = ctypes.c_void_p
    handle = hold(str(module), ctypes.c_uint32(READ), 0, None, OPEN_EXISTING, 0, None)
    look("blocked")
    ctypes.windll.kernel32.CloseHandle(ctypes.c_void_p(handle))
libraries = list(module.parent.glob("sinew_native.libs/*"))
if libraries:  # their folder stays, as the system remembers for the rest of a process that one is missing
    libraries[0].rename(libraries[0].with_name("elsewhere"))
    look("without its libraries")
    libraries[0].with_name("elsewhere").rename(libraries[0])
look("none")
"""


def test_a_broken_installation_says_what_to_do(
    posed_plate: HandleRig, copied: tuple[Path, Path], addon_name: str, tmp_path: Path
):
    """The add-on registers, files open and show the last solution, and the preferences name the remedy.

    In the end nothing is broken any more, and all is right in a folder with an odd name.
    """
    shown = posed_plate.points()
    save(tmp_path / "rig.blend")
    addon_folder, module = copied
    given = {"here": SUPPORT, "module": module, "addon_folder": addon_folder, "file": tmp_path / "rig.blend"}
    given |= {"addon": addon_name, "target": posed_plate.obj.name}
    lines = "\n".join(f"{name} = {str(value)!r}" for name, value in given.items())
    found = another_blender(f"{lines}\n{BROKEN}", tmp_path)
    words = {"missing": "is missing", "of another system": "the installed zip holds "}
    of_windows = {"without a DLL", "blocked"} if os.name == "nt" else set()  # developers have no libraries
    assert found.keys() >= {*words, "damaged", *of_windows}
    for fault in found.keys() - {"none", "error"}:
        said, word = found[fault], words.get(fault, "does not load")
        assert close(np.array(said["points"]), shown, posed_plate.tolerance), fault
        for text in (said["page"], said["status"]):
            assert word in text, fault
            assert f"cp{sys.version_info.major}{sys.version_info.minor}" in text
        assert "Nothing could be computed" in said["check"]
    assert "cp399" in found["of another system"]["page"]
    assert close(np.array(found["none"]["points"]), shown, posed_plate.tolerance)
    assert "is ready" in found["none"]["page"]
    assert found["none"]["check"] == "right"


def run_self_check(report: Path) -> subprocess.CompletedProcess:
    """``tools/self_check`` in a new Blender, by a user who may not write where files say so."""
    command = [str(SELF_CHECK)]
    if is_executable():
        python = ["--python-use-system-env"] if "PYTHONPATH" in os.environ else []
        command = [bpy.app.binary_path, "--background", *python, "--python", *command, "--"]
    else:
        command = [sys.executable, *command]
    if hasattr(os, "geteuid") and os.geteuid() == 0:
        command = ["setpriv", "--bounding-set=-dac_override", *command]
    return subprocess.run([*command, str(report)], capture_output=True, timeout=120.0, check=False)


def test_the_script_checks_a_read_only_installation(copied: tuple[Path, Path], tmp_path: Path):
    addon_folder, module = copied
    for path in (addon_folder, *addon_folder.rglob("*")):
        path.chmod(0o555 if path.is_dir() else 0o444)
    report = tmp_path / f"{ODD}.txt"
    try:
        ended = run_self_check(report)
        said = (ended.stdout + ended.stderr).decode("utf-8", "replace")
        assert ended.returncode == 0, said
        assert "Traceback" not in said
        text = report.read_text(encoding="utf-8")
        assert "known answers are right" in text
        assert module.name in text
    finally:
        for path in (addon_folder, *addon_folder.rglob("*")):
            path.chmod(0o755 if path.is_dir() else 0o644)


def test_the_script_reports_a_module_that_does_not_load(copied: tuple[Path, Path], tmp_path: Path):
    _addon_folder, module = copied
    module.write_bytes(b"\x7fELF" + bytes(60))
    report = tmp_path / "report.txt"
    ended = run_self_check(report)
    assert ended.returncode == 1, ended.stdout + ended.stderr
    text = report.read_text(encoding="utf-8")
    assert "does not load" in text
    assert "Nothing could be computed" in text

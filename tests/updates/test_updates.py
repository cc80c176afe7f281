# SPDX-License-Identifier: GPL-3.0-or-later
"""A Blender that has the address of what ``tools/release`` makes gets Sinew from there, and its next version
while a file with a rig is open."""

import json
import os
import re
import subprocess
import threading
from collections.abc import Iterator
from http.server import SimpleHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path

import numpy as np
import pytest
from workshop import environments, package, release, windows_tests
from workshop.archives import read_folder, read_zip, write_wheel, write_zip
from workshop.places import version

SYSTEM = os.environ.get("SINEW_SYSTEM", "linux")  # that of the Blenders
BLENDERS = (*environments.LONG_TERM_BLENDERS, environments.newest_blender().name.removeprefix("bpy-"))
if SYSTEM == "windows":
    BLENDERS = ("4.5.15", "5.2.3") if environments.python313() else ("4.5.15",)
BUDGET = 123.0  # as in_blender.py sets it in the preferences
PROGRAM = Path(__file__).with_name("in_blender.py")
NOW = version()
NEXT = f"{NOW[:-1]}{int(NOW[-1]) + 1}"  # as long as the version, which stands in the compiled module, too
TEXTS = (".py", ".toml", "METADATA", ".so", ".pyd")


def next_version(file: Path, folder: Path) -> Path:
    """The zip or wheel as the next version has it, in all places that state one."""
    write = write_wheel if file.suffix == ".whl" else write_zip
    (folder / "unpacked").mkdir(parents=True, exist_ok=True)
    files = {}
    for name, content in read_zip(file).items():
        if name.endswith(".whl"):
            inner = folder / "unpacked" / Path(name).name
            inner.write_bytes(content)
            content = next_version(inner, folder).read_bytes()
        elif name.endswith(TEXTS):
            content = content.replace(NOW.encode(), NEXT.encode())
        files[name.replace(NOW, NEXT)] = content
    return write(folder / file.name.replace(NOW, NEXT), files)


@pytest.fixture(scope="module")
def folders(tmp_path_factory: pytest.TempPathFactory) -> list[Path]:
    """What ``tools/release`` has for Blender at first, and with the next version."""
    older, newer = (tmp_path_factory.mktemp(name) for name in ("older", "newer"))
    extension, _legacy = package.package(SYSTEM)
    release.repository(older / "stable", [extension])
    release.repository(newer / "stable", [next_version(extension, tmp_path_factory.mktemp("zips"))])
    return [older, newer]


@pytest.fixture
def address(folders: list[Path]) -> Iterator[str]:
    """The address of the first folder; of the second one as soon as somebody has asked for ``publish``."""
    shown = folders[:1]

    class Handler(SimpleHTTPRequestHandler):
        def do_GET(self) -> None:
            if self.path == "/publish":
                shown[0] = folders[1]
                self.path = "/stable/"
            self.directory = str(shown[0])
            super().do_GET()

    with ThreadingHTTPServer(("127.0.0.1", 0), Handler) as server:
        threading.Thread(target=server.serve_forever, daemon=True).start()
        yield f"http://127.0.0.1:{server.server_port}"
        server.shutdown()


def run_blender(release_of_it: str, step: str, address: str, folder: Path) -> dict:
    """What is seen in a new Blender, with its user folder in ``folder``."""
    said = windows_tests.said_by_blender(SYSTEM, release_of_it, [PROGRAM, step, address], folder)
    answer = folder / f"{step}.json"
    assert answer.is_file(), said
    assert "Traceback" not in said, said
    return json.loads(answer.read_text(encoding="utf-8"))


def is_same(look: dict, other: dict) -> bool:
    return np.allclose(look["points"], other["points"], rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("blender", BLENDERS)
def test_an_update_with_a_file_open_loses_nothing(blender: str, address: str, tmp_path: Path) -> None:
    seen = run_blender(blender, "install", address, tmp_path)
    seen |= run_blender(blender, "reopen", address, tmp_path)
    assert seen["listed"] == [NOW, NEXT]
    looks = {name: look for name, look in seen.items() if isinstance(look, dict)}
    versions = {name: (look["version"], look["native"]) for name, look in looks.items()}
    waits = (NEXT, None)  # for a restart, as the process keeps the module that it has loaded
    ready = (NEXT, NEXT)
    expected = {"installed": (NOW, NOW), "updated": waits, "lifted": waits}
    assert versions == expected | {"rig.blend": ready, "lifted.blend": ready}
    for name in ("updated", "lifted"):
        assert "restart Blender" in looks[name]["panel"]
        assert "Restart Blender" in looks[name]["page"]
    heights = {name: max(z for _x, _y, z in look["points"]) for name, look in looks.items()}
    shown = {"installed": 0.5, "updated": 0.5, "lifted": 0.5, "rig.blend": 0.5, "lifted.blend": 0.75}
    assert heights == pytest.approx(shown, abs=1e-6)
    before = looks["installed"]
    assert all(is_same(looks[name], before) for name in ("updated", "lifted", "rig.blend"))
    for look in looks.values():
        assert (look["handles"], look["presets"]) == (["Top", "Base"], ["Mine.py"])
    assert [looks[name]["budget"] for name in ("installed", "updated", "lifted")] == 3 * [BUDGET]
    assert len(seen["stored"]) == 2


def test_the_folder_is_whole_and_the_same_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    zips = package.package(SYSTEM)
    wheel = tmp_path / "sinew_native.whl"
    wheel.write_bytes(next(content for name, content in read_zip(zips[0]).items() if name.endswith(".whl")))
    site = tmp_path / "site"
    site.mkdir()
    (site / "404.html").touch()
    fakes = {"TARGETS": {SYSTEM: None}, "package": lambda _system: zips, "write_site": lambda: site}
    for name, fake in fakes.items():
        monkeypatch.setattr(release, name, fake)
    monkeypatch.setattr(release.cross_wheels, "build_wheels", lambda *_words: [wheel])
    seen = []
    for name in ("one", "other"):
        monkeypatch.setattr(release, "RELEASE", tmp_path / name)
        seen.append(read_folder(release.release(("stable", "latest"))))
        subprocess.run(["sha256sum", "--check", "--strict", "SHA256SUMS"], cwd=tmp_path / name, check=True)
    assert seen[0] == seen[1]
    files = {
        "NOTES.md",
        "404.html",
        f"legacy/{zips[1].name}",
        f"python/{wheel.name}",
        f"python/sinew_native-{NOW}.tar.gz",
    }
    for channel in ("stable", "latest"):
        files |= {f"{channel}/{name}" for name in (zips[0].name, "index.json", "index.html")}
    assert seen[0].keys() == {*files, "SHA256SUMS"}
    assert len(seen[0]["SHA256SUMS"].splitlines()) == len(seen[0]) - 1


def test_blender_validates_the_extension_and_refuses_a_tag_that_it_does_not_have(
    tmp_path: Path, capfd: pytest.CaptureFixture
) -> None:
    extension, _legacy = package.package(SYSTEM)
    package.validate(extension, environments.newest_blender())
    assert "passes the validation" in capfd.readouterr().out
    files = read_zip(extension)
    files[package.MANIFEST] = files[package.MANIFEST].replace(b'"Rigging"', b'"Modifier"')
    with pytest.raises(SystemExit, match="failed"):
        package.validate(write_zip(tmp_path / extension.name, files), environments.newest_blender())
    assert 'invalid tag "Modifier"' in capfd.readouterr().err


@pytest.mark.parametrize("blender", BLENDERS[-1:])
def test_a_module_that_the_update_could_not_replace_is_there_after_a_restart(
    blender: str, address: str, tmp_path: Path
) -> None:
    """Windows neither removes nor replaces what is in use, and Blender removes it when it starts again."""
    before = run_blender(blender, "install", address, tmp_path)["installed"]
    (module,) = (tmp_path / "user" / "extensions" / ".local").rglob("sinew_native.*[do]")
    module.unlink()
    after = run_blender(blender, "reopen", address, tmp_path)["rig.blend"]
    assert after["native"] == NEXT
    assert is_same(after, before)


def test_the_repository_has_a_link_for_each_system_to_drag_into_blender(tmp_path: Path) -> None:
    """It is the same to the last byte, however the files came there."""
    extension, _legacy = package.package(SYSTEM)
    files = read_zip(extension)
    other = {"linux": "windows-x64", "windows": "linux-x64"}[SYSTEM]
    files[package.MANIFEST] = files[package.MANIFEST].replace(f"{SYSTEM}-x64".encode(), other.encode())
    zips = [extension, write_zip(tmp_path / extension.name.replace(f"{SYSTEM}-x64", other), files)]
    one, same = (
        read_folder(release.repository(tmp_path / name, each))
        for name, each in (("one", zips), ("same", reversed(zips)))
    )
    assert one == same
    listed = json.loads(one["index.json"])["data"]
    assert [row["platforms"] for row in listed] == [["linux-x64"], ["windows-x64"]]
    links = re.findall(r'href="\./(sinew[^"]+)"', one["index.html"].decode())
    asked = "repository=.%2Findex.json&blender_version_min=4.2.0&platforms="
    for link, row in zip(links, listed, strict=True):
        assert link.startswith(f"{row['archive_url'][2:]}?{asked}{row['platforms'][0]}&")

# SPDX-License-Identifier: GPL-3.0-or-later
"""What may be published, what is said about it, and what a wheel says about the libraries inside."""

import json
import re
import subprocess
import tomllib
from collections.abc import Callable
from pathlib import Path

import pytest
from workshop import notices, package, places, release, shell, windows_wheels
from workshop.places import ROOT
from workshop.zig import licences

CHANGES = "## [Unreleased]\n{}\n## [9.8.7] - 2031-05-01\n\n- Bends.\n\n## [9.8.6]\n\n- Folds.\n"
HOST = "https://host.example/sinew"


@pytest.fixture
def released(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> Callable[..., list[str]]:
    """``released(address, changes, option)``: the channels that ``tools/release`` fills from ``tmp_path``."""

    def channels(address: str, changes: str, *options: str) -> list[str]:
        seen: list[str] = []
        monkeypatch.setattr(shell, "ROOT", tmp_path)
        monkeypatch.setattr(release, "release", lambda names: seen.extend(names) or release.RELEASE)
        monkeypatch.setattr(release, "address", lambda: address)
        monkeypatch.setattr(release, "changelog", lambda: CHANGES.format(changes))
        monkeypatch.setattr("sys.argv", ["tools/release", *options])
        release.main()
        return seen

    return channels


@pytest.mark.parametrize(
    "address", ["https://sinew.invalid", "https://sinew.invalid:80/x", "sinew.example", "https://[x", ""]
)
def test_nothing_is_published_without_an_address(
    released: Callable, address: str, capsys: pytest.CaptureFixture
) -> None:
    with pytest.raises(SystemExit) as refused:
        released(address, "")
    words = rf"'{re.escape(address)}', which .*Set Homepage under \[project.urls\].*--preview"
    assert re.search(words, str(refused.value))
    assert released(address, "", "--preview") == ["stable", "latest"]
    assert "is ready. Nothing can be published yet" in capsys.readouterr().out


def test_an_address_that_nothing_states_is_none(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "pyproject.toml").write_text("[project]\n")
    monkeypatch.setattr(places, "ROOT", tmp_path)
    assert places.address() == ""


def test_what_is_not_finished_goes_to_the_channel_latest_alone(released: Callable) -> None:
    with pytest.raises(SystemExit, match="--latest"):
        released(HOST, "\n- Twists.\n")
    assert released(HOST, "\n- Twists.\n", "--latest") == ["latest"]
    assert released(HOST, "") == ["stable", "latest"]


def test_a_commit_is_published_and_its_version_once(released: Callable, tmp_path: Path) -> None:
    def git(*words: str) -> None:
        identity = ("-c", "user.name=x", "-c", "user.email=x")
        subprocess.run(["git", *identity, *words], cwd=tmp_path, check=True)

    git("init", "--quiet")
    git("commit", "--quiet", "--allow-empty", "--message=one")
    git("tag", f"v{places.version()}")
    assert released(HOST, "") == ["stable", "latest"]  # as the workflow does for a tag
    (tmp_path / "new.py").touch()
    with pytest.raises(SystemExit, match=r"before these changes are committed:\n\?\? new.py"):
        released(HOST, "")
    git("add", "new.py")
    git("commit", "--quiet", "--message=two")
    with pytest.raises(SystemExit, match=f"another commit is v{places.version()}. State the next version"):
        released(HOST, "")


def test_one_file_states_the_address(monkeypatch: pytest.MonkeyPatch) -> None:
    words = ["git", "grep", "--files-with-matches", "--fixed-strings", places.address(), "--", ":!tests"]
    found = subprocess.run(words, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert found.split() == ["pyproject.toml"]
    manifest = (ROOT / "addon" / package.MANIFEST).read_text(encoding="utf-8")
    for address, website in {HOST: HOST, "https://sinew.invalid": None}.items():
        monkeypatch.setattr(package, "address", lambda address=address: address)
        assert tomllib.loads(package.filled_manifest(manifest, [])).get("website") == website


def test_the_notes_are_those_of_the_version_or_of_what_is_new() -> None:
    assert release.notes(CHANGES.format(""), "9.8.7") == "# Sinew 9.8.7\n\n- Bends.\n"
    assert release.notes(CHANGES.format("\n- Twists.\n"), "9.8.7") == "# Sinew 9.8.7\n\n- Twists.\n"
    with pytest.raises(SystemExit, match=r"no entries for version 9\.8\.5"):
        release.notes(CHANGES.format(""), "9.8.5")
    assert len(release.notes(release.changelog(), places.version())) > 100


def test_the_bill_names_each_library_with_its_version_and_licence() -> None:
    linked = {*notices.COMPILED_IN, "pybind11", *licences(), *windows_wheels.TARGET.licences}
    bill = json.loads(notices.bill(linked))
    assert (bill["bomFormat"], bill["specVersion"]) == ("CycloneDX", "1.6")
    parts = {part["name"]: part for part in bill["components"]}
    assert parts.keys() >= {
        "Eigen",
        "CGAL",
        "suitesparse",
        "METIS",
        "onetbb",
        "opensubdiv",
        "pybind11",
        "libc++ of zig",
        "mingw-w64 of zig",
    }
    assert all(re.fullmatch(r"\d+(\.\d+)+", part["version"]) for part in parts.values())
    assert all(part["licenses"][0]["expression"] for part in parts.values())
    assert parts["onetbb"]["version"] == "2021.8.0"  # as pinned in sources.txt
    with pytest.raises(SystemExit, match="libnew-dev"):
        notices.bill([*linked, "libnew-dev"])


def test_the_manifest_names_who_wrote_each_library_that_any_module_holds() -> None:
    stated = tomllib.loads((ROOT / "addon" / package.MANIFEST).read_text(encoding="utf-8"))
    holders = " ".join(stated["copyright"]).lower()
    titles = {title for title, _licence in notices.KNOWN.values()} | {notices.METIS[0]}
    assert [title for title in sorted(titles) if title.lower() not in holders] == []


def test_workflows_pin_their_actions_and_call_what_is_here() -> None:
    for file in (ROOT / ".github" / "workflows").glob("*.yml"):
        text = file.read_text(encoding="utf-8")
        used = re.findall(r"uses: (.+)", text)
        assert [action for action in used if not re.fullmatch(r"\S+@[0-9a-f]{40} # v[\d.]+", action)] == []
        called = re.findall(r"(?<![\w/.])(?:tools|tests|\.ci)/[\w/.]*\w", text)
        assert called
        assert "\npermissions:\n  contents: read\n" in text
        assert text.count("\n    container: ") == text.count("safe.directory")  # git trusts it
        assert [name for name in called if not (ROOT / name).exists() and "requirements" not in name] == []

# SPDX-License-Identifier: GPL-3.0-or-later
"""The manual inside the zips: complete, small, readable without a network, with nothing of this machine."""

import re
import shutil
from pathlib import Path

import pytest
from html_pages import broken, pages
from workshop import site
from workshop.archives import write_zip
from workshop.places import ADDON, MANUAL, METHODS, ROOT


@pytest.fixture(scope="module")
def manual() -> dict[str, bytes]:
    return {name.removeprefix("manual/"): content for name, content in site.manual_files().items()}


def help_pages() -> list[str]:
    """The pages that the add-on's ``?`` buttons open, read without Blender."""
    rows = (ADDON / "operators" / "deformer" / "help.py").read_text()
    tasks = (ADDON / "core" / "tasks.py").read_text()
    return [*re.findall(r'^    \("([\w/-]+)", ', rows, re.MULTILINE), *re.findall(r'page="([\w-]+)"', tasks)]


def test_every_page_and_its_pictures_are_there(manual: dict[str, bytes]) -> None:
    sources = [*MANUAL.glob("*.md"), *METHODS.glob("*.md")]
    names = {path.relative_to(MANUAL if path.parent == MANUAL else ROOT / "docs") for path in sources}
    assert {name.removesuffix(".html") for name in pages(manual)} == {
        name.with_suffix("").as_posix().replace("README", "index") for name in names
    }
    shown = {
        name for path in sources for name in re.findall(r"[/(](images/[^)\s]+)\.jpg\)", path.read_text())
    }
    assert len(shown) > 60
    for name in shown:
        assert manual[f"{name}.webp"][8:12] == b"WEBP"


def test_add_on_opens_pages_that_are_there(manual: dict[str, bytes]) -> None:
    assert len(help_pages()) > 20
    assert {f"{page}.html" for page in help_pages()} <= set(manual)


def test_no_link_of_the_manual_is_broken(manual: dict[str, bytes]) -> None:
    assert not list(broken(manual))


def test_it_takes_less_than_two_megabytes_of_a_zip(manual: dict[str, bytes], tmp_path: Path) -> None:
    assert write_zip(tmp_path / "manual.zip", manual).stat().st_size < 2_000_000


def test_no_path_of_this_machine_is_in_it(manual: dict[str, bytes]) -> None:
    for name, content in manual.items():
        for path in (str(ROOT), str(Path.home()), "file:///", *(f"/{folder}/" for folder in ("home", "tmp"))):
            assert path.encode() not in content, f"{name}: {path}"


@pytest.mark.slow
def test_same_pages_give_the_same_bytes(
    manual: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(site, "MANUAL_MADE", tmp_path / "again")
    assert {f"manual/{name}": content for name, content in manual.items()} == site.manual_files()


MISSING = "missing.md one.md#missing #gone images/missing.png ../methods/missing.md missing /etc/passwd"


def test_link_that_a_reader_could_not_follow_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    checkout = tmp_path / "checkout"
    shutil.copytree(site.PAGES, checkout / "tools/workshop/pages")
    monkeypatch.setattr(site, "PAGES", checkout / "tools/workshop/pages")
    shutil.copytree(ROOT / "docs/listing", checkout / "docs/listing")
    for name, text in {
        "manual/README": "# Manual\n\n[One](one.md)",
        "manual/one": "# One & all\n\n## Part\n\n[here](#part) [there](one.md#one--all) [up](README.md)",
        "methods/README": "# Methods",
    }.items():
        (checkout / "docs" / name).with_suffix(".md").parent.mkdir(parents=True, exist_ok=True)
        (checkout / "docs" / name).with_suffix(".md").write_text(f"{text}\n")
    site.write_pages(tmp_path / "good")
    assert (tmp_path / "good" / "one.html").is_file()
    links = MISSING.split()
    with (checkout / "docs/manual/one.md").open("a") as page:
        page.write("".join(f"\n[a]({link})\n" for link in links))
    with pytest.raises(SystemExit, match="failed"):
        site.write_pages(tmp_path / "bad")
    warned = capfd.readouterr().err
    assert [link for link in links if f"'{link}'" not in warned] == []

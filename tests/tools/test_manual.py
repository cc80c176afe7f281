# SPDX-License-Identifier: GPL-3.0-or-later
"""The manual inside the zips: complete, readable without a network, and nothing of this machine in it."""

import posixpath
import re
from pathlib import Path, PurePosixPath

import pytest
from workshop.inside.render_manual import Links, render, render_methods
from workshop.places import ADDON, MANUAL, METHODS, ROOT


@pytest.fixture(scope="module")
def manual() -> dict[str, bytes]:
    try:
        return render(MANUAL) | render_methods(METHODS, MANUAL)
    except SystemExit as stop:
        pytest.fail(str(stop))


def pages(files: dict[str, bytes]) -> dict[str, Links]:
    return {name: Links(content.decode()) for name, content in files.items() if name.endswith(".html")}


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
        picture for path in sources for picture in re.findall(r"[/(](images/[^)\s]+)\)", path.read_text())
    }
    assert shown <= set(manual)
    for name in shown:
        assert manual[name] == (MANUAL / name).read_bytes()


def test_add_on_opens_pages_that_are_there(manual: dict[str, bytes]) -> None:
    assert len(help_pages()) > 20
    assert {f"{page}.html" for page in help_pages()} <= set(manual)


def test_no_link_of_the_manual_is_broken(manual: dict[str, bytes]) -> None:
    found = pages(manual)
    for name, page in found.items():
        for link in page.links:
            if re.match("https?:", link):
                continue
            path, _, anchor = link.partition("#")
            path = posixpath.normpath(posixpath.join(posixpath.dirname(name), path)) if path else name
            assert path in manual, f"{name}: {link}"
            assert not anchor or anchor in found[path].anchors, f"{name}: {link}"


def test_nothing_is_fetched_from_a_network(manual: dict[str, bytes]) -> None:
    for name, content in manual.items():
        if name.endswith((".html", ".css")):
            assert not re.search(rb"""(src=["']?|url\(|@import)\W*https?:""", content), name
            assert b"<script" not in content, name


def test_no_path_of_this_machine_is_in_it(manual: dict[str, bytes]) -> None:
    for name, content in manual.items():
        for path in (str(ROOT), str(Path.home()), "file:", *(f"/{folder}/" for folder in ("home", "tmp"))):
            assert path.encode() not in content, f"{name}: {path}"
        assert not PurePosixPath(name).is_absolute()


def test_same_pages_give_the_same_bytes(manual: dict[str, bytes]) -> None:
    assert render(MANUAL) | render_methods(METHODS, MANUAL) == manual


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "images").mkdir()
    (tmp_path / "images" / "a.jpg").write_bytes(b"picture")
    (tmp_path / "README.md").write_text("# Manual\n\n[One](one.md)\n")
    (tmp_path / "one.md").write_text(
        "<!-- SPDX-License-Identifier: GPL-3.0-or-later -->\n# One & all\n\n## Its part\n\n"
        "![A picture](images/a.jpg) [here](#its-part), [up](README.md), [web](https://example.org/a.md#b)\n\n"
        "| a | b |\n|---|---|\n| 1 | 2 |\n\n```python\nx = '<y>'\n```\n"
    )
    return tmp_path


def test_links_lead_to_the_rendered_pages(folder: Path) -> None:
    files = render(folder)
    assert set(files) == {"index.html", "one.html", "images/a.jpg", "manual.css"}
    assert set(pages(files)["index.html"].links) == {"one.html", "manual.css"}
    one = files["one.html"].decode()
    links = (
        'src="images/a.jpg"',
        'href="#its-part"',
        'href="index.html"',
        'href="https://example.org/a.md#b"',
    )
    for part in ("<title>One &amp; all</title>", *links, "<td>1</td>", "&lt;y&gt;"):
        assert part in one, part
    assert "SPDX" not in one


MISSING = """
missing.md one.md#missing #missing images/missing.png ../methods/missing.md ../developer/performance.md
../README.md /etc/passwd file:///etc/passwd
"""


@pytest.mark.parametrize("link", MISSING.split())
def test_link_that_a_reader_could_not_follow_is_refused(folder: Path, link: str) -> None:
    (folder / "two.md").write_text(f"# Two\n\n[link]({link})\n")
    with pytest.raises(SystemExit, match=re.escape(f"two.md: {link}")):
        render(folder)

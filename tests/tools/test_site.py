# SPDX-License-Identifier: GPL-3.0-or-later
"""The site: whole, and read from the disk in a browser, as wide as a phone's screen and as a desk's."""

import re
import subprocess
from pathlib import Path

import pytest
from html_pages import broken, pages
from workshop import debian, site
from workshop.archives import read_folder
from workshop.places import METHODS

pytestmark = pytest.mark.slow
# Frames with pages, and a script that writes down what is wrong in them when all is loaded.
FRAME = '<iframe src="{}/{}" width="{}" height="900"></iframe>'
READER = """<!DOCTYPE html><body onload="read()"><pre></pre>{}<script>
function read() {{
    const wrong = [];
    for (const frame of document.querySelectorAll("iframe")) {{
        const {{ documentElement: page, images }} = frame.contentDocument;
        if (page.scrollWidth > frame.width)
            wrong.push(`${{frame.src}} is ${{page.scrollWidth}} wide, not ${{frame.width}}`);
        for (const image of images)
            if (!image.naturalWidth) wrong.push(`${{frame.src}} does not show ${{image.src}}`);
    }}
    document.querySelector("pre").textContent = wrong.join("\\n") || "all is well";
}}
</script></body>"""
TOGETHER = 40  # pages that a browser opens at the same time
ON_A_DESK = ("index", "gallery", "methods/arap", "methods/index", "api/functions", "developer/events")


@pytest.fixture(scope="module")
def files() -> dict[str, bytes]:
    site.manual_files()
    return read_folder(site.write_site())


@pytest.fixture(scope="module")
def browser() -> list[str]:
    try:
        debian.install(debian.BROWSER)
    except SystemExit as stop:
        pytest.skip(f"no browser reads the site here: {stop}")
    return ["chromium", "--headless=new", "--no-sandbox", "--disable-gpu", "--dump-dom"]


def seen(browser: list[str], address: str, *options: str) -> str:
    """The page as it is after its scripts."""
    command = [*browser, *options, address]
    return subprocess.run(command, capture_output=True, text=True, timeout=120, check=True).stdout


def test_no_link_is_broken_and_nothing_comes_from_a_network(files: dict[str, bytes]) -> None:
    assert len(files) > 1000
    # Doxygen links to headings of pages that have none of that name.
    of_doxygen = re.compile("^api/native/.*#(details|nested-classes)$")
    assert [link for link in broken(files) if not of_doxygen.search(link)] == []


def test_methods_classes_and_headers_have_pages(files: dict[str, bytes]) -> None:
    found = pages(files)
    methods = {page.stem for page in METHODS.glob("*.md")}
    methods -= {"README", "comparison", "subdivision_warp", "tutorial"}  # which are no single method
    assert methods
    linked = {Path(link).stem for link in found["gallery.html"].links if link.startswith("methods/")}
    assert methods <= linked
    assert "sinew_native.Arap.energy" in found["api/surface-methods.html"].anchors
    assert "sinew_native.laplacian" in found["api/functions.html"].anchors
    assert b"As-rigid-as-possible" in files["api/native/classsinew_1_1Arap.html"]
    assert b"class Arap" in files["source/native/methods/surface/nonlinear/arap.h.txt"]
    assert "../source/native/methods/surface/nonlinear/arap.h.txt" in found["methods/arap.html"].links


def test_a_site_with_a_host_leads_to_the_links_that_install(
    files: dict[str, bytes], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def write(folder: Path) -> None:
        folder.mkdir()
        (folder / "index.html").touch()

    fakes = {
        "SITE": tmp_path / "site",
        "write_native_pages": write,
        "address": lambda: "https://host.example/a",
    }
    for name, fake in fakes.items():
        monkeypatch.setattr(site, name, fake)
    links = pages(read_folder(site.write_site()))["index.html"].links
    assert "https://host.example/a/stable/index.html" in links
    assert not any("stable/" in link for link in pages(files)["index.html"].links)


@pytest.mark.usefixtures("files")
@pytest.mark.parametrize("folder", [site.SITE, site.MANUAL_MADE], ids=["site", "manual"])
def test_search_finds_a_method_without_a_server(browser: list[str], folder: Path) -> None:
    page = seen(browser, f"{(folder / 'index.html').as_uri()}?q=arap", "--virtual-time-budget=20000")
    results = re.findall(r'href="([^"]*)" class="md-search-result__link', page)
    assert results[0].startswith((folder / "methods/arap.html").as_uri())


def test_every_page_fits_a_phone_and_a_desk_and_shows_its_pictures(
    browser: list[str], files: dict[str, bytes], tmp_path: Path
) -> None:
    names = [name for name in files if name.endswith(".html") and not name.startswith("api/native/")]
    read = [(name, 390) for name in [*names, "api/native/index.html", "api/native/classsinew_1_1Arap.html"]]
    read += [(f"{name}.html", 1440) for name in ON_A_DESK]
    reader = tmp_path / "reader.html"
    for start in range(0, len(read), TOGETHER):
        frames = [FRAME.format(site.SITE.as_uri(), *each) for each in read[start : start + TOGETHER]]
        reader.write_text(READER.format("".join(frames)))
        page = seen(browser, reader.as_uri(), "--allow-file-access-from-files")
        assert re.findall(r"<pre>(.*?)</pre>", page, flags=re.DOTALL) == ["all is well"]

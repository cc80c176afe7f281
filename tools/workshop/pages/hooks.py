# SPDX-License-Identifier: GPL-3.0-or-later
"""What MkDocs makes the site from, and the manual inside the zips: pages and pictures of the checkout.

``extra`` of the configuration names a folder with the types of `sinew_native`, one with Doxygen's pages about
the C++ headers, and the address of the host if there is one. Without the folders it is the manual of artists,
with the methods and small pictures.

The site holds each other file that a page links to, as text. In the manual, such a link is its text alone.
"""

import io
import re
from collections.abc import Iterable, Iterator
from pathlib import Path
from posixpath import dirname, join, normpath
from urllib.parse import unquote

from mkdocs.config.defaults import MkDocsConfig
from mkdocs.structure.files import File, Files
from mkdocs.structure.pages import Page
from PIL import Image

ROOT = Path(__file__).parents[3]
MANUAL, METHODS, DEVELOPER = "docs/manual", "docs/methods", "docs/developer"
ICON = "docs/listing/icon.svg"
ABOVE = {
    "README.md": "index.html",
    "CONTRIBUTING.md": "developer/contributing.html",
    "CHANGELOG.md": "changes.html",
    "LLM.md": "api/scripts.html",
}
# Pages about the Python module, and the base of the classes on each; "" for all other classes.
API = {
    "Surface methods": "SurfaceMethod",
    "Space methods": "SpaceMethod",
    "Errors": "Error",
    "Other classes": "",
    "Functions": None,
}
LIBRARY, NATIVE = "api/index.md", "api/native/"  # the latter are Doxygen's pages
ABOUT_LIBRARY = f"""# The library

Sinew's methods without Blender, in Python and in C++. The page of each method has a program of a few lines,
and [Scripts](../{MANUAL}/scripting.md#the-library-alone) says how to install the module.

| page | in the Python module `sinew_native` |
|---|---|
{{}}

In C++, [the headers, room by room](native/index.html).
"""
LINK = re.compile(r"\]\(<?([^)\s>#]+)")
PICTURE = re.compile(r"!\[([^\]]+)\]\(([^)\s]+\.(?:jpg|png))\)")
LARGEST, QUALITY = {True: 1600, False: 960}, {True: 80, False: 65}  # of pictures in the site, in the manual


def on_config(config: MkDocsConfig) -> MkDocsConfig:
    manual, methods = (listed(f"{folder}/README.md") for folder in (MANUAL, METHODS))
    home = "README.md" if is_site(config) else manual.pop(0)
    parts = {"Sinew": home, "Manual": manual, "Methods": methods}
    if is_site(config):
        decisions = sorted(ROOT.glob(f"{DEVELOPER}/decisions/*.md"))
        developers = [*listed(f"{DEVELOPER}/README.md"), "CONTRIBUTING.md", "CHANGELOG.md"]
        developers.append({"Decisions": [path.relative_to(ROOT).as_posix() for path in decisions]})
        library = [LIBRARY, "LLM.md", *map(api_page, API)]
        parts |= {"Gallery": "gallery.md", "Library": library, "Developers": developers}
    if config.extra["host"]:
        parts["Install"] = f"{config.extra['host']}/stable/index.html"  # as tools/release makes it
    config.nav = [{title: pages} for title, pages in parts.items()]
    return config


def is_site(config: MkDocsConfig) -> bool:
    return bool(config.extra["types"])


def listed(readme: str) -> list:
    """The page, and the pages of its folder in the order in which it links to them, below its headings."""
    found: list = [readme]
    part, seen = found, {readme}
    for line in (ROOT / readme).read_text("utf-8").splitlines():
        if line.startswith("## "):
            found.append({line[3:]: (part := [])})
        for page in (join(dirname(readme), link) for link in LINK.findall(line)):
            if page not in seen and dirname(page) == dirname(readme) and page.endswith(".md"):
                seen.add(page)
                part.append(page)
    return [entry for entry in found if isinstance(entry, str) or all(entry.values())]


def on_files(files: Files, config: MkDocsConfig) -> Files:
    site = is_site(config)
    pages = sorted(ROOT.glob("docs/*/**/*.md" if site else "docs/m*/*.md"))
    names = [path.relative_to(ROOT).as_posix() for path in pages if "listing" not in path.parts]
    for name in [*names, ICON, *(ABOVE if site else ())]:
        files.append(File(name, str(ROOT), config.site_dir, False, dest_uri=place(name, site)))
    linked = {target for file in [*files] if file.is_documentation_page() for target in targets(file)}
    for name in sorted(linked):
        if files.get_file_from_path(name) is None and (made := content(name, config)) is not None:
            files.append(generated(config, name, place(name, site), made))
    if site:
        write_api(files, config)
        files.append(File.generated(config, "gallery.md", content=gallery(files, config)))
    return files


def place(name: str, site: bool) -> str:
    """Where a file of the checkout is in the site or in the manual."""
    path = Path(name).with_name("index.md" if Path(name).name == "README.md" else Path(name).name)
    if name in ABOVE or name == ICON:
        return ABOVE.get(name, path.name)
    if not name.startswith("docs/") and path.suffix not in (".jpg", ".png"):
        return f"source/{name}.txt"
    suffixes = {".md": ".html", ".jpg": ".webp", ".png": ".webp"}
    inside = path.with_suffix(suffixes.get(path.suffix, path.suffix)).as_posix()
    return inside.removeprefix("docs/").removeprefix("" if site else "manual/")


def targets(file: File) -> Iterator[str]:
    """The files and folders of the checkout that a page links to."""
    prose = re.sub(r"^```.*?^```|`[^`\n]*`", "", file.content_string, flags=re.S | re.M)
    for link in LINK.findall(prose):
        name = normpath(join(dirname(file.src_uri), unquote(link)))
        if not re.match("[a-z]+:", link) and (ROOT / name).exists():
            yield name


def content(name: str, config: MkDocsConfig) -> bytes | str | None:
    """What is shown of a file or folder of the checkout that is no page."""
    path, site = ROOT / name, is_site(config)
    if path.suffix in (".jpg", ".png"):
        picture, packed = Image.open(path), io.BytesIO()
        picture.thumbnail((LARGEST[site], 10_000))
        picture.save(packed, "WEBP", quality=QUALITY[site], method=4)
        return packed.getvalue()
    if path.suffix == ".svg":
        return path.read_bytes()
    if not site:
        return None
    inside = sorted(each.name for each in path.iterdir()) if path.is_dir() else ()
    return "\ufeff" + ("\n".join(inside) or path.read_text("utf-8"))


def generated(config: MkDocsConfig, name: str, target: str, made: bytes | str) -> File:
    file = File.generated(config, name, content=made)
    file.dest_uri = target
    return file


def write_api(files: Files, config: MkDocsConfig) -> None:
    """Pages for the classes and functions of the module, and those of Doxygen."""
    types = (Path(config.extra["types"]) / "sinew_native.py").read_text("utf-8")
    bases = dict(re.findall(r"^class (\w+)(?:\((\w+)\))?:", types, flags=re.M))
    functions = re.findall(r"^def (\w+)", types, flags=re.M)
    rows = []
    for title, base in API.items():
        chosen = functions if base is None else [name for name in bases if family(name, bases) == base]
        named = ", ".join(f"[{name}][sinew_native.{name}]" for name in chosen)
        rows.append(f"| [{title}]({Path(api_page(title)).name}) | {named} |")
        text = "\n".join([f"# {title}", "", *(f"::: sinew_native.{name}\n" for name in chosen)])
        files.append(File.generated(config, api_page(title), content=text))
    files.append(File.generated(config, LIBRARY, content=ABOUT_LIBRARY.format("\n".join(rows))))
    headers = Path(config.extra["headers"])
    for path in sorted(path for path in headers.rglob("*") if path.is_file()):
        inside = path.relative_to(headers).as_posix()
        files.append(File.generated(config, NATIVE + inside, abs_src_path=str(path)))


def api_page(title: str) -> str:
    return f"api/{title.lower().replace(' ', '-')}.md"


def family(name: str, bases: dict[str, str]) -> str:
    """The base of a class that has a page, or nothing."""
    while name and name not in API.values():
        name = bases.get(name, "")
    return name


def gallery(files: Files, config: MkDocsConfig) -> str:
    """A page with the picture of each method in the add-on, and with each picture of the manual."""
    pages = [file for file in files if file.src_uri.startswith("docs/m") and file.src_uri.endswith(".md")]
    small, large = [], {}
    for page in pages:
        name = f"addon/pictures/{Path(page.src_uri).stem}.png"
        if page.src_uri.startswith(METHODS) and (ROOT / name).is_file():
            label = re.search("^# (.+)", page.content_string, flags=re.M)[1]
            files.append(generated(config, name, f"pictures/{Path(name).stem}.webp", content(name, config)))
            small.append(f"[![{label}]({name})<br>{label}]({page.src_uri})")
        for words, picture in PICTURE.findall(page.content_string):
            place_of = normpath(join(dirname(page.src_uri), picture))
            if "/task-" not in picture:
                large.setdefault(place_of, f"[![{words}]({place_of})]({page.src_uri})<br>{words}")
    parts = ["# Gallery", "## Methods", *figures("small", small), "## The manual"]
    return "\n\n".join([*parts, *figures("large", large.values())])


def figures(kind: str, found: Iterable[str]) -> Iterator[str]:
    yield f'<div class="gallery {kind}" markdown>'
    yield from (f"<figure markdown>\n{figure}\n</figure>" for figure in found)
    yield "</div>"


def on_page_markdown(markdown: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Lets the page about a method begin with its picture, and the search prefer what artists read."""
    name = page.file.src_uri
    page.meta["search"] = {"boost": 4 if name.startswith((MANUAL, METHODS)) else 1}
    page.meta["tags"] = [Path(name).stem] if name.startswith(METHODS) else []  # found before all else
    markdown = re.sub(r"\A<!--.*?-->\s*", "", markdown, flags=re.S)  # a title stands in the first line
    picture = PICTURE.search(markdown)
    if name.startswith(METHODS) and picture and "| | |" in markdown:
        rest = markdown.replace(f"{picture[0]}\n", "", 1)
        markdown = rest.replace("| | |", f"{picture[0]}\n\n| | |", 1)
    return markdown


def on_page_content(html: str, page: Page, config: MkDocsConfig, files: Files) -> str:
    """Leaves the text of links to what the manual does not hold. The site holds all: it is strict."""
    there = {file.dest_uri for file in files}

    def kept(link: re.Match[str]) -> str:
        target = normpath(join(dirname(page.file.dest_uri), link[1].partition("#")[0]))
        return link[0] if re.match("#|[a-z]+:", link[1]) or target in there else link[2]

    return re.sub(r'<a href="([^"]*)">(.*?)</a>', kept, html, flags=re.S)

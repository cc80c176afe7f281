# SPDX-License-Identifier: GPL-3.0-or-later
"""Renders the pages of a folder, ``*.md``, as HTML with their pictures, and those about methods below them:
``render_manual.py SOURCE METHODS TARGET``.

Run by a Python that has the package ``markdown``. Every relative link must lead to another page, to a heading
that is there, to a page about a method, or to a picture in the folder: a reader of the packaged manual has
nothing else. Pages about methods are read by developers, too: of what only those have, the text of the link
is left.
"""

import html
import re
import sys
from pathlib import Path, PurePosixPath
from urllib.parse import unquote, urlsplit

import markdown

INDEX = "README.md"
STYLE = Path(__file__).with_name("manual.css")
PICTURES = (".jpg", ".png", ".svg")
FRAME = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<link rel="stylesheet" href="{up}manual.css">
</head>
<body>
{back}<main>
{body}
</main>
</body>
</html>
"""
BACK = '<nav><a href="{up}index.html">Sinew manual</a></nav>\n'
BELOW = "methods"  # the folder of the pages about methods
MANUAL = "../manual/"  # how they call the folder of the manual
METHODS = "../methods/"  # how the manual calls theirs


def render(source: Path) -> dict[str, bytes]:
    """Every file of the manual: name -> content."""
    bodies = {path.name: body(path) for path in sorted(source.glob("*.md"))}
    found = {name: Links(text) for name, text in bodies.items()}
    files = {STYLE.name: STYLE.read_bytes()}
    for name, text in bodies.items():
        for link in found[name].links:
            if problem := broken(link, name, source, found):
                raise SystemExit(f"{name}: {link} {problem}")
            path = unquote(urlsplit(link).path)
            if not is_elsewhere(link) and path.endswith(PICTURES):
                files[path] = (source / path).read_bytes()
        back = BACK.format(up="") if INDEX in bodies and name != INDEX else ""
        files[page_name(name)] = framed(text, back, "")
    return files


def render_methods(source: Path, manual: Path) -> dict[str, bytes]:
    """The pages about methods, and the pictures that they show: name -> content."""
    files = {}
    for path in sorted(source.glob("*.md")):
        text = re.sub(r'<a href="([^"]*)">(.*?)</a>', lambda link: kept(link, source), body(path), flags=re.S)
        for picture in re.findall(rf'src="{MANUAL}([^"]+)"', text):
            files[picture] = (manual / picture).read_bytes()
        text = re.sub(rf'(href|src)="{MANUAL}', r'\1="../', text)
        files[f"{BELOW}/{page_name(path.name)}"] = framed(text, BACK.format(up="../"), "../")
    return files


def kept(link: re.Match[str], source: Path) -> str:
    """A link to what the manual has; of any other one its text."""
    path = unquote(urlsplit(link[1]).path)
    is_here = "/" not in path.removeprefix(MANUAL) and (not path or (source / path).is_file())
    return link[0] if is_elsewhere(link[1]) or is_here else link[2]


def framed(text: str, back: str, up: str) -> bytes:
    """A whole page. ``up`` leads from it to the folder of the manual."""
    title = html.escape(Links(text).title or "Sinew")
    return FRAME.format(title=title, back=back, up=up, body=linked(text)).encode()


def body(path: Path) -> str:
    """The HTML of a page, with its links as they are written."""
    text = re.sub(r"\A<!--.*?-->\s*", "", path.read_text(encoding="utf-8"), flags=re.S)  # the licence line
    extensions = ["tables", "fenced_code", "toc", "sane_lists"]
    return markdown.markdown(text, extensions=extensions, output_format="html")


def page_name(markdown_name: str) -> str:
    return "index.html" if markdown_name == INDEX else markdown_name.removesuffix(".md") + ".html"


def linked(text: str) -> str:
    """The text with links to the HTML of other pages instead of their Markdown."""
    return re.sub(
        rf'href="({METHODS}|(?:\.\./)?)([^"#/]+\.md)(#[^"]*)?"',
        lambda match: f'href="{match[1].replace(METHODS, BELOW + "/")}{page_name(match[2])}{match[3] or ""}"',
        text,
    )


class Links:
    """The links of a page, its anchors, and its title."""

    def __init__(self, text: str) -> None:
        tags = re.findall(r"<[a-z][^>]*>", text)
        found = [pair for tag in tags for pair in re.findall(r'\b(href|src|id|name)="([^"]*)"', tag)]
        self.links = [html.unescape(value) for key, value in found if key in ("href", "src")]
        self.anchors = {value for key, value in found if key in ("id", "name")}
        title = re.search(r"<h1[^>]*>(.*?)</h1>", text, flags=re.S)
        self.title = html.unescape(re.sub(r"<[^>]*>", "", title[1])) if title else ""


def is_elsewhere(link: str) -> bool:
    return urlsplit(link).scheme in ("http", "https", "mailto")


def broken(link: str, page: str, source: Path, pages: dict[str, Links]) -> str:
    """What is wrong with a link; empty if it is right."""
    if is_elsewhere(link):
        return ""
    parts = urlsplit(link)
    path = unquote(parts.path)
    if path.startswith(METHODS):
        return "" if (source / path).is_file() and not parts.fragment else "is no page about a method"
    if parts.scheme or parts.netloc or path.startswith("/") or ".." in PurePosixPath(path).parts:
        return "leads out of the manual"
    if path.endswith(PICTURES):
        return "" if (source / path).is_file() else "is no picture here"
    target = pages.get(path or page)
    if target is None:
        return "is no page of the manual"
    return "" if not parts.fragment or parts.fragment in target.anchors else "is no heading there"


def main(source: Path, methods: Path, target: Path) -> None:
    for name, content in (render(source) | render_methods(methods, source)).items():
        (target / name).parent.mkdir(parents=True, exist_ok=True)
        (target / name).write_bytes(content)


if __name__ == "__main__":
    main(*map(Path, sys.argv[1:4]))

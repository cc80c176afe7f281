# SPDX-License-Identifier: GPL-3.0-or-later
"""What pages in HTML link to, and whether it is there."""

import posixpath
import re
from collections.abc import Iterator
from html.parser import HTMLParser
from urllib.parse import unquote

FROM_A_NETWORK = re.compile(
    rb"""<(?:script|img|link|iframe)\b[^>]*\b(?:src|href)=["']?(?:https?:)?//|@import|url\(["']?(?:https?:)?//"""
)


class Links(HTMLParser):
    """The links of a page, its anchors, and what it shows."""

    def __init__(self, content: bytes) -> None:
        super().__init__()
        self.links: set[str] = set()
        self.anchors: set[str] = set()
        self.feed(content.decode())

    def handle_starttag(self, _tag: str, attributes: list[tuple[str, str | None]]) -> None:
        for name, value in attributes:
            if name in ("href", "src"):
                self.links.add(value or "")
            elif name in ("id", "name"):
                self.anchors.add(value or "")


def pages(files: dict[str, bytes]) -> dict[str, Links]:
    return {name: Links(content) for name, content in files.items() if name.endswith(".html")}


def broken(files: dict[str, bytes]) -> Iterator[str]:
    """The links of all pages that lead nowhere, and what they fetch from a network."""
    found = pages(files)
    for name, content in files.items():
        if name.endswith((".html", ".css")) and (fetched := FROM_A_NETWORK.search(content)):
            yield f"{name}: {fetched[0]!r}"
    for name, page in found.items():
        for link in page.links:
            if re.match("[a-z]+:", link) or link == "#":
                continue
            path, _, anchor = unquote(link).partition("#")
            path = posixpath.normpath(posixpath.join(posixpath.dirname(name), path)) if path else name
            if path not in files or (anchor and path in found and anchor not in found[path].anchors):
                yield f"{name}: {link}"

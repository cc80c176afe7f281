# SPDX-License-Identifier: GPL-3.0-or-later
"""Writes the site into `dist/site`: manual, methods, gallery, the library in Python and C++, for developers.

Its pages need no network, and no server: they can be opened from a disk. The zips hold its manual and its
methods.
"""

import argparse
import shutil
import tempfile
from pathlib import Path

from . import environments
from .archives import read_folder
from .dev import types
from .native_pages import write_native_pages
from .places import BUILD, DIST, MANUAL, METHODS, ROOT, address, exists, version
from .shell import Stamp, fingerprint, must, one_at_a_time, say

SITE = DIST / "site"
PAGES = Path(__file__).parent / "pages"
REQUIREMENTS = environments.REQUIREMENTS / "site.txt"
MANUAL_MADE = BUILD / "manual"
LEFT_OUT = (
    "404.html",  # this and the next need an address
    "sitemap.*",
    "**/*.map",
    "assets/javascripts/lunr",  # other languages than English
)
OF_SERVERS = "search/search_index.json"  # browsers do not read it from a disk
# How pybind11 writes what a reader calls int and float.
PLAIN = {
    "typing.SupportsFloat | typing.SupportsIndex": "float",
    "typing.SupportsInt | typing.SupportsIndex": "int",
    "numpy.typing.": "",
}


def write_pages(target: Path, **settings: str | Path) -> None:
    """Lets MkDocs write its pages, whose links are relative. A broken one ends that."""
    shutil.rmtree(target, ignore_errors=True)
    env = {f"SINEW_{name.upper()}": value for name, value in settings.items()}
    mkdocs = [environments.site().make().python, "-m", "mkdocs", "build"]
    command = [*mkdocs, "--config-file", PAGES / "mkdocs.yml", "--site-dir", target]
    must(command, env=env | {"NO_MKDOCS_2_WARNING": "1"}, quiet=True)
    for path in [path for pattern in LEFT_OUT for path in target.glob(pattern)]:
        shutil.rmtree(path) if path.is_dir() else path.unlink()


@one_at_a_time()
def write_site() -> Path:
    text = types().read_text(encoding="utf-8")
    for written, plain in PLAIN.items():
        text = text.replace(written, plain)
    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "sinew_native.py").write_text(text, encoding="utf-8")
        write_native_pages(Path(folder) / "native")
        write_pages(
            SITE,
            title=f"Sinew {version()}",
            api="true",
            types=folder,
            headers=Path(folder) / "native",
            host=address() if exists(address()) else "",
        )
    return SITE


@one_at_a_time()
def manual_files() -> dict[str, bytes]:
    """The manual that the ``?`` buttons open: path inside the add-on -> content."""
    made_from = fingerprint([MANUAL, METHODS, ROOT / "docs/listing", PAGES, REQUIREMENTS], str(LEFT_OUT))
    stamp = Stamp(MANUAL_MADE.with_suffix(".made-from"), made_from)
    if not stamp.is_fresh():
        write_pages(MANUAL_MADE, title="Sinew", missing="ignore")
        stamp.write()
    files = read_folder(MANUAL_MADE)
    return {f"manual/{name}": content for name, content in files.items() if name != OF_SERVERS}


def main() -> None:
    argparse.ArgumentParser(prog="tools/site", description=__doc__).parse_args()
    pages = write_site()
    say(f"Open {(pages / 'index.html').relative_to(ROOT)}")

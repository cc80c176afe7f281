# SPDX-License-Identifier: GPL-3.0-or-later
"""Prints which share of the lines of each room the tests reach.

``native``   the library, by its own tests and those of the Python module (it compiles for 15 minutes)
``addon``    ``core`` and ``backend``, by the tests without Blender
``blender``  all of the add-on, by the tests in Debian's Blender
"""

import argparse
import json
import os
import subprocess
from collections import Counter, defaultdict
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import chain
from pathlib import Path

from . import debian, environments
from .blenders import HEADLESS, INSIDE, install_legacy
from .dev import build_tree
from .places import BUILD, DEV_MODULE, ROOT
from .shell import jobs, run, said, say
from .suites import OPTIONS

TREE = BUILD / "coverage"
MODULE = BUILD / "coverage-module"
DATA = BUILD / "results"
Lines = dict[Path, dict[int, bool]]  # file of the repository -> line that can run -> whether it ran


def native() -> Lines:
    build_tree("coverage")
    for old in TREE.rglob("*.gcda"):
        old.unlink()
    run(["ctest", "-j", str(jobs()), "--quiet"], cwd=TREE)
    python = environments.dev().make().python
    run([python, "-m", "pytest", "tests/bindings", *OPTIONS], env={"PYTHONPATH": MODULE})
    found: Lines = defaultdict(dict)
    with ThreadPoolExecutor(jobs()) as pool:
        for counted in pool.map(_gcov, sorted(TREE.rglob("*.gcno"))):
            for file, number, ran in counted:
                found[file][number] = found[file].get(number, False) or ran
    return found


def _gcov(notes: Path) -> list[tuple[Path, int, bool]]:
    """The lines below native/ that are compiled into one object file."""
    text = said(["gcov", "--json-format", "--stdout", notes], cwd=TREE, stderr=subprocess.DEVNULL)
    reports = [json.loads(line) for line in text.splitlines() if line.startswith("{")]
    return [
        (path, line["line_number"], line["count"] > 0)
        for entry in chain.from_iterable(report["files"] for report in reports)
        if (path := (TREE / entry["file"]).resolve()).is_relative_to(ROOT / "native")
        for line in entry["lines"]
    ]


def addon() -> Lines:
    build_tree("dev", "sinew_native")
    python, data = environments.dev().make().python, _fresh("addon.coverage")
    command = [python, "-m", "coverage", "run", f"--data-file={data}", "--source=addon/core,addon/backend"]
    run([*command, "-m", "pytest", "tests/addon", *OPTIONS], env={"PYTHONPATH": DEV_MODULE})
    return _reported(data)


def blender() -> Lines:
    debian.install(debian.BLENDER_TESTS)
    dev, data = environments.dev().make(), _fresh("blender.coverage")
    env = install_legacy("coverage")
    env["SINEW_COVERAGE"] = f"{data}{os.pathsep}{dev.site_packages}"
    run([*HEADLESS, INSIDE / "measured_pytest.py", "--", *OPTIONS], env=env)
    return _reported(data)


def _fresh(name: str) -> Path:
    DATA.mkdir(parents=True, exist_ok=True)
    (DATA / name).unlink(missing_ok=True)
    return DATA / name


def _reported(data: Path) -> Lines:
    """The report of coverage.py. Files of an installed add-on count as the files of addon/."""
    report = data.with_suffix(".json")
    python = environments.dev().python
    run([python, "-m", "coverage", "json", "-q", f"--data-file={data}", "-o", report])
    found: Lines = {}
    for name, file in json.loads(report.read_text(encoding="utf-8"))["files"].items():
        path = ROOT / "addon" / name.rpartition("/addons/sinew/")[2].removeprefix("addon/")
        ran, missed = dict.fromkeys(file["executed_lines"], True), dict.fromkeys(file["missing_lines"], False)
        if path.is_file():
            found[path] = ran | missed
    return found


def table(parts: Iterable[Lines]) -> Iterator[str]:
    """One line per room, and one for each of native/ and addon/."""
    lines: Counter[str] = Counter()
    reached: Counter[str] = Counter()
    whole: dict[Path, dict[int, bool]] = defaultdict(dict)
    for part in parts:
        for file, found in part.items():
            for number, ran in found.items():
                whole[file][number] = whole[file].get(number, False) or ran
    for file, found in whole.items():
        inside = file.relative_to(ROOT)
        for room in {inside.parts[0], inside.parent.as_posix()}:
            lines[room] += len(found)
            reached[room] += sum(found.values())
    yield f"{'room':<40}{'lines':>8}{'reached':>10}"
    for room in sorted(lines):
        yield f"{room:<40}{lines[room]:>8}{100 * reached[room] / max(lines[room], 1):>8.1f} %"


PARTS: dict[str, Callable[[], Lines]] = {"native": native, "addon": addon, "blender": blender}


def main() -> None:
    as_it_is = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(prog="tools/coverage", description=__doc__, formatter_class=as_it_is)
    about = "the parts to run; without any, all"
    parser.add_argument("parts", nargs="*", choices=[[], *PARTS], default=[], metavar="PART", help=about)
    for line in table([PARTS[name]() for name in parser.parse_args().parts or PARTS]):
        say(line)

# SPDX-License-Identifier: GPL-3.0-or-later
"""The check of an installation: every known answer, in a report that a user can attach to an issue."""

import datetime
import os
import platform
import sys
import time
import traceback
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from ..core.errors import SinewError
from ..core.methods import BY_ID, DEFAULT_CAGE_METHOD, METHODS, Method
from ..ids import VERSION
from . import known_answers
from .known_answers import KnownAnswer, Rig
from .native import Factor, automatic_cage, availability, build_factor, limits
from .recipes import ControlPoints, Faces, Recipe, Shape

# Whatever a module throws that was built for something else, or broken on its way.
_FAILURES = (
    *(SinewError, ArithmeticError, AttributeError, LookupError, MemoryError, OSError),
    *(RuntimeError, TypeError, ValueError),
)


@dataclass(frozen=True)
class Check:
    """How many answers were ``asked`` for, how many of them are ``wrong``, and where the ``report`` lies."""

    asked: int = 0
    wrong: int = 0
    report: str = ""

    @property
    def is_right(self) -> bool:
        """Whether there were answers, and all are right."""
        return self.asked > 0 and self.wrong == 0

    @property
    def summary(self) -> str:
        """One line for people."""
        if not self.asked:
            return "Nothing could be computed: the native module does not work here"
        if self.wrong:
            return f"{self.wrong} of {self.asked} known answers are wrong"
        return f"All {self.asked} known answers are right"


@dataclass(frozen=True)
class _Result:
    claim: str
    seconds: float
    difference: float = 0.0
    allowed: float = 0.0
    failure: str = ""  # the traceback

    @property
    def is_right(self) -> bool:
        return not self.failure and self.difference <= self.allowed  # NaN is not

    def __str__(self) -> str:
        verdict = "right" if self.is_right else "WRONG"
        measured = f"{self.difference:8.1e} (at most {self.allowed:.0e})"
        return f"  {verdict}  {self.claim:36} {measured}  {self.seconds:7.3f} s"


_last = Check()


def last_check() -> Check:
    """The last check of this process; nothing was asked before the first."""
    return _last


def check_installation(report: TextIO, blender: str, path: str = "") -> Check:
    """Compute all known answers and write the report, which lies at ``path``, if it is a file.

    ``blender`` is what the report says about Blender. The name of a method is written before it computes
    anything, so that a crash leaves it behind. A method that fails does not stop the others.
    """
    global _last
    asked = wrong = 0

    def say(text: str) -> None:
        report.write(f"{text}\n")
        report.flush()

    for line in _surroundings(blender):
        say(line)
    for words, results in _questions():
        say(f"\n{words}")
        found = []
        for result in results:
            say(str(result))
            found.append(result)
        for failure in dict.fromkeys(result.failure for result in found if result.failure):
            say(f"\n{_without_home(failure)}")
        asked += len(found)
        wrong += sum(not result.is_right for result in found)
    _last = Check(asked, wrong, path)
    say(f"\n{_last.summary}.")
    return _last


def _questions() -> Iterator[tuple[str, Iterator[_Result]]]:
    """The methods with their options, in words, and the answers of each, which are computed one by one."""
    if availability().module is None:
        return
    for method in METHODS:
        for words, rig in known_answers.rigs(method):
            about = f"{method.id}, {words}" if words else method.id
            yield f"{about}: {rig.scene}", _results(rig)
    yield "automatic cage", _cage_results(BY_ID[DEFAULT_CAGE_METHOD])


def _results(rig: Rig) -> Iterator[_Result]:
    bound: list[Factor] = []

    def bind() -> float:
        bound.append(build_factor(rig.recipe))
        return 0.0

    def shape(answer: KnownAnswer) -> np.ndarray:
        return bound[0].solve(answer.pose, **rig.solve)[0]

    def difference(answer: KnownAnswer) -> float:
        return _largest(answer.difference(shape(answer)))

    def again() -> float:
        before = shape(rig.answers[-1])
        shape(rig.answers[0])
        return _largest(shape(rig.answers[-1]) - before)

    yield _timed("binds", 0.0, bind)
    if not bound:
        return
    for answer in rig.answers:
        yield _timed(answer.claim, answer.allowed, partial(difference, answer))
    yield _timed("the same pose again, to the last bit", 0.0, again)


def _cage_results(method: Method) -> Iterator[_Result]:
    """How many vertices of a shape are outside an automatic cage, and faces of the cage cross each other."""

    def wrong() -> float:
        points, faces = known_answers.ball(3)
        around, counts, corners, _told = automatic_cage(points, faces, faces=60, margin=0.1)
        cage = ControlPoints(around, faces=Faces(counts, corners))
        options = known_answers.values(method, True)
        report: Any = build_factor(Recipe(method, Shape(points, faces), options, cage)).report
        return float(len(report.outside) + len(report.crossing))

    yield _timed("encloses a shape", 0.0, wrong)


def _timed(claim: str, allowed: float, compute: Callable[[], float]) -> _Result:
    """What ``compute`` says about the difference, or why it fails."""
    start, difference, failure = time.perf_counter(), np.nan, ""
    try:
        difference = compute()
    except _FAILURES:
        failure = traceback.format_exc()
    return _Result(claim, time.perf_counter() - start, difference, allowed, failure)


def _largest(differences: np.ndarray) -> float:
    return float(np.abs(differences).max())


def _surroundings(blender: str) -> Iterator[str]:
    found = availability()
    now = datetime.datetime.now(datetime.timezone.utc)
    yield f"Sinew {VERSION}: check of an installation, {now:%Y-%m-%d %H:%M} UTC"
    yield ""
    yield f"system     {platform.platform()}"
    yield f"processor  {platform.machine()}, {_processor()}, {os.cpu_count()} threads"
    yield f"Blender    {blender}"
    yield f"Python     {' '.join(sys.version.split())}"
    yield f"NumPy      {np.__version__}"
    yield f"limits     {', '.join(f'{name} {value}' for name, value in limits().items()) or 'none'}"
    if found.module is None:
        yield f"module     none\n\n{found.remedy}.\n\n{_without_home(found.details)}"
    else:
        module, place = found.module, _without_home(str(found.module.__file__))
        try:
            instructions = module.instructions()
        except AttributeError:  # an earlier module of this version, which Blender keeps until it is closed
            instructions = "an earlier build; restart Blender"
        yield f"module     {module.__version__}, {instructions}, {place}"


def _processor() -> str:
    """Its name, as far as this system tells without starting a program."""
    try:
        lines = Path("/proc/cpuinfo").read_text(encoding="utf-8", errors="replace").splitlines()
    except OSError:
        lines = []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or "of an unknown name"


def _without_home(text: str) -> str:
    """A report is shown to strangers: the folder of the user, whose name often tells who it is, becomes ~."""
    return text.replace(str(Path.home()), "~")

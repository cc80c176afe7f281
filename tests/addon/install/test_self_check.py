# SPDX-License-Identifier: GPL-3.0-or-later
"""The check of an installation: it asks every method, and shows a module that gives wrong answers."""

import dataclasses
import inspect
import io
import re
from pathlib import Path

import numpy as np
import pytest

from sinew.core.methods import BY_ID, METHODS, Choice, Control, Reproduced


def checked(backend) -> tuple[object, str]:
    """What a check found, and its report."""
    report = io.StringIO()
    found = backend.check_installation(report, "a test", "report.txt")
    assert backend.last_check() == found
    return found, report.getvalue()


def parts(text: str) -> dict[str, list[str]]:
    """The lines of the answers by their heading, the method and its options."""
    blocks = [block.splitlines() for block in text.split("\n\n")]
    return {lines[0]: lines[1:] for lines in blocks if lines[1:] and lines[1].startswith("  ")}


def break_methods(backend, monkeypatch: pytest.MonkeyPatch) -> None:
    """Surface methods return what is no number, space methods what is wrong by a four-thousandth."""
    module = backend.availability().module
    solve = module.SurfaceMethod.solve

    def no_number(*args: object, **options: object) -> tuple:
        shape, report = solve(*args, **options)
        return shape * np.nan, report

    monkeypatch.setattr(module.SurfaceMethod, "solve", no_number)
    for owner in filter(inspect.isclass, vars(module).values()):
        for name in {"warp", "warp_poses"} & vars(owner).keys():
            right = getattr(owner, name)
            monkeypatch.setattr(
                owner, name, lambda *args, right=right, **options: right(*args, **options) + 1e-3
            )


def test_every_answer_of_every_method_is_right(backend):
    found, text = checked(backend)
    assert found.is_right, text
    assert found.summary == f"All {found.asked} known answers are right"
    assert text.count("  right  ") == found.asked
    assert "WRONG" not in text
    asked = parts(text)
    for method in METHODS:
        mine = {heading: lines for heading, lines in asked.items() if re.match(rf"{method.id}[,:]", heading)}
        answers = "\n".join(line for lines in mine.values() for line in lines)
        assert "binds" in answers
        assert "rest " in answers
        for kind in (Reproduced.TRANSLATIONS, method.reproduces)[method.reproduces is Reproduced.REST :]:
            assert kind.value in answers
        for parameter in (one for one in method.parameters if isinstance(one, Choice)):
            others = [f"{parameter.id}={value}:" for value, *_words in parameter.items]
            assert any(other in heading for other in others for heading in mine), parameter.id
    assert "automatic cage" in asked
    numpy = f"NumPy      {np.__version__}"
    for word in ("system ", "processor ", "Blender    a test", "Python     3.", numpy):
        assert word in text
    module = backend.availability().module
    assert f"{module.__version__}, {module.instructions()}," in text
    assert str(Path.home()) not in text


def test_wrong_answers_are_shown_for_every_method(backend, monkeypatch: pytest.MonkeyPatch):
    break_methods(backend, monkeypatch)
    found, text = checked(backend)
    assert not found.is_right
    assert found.summary == f"{found.wrong} of {found.asked} known answers are wrong"
    for heading, lines in parts(text).items():
        assert heading == "automatic cage" or any("WRONG" in line for line in lines), text


def test_a_method_that_fails_stops_no_other(backend, monkeypatch: pytest.MonkeyPatch):
    module, last = backend.availability().module, METHODS[-1]  # no other method is put around it

    def refuse(*_args: object, **_options: object) -> None:
        raise RuntimeError("vector::_M_range_check")

    monkeypatch.setattr(module, last.native, refuse)
    found, text = checked(backend)
    assert "RuntimeError: vector::_M_range_check" in text
    assert "Traceback" in text
    assert str(Path.home()) not in text
    for heading, lines in parts(text).items():
        failed = re.match(rf"{last.id}[,:]", heading) is not None
        assert any("WRONG" in line for line in lines) == failed
    assert 0 < found.wrong < found.asked


def test_an_earlier_module_of_the_same_version_is_named(backend, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.delattr(backend.availability().module, "instructions")
    found, text = checked(backend)
    assert found.is_right, text
    assert "an earlier build; restart Blender" in text


def test_a_kind_of_control_of_points_is_asked_what_its_method_promises(backend):
    row = dataclasses.replace(BY_ID["mean_value"], control=Control.POINTS, reproduces=Reproduced.SIMILARITIES)
    rigs = list(backend.known_answers.rigs(row))
    assert {words for words, _rig in rigs} == {
        "",
        "precision=double",
        "smooth=automatic",
        "smooth=levels",
    }
    for _words, rig in rigs:
        assert len(rig.recipe.control.points) == 6
        assert [answer.claim for answer in rig.answers] == [
            "rest",
            "translations",
            "rigid motions",
            "similarities",
        ]


def test_without_a_module_the_report_says_why(backend, monkeypatch: pytest.MonkeyPatch):
    missing = backend.Availability(None, "Install a wheel", "Traceback: no such file")
    monkeypatch.setattr(backend.self_check, "availability", lambda: missing)
    found, text = checked(backend)
    assert not found.is_right
    assert "Install a wheel." in text
    assert "no such file" in text
    assert found.summary in text

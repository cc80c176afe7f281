# SPDX-License-Identifier: GPL-3.0-or-later
"""The tasks of artists, and the words that find a method."""

import struct
from pathlib import Path

import pytest

from sinew.core import labels, tasks
from sinew.core.labels import Names
from sinew.core.methods import BY_ID, METHODS

ROOT = Path(__file__).parents[2]
MANUAL = ROOT / "docs/manual"
PICTURES = ROOT / "addon/pictures"
JOINT = "joint"  # which corrects by a method of another task
# What other programs call it, and the task that does it.
OTHER_NAMES = {
    "joint": ("corrective shape", "delta mush"),
    "cage": ("wrap", "mesh deform"),
    "parts": ("proportional", "soft selection", "puppet pin"),
    "clay": ("soft modification", "taper"),
    "limb": ("cluster", "bulge", "muscle"),
    "box": ("squash and stretch", "ffd box"),
    "morph": ("blend shape",),
    "animation": ("jiggle",),
    "figure": ("skin weights",),
}


@pytest.fixture(autouse=True)
def names():
    yield
    labels.choose(Names.TASKS)


def test_each_method_is_in_one_task():
    listed = [method for task in tasks.TASKS if task.id != JOINT for method in task.methods]
    assert sorted(listed) == sorted(BY_ID)
    for method in METHODS:
        assert tasks.task_of(method).id != JOINT


def test_twelve_tasks_and_each_recommends_one_method():
    assert len(tasks.TASKS) == 12
    assert len({task.id for task in tasks.TASKS}) == len({task.label for task in tasks.TASKS}) == 12
    for task in tasks.TASKS:
        assert (task.recommended is None) == (task.id == "once")
        assert not any(method.wraps for method in task.more)
        assert task.recommended not in task.more


@pytest.mark.parametrize("task", tasks.TASKS, ids=lambda task: task.id)
def test_a_task_says_what_it_is_for_and_has_a_page(task: tasks.Task):
    assert task.purpose
    assert not task.purpose.endswith(".")
    page = " ".join((MANUAL / f"{task.page}.md").read_text(encoding="utf-8").split())
    for method in map(BY_ID.get, task.methods):
        assert all(words in page for words in (f"../methods/{method.id}.md", method.label, method.known_as))
    assert bool(task.deformer) == bool(task.methods)


@pytest.mark.parametrize("method", METHODS, ids=lambda method: method.id)
def test_every_word_of_a_method_finds_it_among_the_first_eight(method):
    for words in (*method.search.split(), method.search, method.label, method.known_as):
        hits = [hit for _task, hit in tasks.found(words)]
        assert method in hits[:8], words


@pytest.mark.parametrize(
    ("words", "task"), [(words, task) for task, names in OTHER_NAMES.items() for words in names]
)
def test_the_names_of_other_programs_lead_to_a_task(words: str, task: str):
    (wanted,) = [row for row in tasks.TASKS if row.id == task]
    hits = tasks.found(words)
    assert wanted.recommended in [method for _task, method in hits[:8]]
    if task == JOINT:
        assert hits[0][0] is wanted


def test_each_method_and_task_has_a_picture_and_together_they_are_small():
    shown = {*BY_ID, *(task.shown_as for task in tasks.TASKS)}
    found = {path.stem: path.read_bytes() for path in PICTURES.glob("*.png")}
    assert sorted(found) == sorted(shown)
    assert {data[16:24] for data in found.values()} == {struct.pack(">II", 128, 128)}, "width and height"
    assert sum(map(len, found.values())) <= 700_000


def test_the_manual_shows_the_tasks():
    shown = (MANUAL / "start.md").read_text(encoding="utf-8")
    for task in tasks.TASKS:
        cell = f"images/task-{task.shown_as}.jpg)<br>{task.label}]({task.page}.md)<br>{task.purpose} |"
        assert cell in shown


def test_a_task_without_a_method_is_found_and_nonsense_finds_nothing():
    assert ("once", None) in [(task.id, method) for task, method in tasks.found("once")]
    assert tasks.found("xylophone") == ()
    assert tasks.found("limb xylophone") == (), "all words count"
    assert len(tasks.found("")) == len(METHODS) + 1


def test_the_choice_of_names_turns_labels_round():
    arap = BY_ID["arap"]
    assert (labels.label_of(arap), labels.known_as(arap)) == ("Natural Bend", "As-Rigid-As-Possible")
    items = labels.items_of(METHODS)
    by_task = items()
    labels.choose(Names.LITERATURE)
    assert (labels.label_of(arap), labels.known_as(arap)) == ("As-Rigid-As-Possible", "Natural Bend")
    assert "Known as Natural Bend" in labels.tooltip_of(arap)
    assert labels.tooltip_of(BY_ID["wires"]) == BY_ID["wires"].summary, "both names are one"
    in_literature = items()
    assert in_literature is items(), "Blender does not copy the texts"
    assert [(item[0], item[4]) for item in by_task] == [(item[0], item[4]) for item in in_literature]
    assert [item[1] for item in by_task] != [item[1] for item in in_literature]

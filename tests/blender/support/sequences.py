# SPDX-License-Identifier: GPL-3.0-or-later
"""What random sequences have in common: an empty file, a folder, a log of errors, and how many there are.

``SINEW_RANDOM_SEED=7`` takes other sequences, ``SINEW_RANDOM_SEQUENCES=20`` fewer;
``SINEW_RANDOM_SHRINK=0`` reports the first failure as it is.
"""

import os
import tempfile
from contextlib import nullcontext
from pathlib import Path

import bpy
from error_log import ErrorLog
from hypothesis import HealthCheck, Phase, seed, settings
from hypothesis.stateful import RuleBasedStateMachine, precondition, rule, run_state_machine_as_test
from inside import evaluated_by, settle
from rigs.rig import new_file

SEED = os.environ.get("SINEW_RANDOM_SEED")
SEQUENCES = int(os.environ.get("SINEW_RANDOM_SEQUENCES", "200"))
SHRINK = os.environ.get("SINEW_RANDOM_SHRINK", "1") == "1"  # minutes of it, where a sequence is long
MOST_UNDO = 25  # steps we go back; Blender keeps 32


class Sequence(RuleBasedStateMachine):
    """One sequence of what an artist does; after each step ``compare`` looks at the shapes."""

    checked = 0  # shapes compared

    def __init__(self) -> None:
        super().__init__()
        self.moments: list[dict] = []  # what ``memory`` was at each undo step
        self.now = -1
        self.memory: dict = {}  # what an oracle has to know of the steps before
        new_file()
        self.error_log = ErrorLog()
        self._folder = tempfile.TemporaryDirectory()
        self.folder = Path(self._folder.name)

    def teardown(self) -> None:
        self.error_log.close()
        self._folder.cleanup()

    @property
    def in_object_mode(self) -> bool:
        return bpy.context.mode == "OBJECT"

    def done(self, push: bool = True, solved: bool = True) -> None:
        """The undo step, the evaluation, and a quiet moment, in which nothing may be said.

        In a window the step is saved before it is ``solved``; called from Python, it is solved first.
        """
        if push:
            with nullcontext() if solved else evaluated_by(None):
                bpy.ops.ed.undo_push(message="step")
            for obj in () if solved else self.targets:
                obj.update_tag(refresh={"OBJECT"})
            del self.moments[self.now + 1 :]
            self.moments = self.moments[-MOST_UNDO:]
            self.moments.append({})
            self.now = len(self.moments) - 1
        settle()
        self.error_log.check()
        self.compare()
        self.moments[self.now] = dict(self.memory)

    def start_over(self) -> None:
        """A file was opened: no undo beyond it."""
        self.moments, self.now = [], -1
        self.done()

    @precondition(lambda self: self.now > 0)
    @rule()
    def undo(self):
        self.now -= 1
        bpy.ops.ed.undo()
        self.recall()

    @precondition(lambda self: self.now + 1 < len(self.moments))
    @rule()
    def redo(self):
        self.now += 1
        bpy.ops.ed.redo()
        self.recall()

    def recall(self) -> None:
        self.memory.clear()
        self.memory.update(self.moments[self.now])
        self.done(push=False)


def run_sequences(machine: type[Sequence], sequences: int, steps: int) -> None:
    """The same ones in each run, unless a seed is given."""
    machine.checked = 0
    run_state_machine_as_test(
        machine if SEED is None else seed(int(SEED))(machine),
        settings=settings(
            max_examples=sequences,
            stateful_step_count=steps,
            derandomize=SEED is None,
            database=None,
            deadline=None,
            phases=(Phase.generate, Phase.shrink) if SHRINK else (Phase.generate,),
            suppress_health_check=list(HealthCheck),
            report_multiple_bugs=False,
        ),
    )

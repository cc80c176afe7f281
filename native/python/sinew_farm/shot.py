# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes the chunks of a shot on a Dask cluster, and joins them.

A chunk is a task, a task is one start of Blender, and a finished chunk is a file with a manifest in the
folder that all machines see. So nothing that the cluster loses is lost: what has no valid manifest is baked
again, by another try, another worker, or another run of the same command.
"""

import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from distributed import Client, Future, as_completed, get_worker

from . import atom
from .atom import DONE, FINAL, SPACE, End
from .clusters import Size
from .errors import FarmError

TOPIC = "sinew"
LOST = ("cancelled", "lost")  # what tasks are after their scheduler has gone
SECONDS_BETWEEN_FRAMES = 1.0  # of the lines about frames that a worker sends, for the scheduler's sake
STAYS = "what is baked stays, and the same command goes on from there"
Work = tuple[str, ...]  # bake or join, and its words


@dataclass(frozen=True)
class Shot:
    """What to bake: the words of the bake, and the frames of a chunk."""

    file: Path
    frames: range
    objects: str  # names, separated by commas
    format: str
    out: Path
    blender: str
    chunk: int

    def bakes(self, size: Size) -> dict[str, Work]:
        """The words for each chunk, by its frames."""
        limits = ["--threads", str(size.threads)] if size.threads else []
        limits += ["--memory", f"{size.memory:g}"] if size.memory else []
        return {
            chunk: ("bake", str(self.file), "--frames", chunk, *self._words(), *limits)
            for chunk in atom.chunks_of(self.frames, self.chunk)
        }

    def join(self) -> dict[str, Work]:
        (whole,) = atom.chunks_of(self.frames, len(self.frames))
        return {"join": ("join", str(self.out), "--frames", whole, *self._words())}

    def _words(self) -> list[str]:
        return ["--objects", self.objects, "--format", self.format, "--out", str(self.out)]


@dataclass(frozen=True)
class Engine:
    """How to reach a cluster, what to do with progress, and how often to try.

    ``connect`` gives a client, and after a scheduler was lost another one. ``wait`` are the seconds in which
    a scheduler with a worker has to come. ``tries`` is how often a chunk may crash, or find no space.
    """

    connect: Callable[[], Client]
    tell: Callable[[dict], None]
    wait: float = 60.0
    tries: int = 3

    def bake(self, shot: Shot, size: Size) -> None:
        """Bakes all chunks, then joins them. Raises FarmError with the exit code of what ended it."""
        self.complete(shot.blender, shot.bakes(size))
        self.complete(shot.blender, shot.join())

    def complete(self, blender: str, work: Mapping[str, Work]) -> None:
        """Does all of the work, on as many clients as it takes."""
        left = dict.fromkeys(work, 0)  # how often each was tried
        while left:
            with self._client() as client:
                client.subscribe_topic(TOPIC, lambda event: self.tell(event[1]))
                _Pass(client, self, blender, work, left).run()
            if left:
                self.tell({"sinew": "scheduler lost", "left": len(left)})

    def _client(self) -> Client:
        """A client of a scheduler that has a worker."""
        until = time.monotonic() + self.wait
        while True:
            client = None
            try:
                client = self.connect()
                client.wait_for_workers(1, timeout=max(1.0, until - time.monotonic()))
                return client
            except (OSError, TimeoutError) as error:
                if client:
                    client.close()
                if time.monotonic() > until:
                    what = f"no scheduler with a worker within {self.wait:g} seconds ({error})"
                    raise FarmError(f"{what}; {STAYS}") from None
                time.sleep(1.0)


class _Pass:
    """What is left of some work, on one client, until all is done or its scheduler has gone."""

    def __init__(
        self, client: Client, engine: Engine, blender: str, work: Mapping[str, Work], left: dict[str, int]
    ) -> None:
        self.client, self.engine, self.blender, self.work, self.left = client, engine, blender, work, left
        self.full: set[str] = set()  # workers without space, which others precede

    def run(self) -> None:
        tasks = {self._submit(name): name for name in self.left}  # kept, as the dashboard counts them
        ended = as_completed(list(tasks), raise_errors=False)
        for task in ended:
            name = tasks[task]
            if task.status in LOST:
                return
            end, worker = self._end_of(task)
            if end.code == DONE:
                del self.left[name]
                self.engine.tell({"sinew": "ended", "part": name, "worker": worker, "left": len(self.left)})
                continue
            self.left[name] += 1
            self.engine.tell({"sinew": "failed", "part": name, "worker": worker, "message": end.message})
            if end.code in FINAL or self.left[name] >= self.engine.tries:
                self.client.cancel(list(tasks))
                where = "join" if name == "join" else f"frames {name}"
                raise FarmError(f"{where}: {end.message}", end.code)
            if end.code == SPACE:
                self.full.add(worker)
            again = self._submit(name)
            tasks[again] = name
            ended.add(again)

    def _submit(self, name: str) -> Future:
        others = set(self.client.scheduler_info(n_workers=-1)["workers"]) - self.full if self.full else set()
        kept = {"workers": sorted(others), "allow_other_workers": True} if others else {}
        label = f"{self.work[name][0]}-{name}-try-{self.left[name] + 1}-{time.monotonic_ns()}"
        return self.client.submit(start, self.blender, self.work[name], key=label, pure=False, **kept)

    def _end_of(self, task: Future) -> tuple[End, str]:
        if task.status == "finished":
            return task.result()
        return End(atom.CRASHED, str(task.exception())), ""  # its workers died


def start(blender: str, work: Sequence[str]) -> tuple[End, str]:
    """Runs one bake or join on a worker, and sends its progress. Returns its end and the worker's address."""
    worker, last = get_worker(), 0.0

    def tell(event: dict) -> None:
        nonlocal last
        if event["sinew"] != "frame" or time.monotonic() > last + SECONDS_BETWEEN_FRAMES:
            last = time.monotonic()
            worker.log_event(TOPIC, event | {"worker": worker.address})

    return atom.run(blender, work[0], work[1:], tell), worker.address

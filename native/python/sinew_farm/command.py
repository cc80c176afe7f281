# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes shots of Sinew on many machines, by Dask, Flamenco or Open Job Description."""

import argparse
import json
import sys
from math import ceil
from pathlib import Path

from . import job
from .atom import WORDS, frames_of
from .errors import FarmError


def main(words: list[str] | None = None) -> None:
    """The command ``sinew-farm``. It ends with 0, with the exit code of the bake, or with 1 after crashes."""
    parser = argparse.ArgumentParser(prog="sinew-farm", description=__doc__)
    engines = parser.add_subparsers(dest="engine", required=True)
    _dask_words(engines.add_parser("dask", help="bake a shot on a Dask cluster, and join its chunks"))
    engines.add_parser("flamenco", help="print the job type script for Flamenco")
    engines.add_parser("openjd", help="print the job template for Open Job Description and Deadline Cloud")
    asked = parser.parse_args(words)
    if asked.engine != "dask":
        sys.stdout.write(job.flamenco() if asked.engine == "flamenco" else job.openjd())
        return
    try:
        _bake(asked)
    except ModuleNotFoundError as error:
        if error.name not in ("dask", "distributed"):
            raise
        parser.exit(WORDS, "sinew-farm dask needs Dask: pip install sinew_native[farm]\n")
    except FarmError as error:
        parser.exit(error.code, f"{error}\n")
    except KeyboardInterrupt:
        parser.exit(130, "Stopped. What is baked stays, and the same command goes on from there.\n")


def _dask_words(parser: argparse.ArgumentParser) -> None:
    add = parser.add_argument
    add("shot", type=Path, help="the .blend file, where all machines see it")
    add("--frames", type=_frames, required=True, help="7, 1-240 or 1-240x2")
    add("--objects", required=True, help="names, separated by commas")
    add("--format", choices=("pc2", "mdd", "alembic", "shape_keys"), default="pc2")
    add("--out", type=Path, required=True, help="a folder that all machines see")
    add("--blender", default="blender", help="the command line of Blender on the workers")
    add("--chunk", type=_count, help="frames of one start of Blender; without it, two chunks for each worker")
    add(
        "--cluster",
        default="local",
        help="local, ssh, slurm, pbs, sge, lsf, htcondor, oar, moab, or MODULE:CLASS",
    )
    add("--scheduler", help="the address of a Dask scheduler that runs, instead of a new cluster")
    add("--hosts", default="", help="of --cluster ssh: SCHEDULER,WORKER,WORKER...")
    add("--workers", type=_count, default=2)
    add("--threads", type=_count, help="of each worker; without it, here, the cores in equal parts")
    add("--memory", type=float, help="of each worker, in GB; without it, here, the memory in equal parts")
    add("--tries", type=_count, default=3, help="how often a chunk may crash")
    add("--wait", type=float, default=60.0, help="seconds in which a lost scheduler has to come back")
    add("--dashboard", default="127.0.0.1:8787", help="the address of the dashboard of --cluster local")
    add("--json", action="store_true", help="print progress as JSON, a line for each event")


def _bake(asked: argparse.Namespace) -> None:
    from distributed import Client

    from . import clusters, shot

    size = clusters.Size(asked.workers, asked.threads, asked.memory)
    cluster = None
    if not asked.scheduler:
        size = size.of_this_machine() if asked.cluster == "local" else size
        cluster = clusters.start(asked.cluster, size, asked.hosts, asked.dashboard)
    try:
        chunk = asked.chunk or ceil(len(asked.frames) / (2 * asked.workers))
        file, out = asked.shot.resolve(), asked.out.resolve()
        wanted = shot.Shot(file, asked.frames, asked.objects, asked.format, out, asked.blender, chunk)
        tell = _print_json if asked.json else _print_sentence
        tell({"sinew": "cluster", **vars(size), "dashboard": getattr(cluster, "dashboard_link", "")})
        target = cluster or asked.scheduler
        connect = lambda: Client(target, timeout=asked.wait)  # noqa: E731
        shot.Engine(connect, tell, asked.wait, asked.tries).bake(wanted, size)
    finally:
        if cluster:
            clusters.end(cluster)


def _frames(text: str) -> range:
    try:
        return frames_of(text)
    except ValueError as error:
        raise argparse.ArgumentTypeError(str(error)) from None


def _count(text: str) -> int:
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text} is no number from 1 on")
    return int(text)


def _print_json(event: dict) -> None:
    print(json.dumps(event), flush=True)


SENTENCES = {
    "cluster": "{workers} workers, each with {threads} threads and {memory} GB. Dashboard: {dashboard}",
    "ended": "{part} is there, by {worker}; {left} left",
    "failed": "{part} failed on {worker}: {message}",
    "scheduler lost": "The scheduler has gone, with {left} left; waiting for it",
}


def _print_sentence(event: dict) -> None:
    if event["sinew"] in SENTENCES:
        print(SENTENCES[event["sinew"]].format_map(event), flush=True)

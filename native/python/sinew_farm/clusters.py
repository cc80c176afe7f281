# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts the clusters that Dask knows, with what each worker may use."""

import importlib
import logging
import os
from contextlib import suppress
from dataclasses import dataclass

import dask.config
import psutil
from distributed.deploy import Cluster
from distributed.system import MEMORY_LIMIT

from .errors import FarmError

# Other classes are named as "module:Class".
CLUSTERS = {
    "local": "distributed:LocalCluster",
    "ssh": "distributed:SSHCluster",
    **{
        name.lower(): f"dask_jobqueue:{name}Cluster"
        for name in ("SLURM", "PBS", "SGE", "LSF", "HTCondor", "OAR", "Moab")
    },
}


@dataclass(frozen=True)
class Size:
    """What a cluster has: workers, and for each of them processor threads and memory in GB.

    None leaves a number to Dask's own configuration, or else to what the machine of a worker has.
    """

    workers: int
    threads: int | None = None
    memory: float | None = None

    def of_this_machine(self) -> "Size":
        """The cores and the memory of this machine in equal parts, where nothing else is stated."""
        cores = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
        share = round(MEMORY_LIMIT / 1e9 / self.workers, 2)
        return Size(self.workers, self.threads or max(1, cores // self.workers), self.memory or share)


def start(kind: str, size: Size, hosts: str = "", dashboard: str = "127.0.0.1:8787") -> Cluster:
    """A cluster of workers that each run one bake at a time.

    ``kind`` is a key of ``CLUSTERS`` or "module:Class". ``hosts`` are those of "ssh", separated by commas:
    the first one runs the scheduler. Raises FarmError for an unknown kind, or one that is not installed.
    """
    made = _class(kind)
    memory = {"memory": f"{size.memory}GB"} if size.memory else {}
    if kind == "local":
        limits = {"memory_limit": memory["memory"]} if memory else {}
        return made(
            n_workers=size.workers,
            threads_per_worker=1,
            processes=False,
            protocol="tcp://",
            host="127.0.0.1",
            dashboard_address=dashboard,
            silence_logs=logging.ERROR,
            **limits,
        )
    if kind == "ssh":
        names = [name for name in hosts.split(",") if name]
        if not names:
            raise FarmError("--cluster ssh needs --hosts SCHEDULER,WORKER,WORKER...")
        limits = {"memory_limit": memory["memory"]} if memory else {}
        logging.getLogger("distributed.deploy.ssh").setLevel(logging.ERROR)  # what other machines print
        try:
            return made(names, worker_options={"nthreads": 1, **limits})
        except (OSError, RuntimeError) as error:
            raise FarmError(f"--cluster ssh: {error}") from None
    section = getattr(made, "config_name", kind)
    further = dask.config.get(f"jobqueue.{section}.worker-extra-args", None) or []
    cores = {"cores": size.threads} if size.threads else {}
    cluster = made(processes=1, worker_extra_args=[*further, "--nthreads", "1"], **cores, **memory)
    cluster.scale(size.workers)
    return cluster


def end(cluster: Cluster) -> None:
    """Ends a cluster, with the bakes of workers that are threads of this process."""
    for bake in psutil.Process().children(recursive=True):
        with suppress(psutil.NoSuchProcess):
            bake.kill()
    cluster.close()


def _class(kind: str) -> type[Cluster]:
    module, _, name = CLUSTERS.get(kind, kind).partition(":")
    if not name:
        raise FarmError(f"--cluster {kind}: known are {', '.join(CLUSTERS)}, and any MODULE:CLASS")
    try:
        if kind == "ssh":
            importlib.import_module("asyncssh")  # which Dask would miss later
        return getattr(importlib.import_module(module), name)
    except ModuleNotFoundError as error:
        package = str(error.name).partition(".")[0].replace("_", "-")
        raise FarmError(f"--cluster {kind} needs a package: pip install {package}") from None
    except AttributeError:
        raise FarmError(f"--cluster {kind}: {module} has no class {name}") from None

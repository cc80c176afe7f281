# SPDX-License-Identifier: GPL-3.0-or-later
"""Moves a selection in Edit Mode so that the surface around follows it, once and without a deformer.

Only the part of the mesh that may move is passed to the native module, with as many rings of fixed vertices
around it as the energies of the methods need.
"""

import time
from typing import Any

import numpy as np
from bpy.types import Object

from ...backend import Factor, Progress, Recipe, Regions, Shape, build_factor
from ...core.errors import ConstraintError
from ...core.geometry import frames
from ...core.methods import Method
from ..controls.handles.poses import IDENTITY
from ..evaluation import binding, drag
from ..state.background import Work
from ..state.sessions import FIRST_STEPS
from .patch import Patch, Region

NOTHING_FREE = "Nothing around the selection is free to follow - only the selection moves"


class Grab:
    """The selection of a mesh in Edit Mode as a handle, and what follows it.

    Call ``follow`` with a radius, then ``show`` for each motion. ``restore`` puts everything back.
    """

    def __init__(self, obj: Object, method: Method) -> None:
        binding.require_backend()
        self._method = method
        self._patch = Patch(obj)
        self._region: Region | None = None
        self._factor: Factor | None = None  # of the region, if it needs one and has it already
        self._work: Work | None = None
        self._final: Work | None = None
        self._start: np.ndarray | None = None
        self._budget = FIRST_STEPS
        self.settled = True  # whether the shape shown is the exact one for its motion

    @property
    def selection(self) -> np.ndarray:
        """The selected vertices in the world at rest, (s, 3)."""
        return self._patch.selection

    @property
    def lost(self) -> int:
        """How many vertices have invalid coordinates."""
        return self._patch.lost

    @property
    def radius(self) -> float | None:
        """The radius that is bound; None until the first one is."""
        return None if self._region is None else self._region.radius

    @property
    def is_binding(self) -> bool:
        """Whether a thread binds for another radius."""
        return self._work is not None

    @property
    def moves_alone(self) -> bool:
        """Whether the selection moves alone, because nothing is free to follow it."""
        return self._region is not None and len(self._region.free) == 0

    @property
    def job(self) -> Work | None:
        """A bind, or an exact solve, in a thread."""
        return self._work or self._final

    # What follows

    def follow(self, radius: float, wait: bool = True) -> None:
        """Let what lies within ``radius`` follow, in world units over the surface; infinite: all connected.

        Without ``wait`` a large part is bound in a thread: see ``job`` and ``collect``.
        """
        self._abandon()
        region = self._patch.region(radius)
        if len(region.free) == 0 or len(region.fixed) == 0:  # bound when a motion asks for it
            self._take(region, None)
        elif wait or not binding.takes_long(self._recipe(region)):
            self._take(region, self._bind(region, None))
        else:
            self._work = Work(lambda progress: self._bind(region, progress), region)

    def collect(self) -> bool:
        """Take in a bind that has ended; returns whether there was one. The next ``show`` uses it."""
        if self._work is None or not self._work.done:
            return False
        done, self._work = self._work, None
        if done.error is not None:
            raise done.error
        self._take(done.subject, done.result)
        return True

    def _is_bound(self, region: Region, wait: bool) -> bool:
        """Whether the region has its factor, or needs none. False while a thread builds it."""
        if self._factor is not None or len(region.free) == 0:
            return True
        if wait or not binding.takes_long(self._recipe(region)):
            self._factor = self._bind(region, None)
            return True
        if self._work is None:
            self._work = Work(lambda progress: self._bind(region, progress), region)
        return False

    def _abandon(self) -> None:
        for work in (self._work, self._final):
            if work is not None:
                work.cancel()
        self._work = self._final = None

    def _take(self, region: Region, factor: Factor | None) -> None:
        self._region, self._factor = region, factor
        self._start, self._budget = None, FIRST_STEPS

    def _recipe(self, region: Region) -> Recipe:
        options = {row.id: row.native_default for row in self._method.parameters if row.rebinds}
        handles = [places for places in (region.handle, region.fixed) if len(places)]
        target = Shape(region.rest, region.faces)
        held = Regions(handles, [None] * len(handles), free_parts="follow")
        return Recipe(self._method, target, options, held)

    def _bind(self, region: Region, progress: Progress | None) -> Factor:
        return build_factor(self._recipe(region), progress)

    # How it moves

    def _followed(self) -> Region:
        """What follows the selection. A motion needs it, so ``follow`` comes before every motion."""
        if self._region is None:
            raise ConstraintError("Nothing follows the selection yet - ask for a radius first")
        return self._region

    def show(self, obj: Object, motion: np.ndarray, preview: bool = False) -> None:
        """Move the selection by a motion (4, 4) in the world, and the surface with it.

        A ``preview`` takes little time, and may not be exact: see ``settled``.
        """
        self._drop_final()
        pose = self._pose(motion)
        region, followed = self._followed(), None
        self.settled = True
        if region.rides_along(pose):
            followed = frames.transformed(pose, region.rest)
        elif not self._is_bound(region, wait=not preview):
            return
        elif self._factor is not None:
            options = self._options()
            early = preview and self._method.iterative
            if early:
                options["max_iterations"] = min(self._budget, options.get("max_iterations", self._budget))
                options["start"] = self._start
            begin = time.perf_counter()
            followed, report = self._factor.solve(self._poses(region, pose), **options)
            self._start = followed
            if early and report is not None:
                self.settled = report.converged
                self._spend(report.iterations, time.perf_counter() - begin)
        self._write(obj, region, pose, followed, final=not preview)

    def settle(self, obj: Object, motion: np.ndarray, wait: bool = True) -> bool:
        """Show the exact shape, which depends on the motion alone; False while a thread computes it."""
        region, pose = self._followed(), self._pose(motion)
        takes = binding.solve_seconds(len(region.members))
        heavy = self._method.iterative and binding.may_wait(takes)
        if wait or not heavy or len(region.free) == 0 or region.rides_along(pose):
            self.show(obj, motion)
            return True
        if not self._is_bound(region, wait):
            return False
        if self._final is None:
            factor, poses, options = self._factor, self._poses(region, pose), self._options()
            self._final = Work(lambda progress: factor.solve(poses, progress=progress, **options))
        if not self._final.done:
            return False
        done, self._final = self._final, None
        if done.error is not None:
            raise done.error
        self._write(obj, region, pose, done.result[0])
        self.settled = True
        return True

    def restore(self, obj: Object) -> None:
        """Put every vertex back where it was, bit for bit."""
        self._abandon()
        self._patch.restore(obj)

    def _drop_final(self) -> None:
        if self._final is not None:
            self._final.cancel()
            self._final = None

    def _spend(self, iterations: int, seconds: float) -> None:
        """Choose as many steps per redraw as the drag budget allows for this mesh."""
        if iterations:
            self._budget = drag.affordable_steps(1000.0 * seconds / iterations)

    def _options(self) -> dict[str, Any]:
        return {row.id: row.native_default for row in self._method.parameters if not row.rebinds}

    def _pose(self, motion: np.ndarray) -> np.ndarray:
        """A motion in the world as a pose (3, 4) of the points of the patch, relative to the object.

        Where modifiers show the selection elsewhere, it moves there as the motion says.
        """
        if not np.isfinite(motion).all():
            raise ConstraintError("The motion is not a finite number - type another one")
        pose = motion.copy()
        pose[:3, 3] += motion[:3, :3] @ self._patch.origin - self._patch.origin
        surface = self._patch.surface
        return (np.linalg.inv(surface) @ pose @ surface)[:3]

    def _poses(self, region: Region, pose: np.ndarray) -> np.ndarray:
        poses = [pose] if len(region.handle) else []
        return np.array([*poses, IDENTITY] if len(region.fixed) else poses)

    def _write(
        self, obj: Object, region: Region, pose: np.ndarray, followed: np.ndarray | None, final: bool = True
    ) -> None:
        """Move the selection by its pose, the free vertices to the solution (k, 3), all others to rest."""
        goals = [frames.transformed(pose, self._patch.points[self._patch.selected])]
        if followed is not None:
            goals.append(followed[region.free])
        self._patch.write(obj, region, np.concatenate(goals), final)

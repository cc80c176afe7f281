# SPDX-License-Identifier: GPL-3.0-or-later
"""Solve what changed. Called by handlers in every evaluation, so equal inputs must cost next to nothing.

Handlers run this off the main thread in renders. It reads evaluated data from the depsgraph it is given,
and writes arrays of unchanged size; it never makes or removes a datablock.
"""

import time
from collections.abc import Iterator
from dataclasses import dataclass

import bpy
import numpy as np
from bpy.types import Depsgraph, NodesModifier, Object

from .. import compat
from ..core import status
from ..core.errors import SinewError, SolverError, TopologyChangedError
from ..core.status import Level, Status
from ..ids import Inputs
from ..mesh_io import read_incoming, write_shape
from ..properties import SinewDeformer
from . import bind, poses, regions, rig, state
from .state import Bound, Session, Shown
from .work import Work

PREVIEW_ITERATIONS = 4  # what a drag may spend a step; the answer for the same poses follows when it pauses

LINKED = "Linked: shows the last solution - make a library override to pose it here"


@dataclass
class _Census:
    """Objects that own deformers, by name and library; and whether some share a key, as copies do."""

    objects: int = -1
    owners: tuple[tuple[str, str | None], ...] = ()
    has_copies: bool = False


_census = _Census()


def forget_owners() -> None:
    """Objects may have gained or lost deformers."""
    _census.objects = -1


def owners() -> list[Object]:
    """Objects that own deformers, without copies that still share the shapes of another.

    The scan is repeated when the number of objects changes.
    """
    if _census.objects != len(bpy.data.objects):
        _take_census()
    found = [
        bpy.data.objects.get(name if library is None else (name, library)) for name, library in _census.owners
    ]
    if all(obj is not None and obj.sinew.deformers for obj in found):
        return found
    forget_owners()  # renamed, or removed while another was added
    _take_census()
    return [
        bpy.data.objects[name if library is None else (name, library)] for name, library in _census.owners
    ]


def has_copies() -> bool:
    """Some object shares the shapes of another: see ``upkeep``."""
    owners()
    return _census.has_copies


def _take_census() -> None:
    seen: set[str] = set()
    names = []
    _census.has_copies = False
    for obj in bpy.data.objects:
        keys = [deformer.uid for deformer in obj.sinew.deformers]
        if any(key in seen for key in keys):
            _census.has_copies = True
        elif keys:
            names.append((obj.name, obj.library.filepath if obj.library else None))
            if obj.library is None and any(rig.is_linked(deformer.proxy) for deformer in obj.sinew.deformers):
                _census.has_copies = True  # an override, which shows what it cannot change
        seen.update(keys)
    _census.objects, _census.owners = len(bpy.data.objects), tuple(names)


@dataclass
class _Chain:
    """What the deformers earlier in the stack leave for the next one.

    ``points`` are the positions that left the one just before, where they are known; ``broken`` says that
    an earlier one is no direct neighbour, so what enters is only known to the next evaluation.
    """

    points: np.ndarray | None = None
    broken: bool = False


def update(depsgraph: Depsgraph, preview: bool = False) -> None:
    """Solve every deformer whose inputs changed. ``preview`` spends a budget; see ``settle``."""
    if state.is_suspended():
        return
    for obj in owners():
        evaluated = obj.evaluated_get(depsgraph)
        if evaluated.is_evaluated:
            _update_object(obj, evaluated, depsgraph, preview)


def _stack(obj: Object) -> Iterator[tuple[NodesModifier, int]]:
    """Our modifiers in stack order, each with the index of its deformer."""
    by_proxy = {deformer.proxy: index for index, deformer in enumerate(obj.sinew.deformers) if deformer.proxy}
    for modifier in obj.modifiers:
        if modifier.type == "NODES":
            index = by_proxy.get(compat.modifier_input(modifier, Inputs.PROXY_VIEWPORT))
            if index is not None:
                yield modifier, index


def _is_shown(modifier: NodesModifier, mode: str) -> bool:
    return modifier.show_render if mode == "RENDER" else modifier.show_viewport


def _update_object(obj: Object, evaluated: Object, depsgraph: Depsgraph, preview: bool) -> None:
    mode = depsgraph.mode
    ours = dict(_stack(obj))
    chain = _Chain()
    for modifier in obj.modifiers:
        if not _is_shown(modifier, mode):
            continue
        index = ours.get(modifier)
        if index is None:
            chain = _Chain(broken=chain.broken or chain.points is not None)
            continue
        deformer = obj.sinew.deformers[index]
        settings = _evaluated_settings(evaluated, index, deformer)
        if mode == "VIEWPORT" and compat.modifier_input(modifier, Inputs.MASK) != deformer.mask_group:
            compat.set_modifier_input(modifier, Inputs.MASK, deformer.mask_group)
            obj.update_tag()
        try:
            chain = _update_deformer(obj, evaluated, depsgraph, deformer, settings, chain, preview)
        except TopologyChangedError as error:  # the node group already shows rest: its counts differ
            state.of(deformer.uid).view(mode).signature = ()
            chain = _Chain(broken=chain.broken)
            _fail(deformer, error, mode)
        except SinewError as error:
            rig.show_rest(deformer, mode)
            chain = _Chain(broken=chain.broken)
            _fail(deformer, error, mode)


def _fail(deformer: SinewDeformer, error: SinewError, mode: str) -> None:
    if mode == "VIEWPORT":
        status.fail(deformer.uid, error)
    else:
        _note(deformer, f"In the render: {error}")


def _evaluated_settings(evaluated: Object, index: int, deformer: SinewDeformer) -> SinewDeformer:
    """The deformer with its animated values, or the original where Blender has not copied it yet."""
    copies = evaluated.sinew.deformers
    if index < len(copies) and copies[index].uid == deformer.uid:
        return copies[index]
    return deformer


def _update_deformer(
    obj: Object,
    evaluated: Object,
    depsgraph: Depsgraph,
    deformer: SinewDeformer,
    settings: SinewDeformer,
    chain: _Chain,
    preview: bool,
) -> _Chain:
    mode = depsgraph.mode
    session = state.of(deformer.uid)
    with session.lock:
        if not settings.live:
            return _after(session, mode, settings)
        if rig.is_linked(deformer.proxy):
            status.put(deformer.uid, Status(Level.INFO, LINKED))
            return _Chain(broken=True)
        if not deformer.is_bound or not regions.has_constraints(settings):
            rig.show_rest(deformer, mode)
            return _Chain(broken=chain.broken)
        bound = bind.ensure(session, deformer, settings, wait=mode == "RENDER" or bpy.app.background)
        if bound is None:
            if session.failed is not None:
                rig.show_rest(deformer, mode)
            return _Chain(broken=chain.broken)
        incoming, displacement = _incoming(obj, evaluated, deformer, bound, session.view(mode), chain, mode)
        _solve(deformer, settings, depsgraph, obj, session, bound, incoming, displacement, preview)
        return _after(session, mode, settings)


def _incoming(
    obj: Object,
    evaluated: Object,
    deformer: SinewDeformer,
    bound: Bound,
    shown: Shown,
    chain: _Chain,
    mode: str,
) -> tuple[np.ndarray | None, bool]:
    """The incoming positions float32 (n, 3), None for rest; and whether only displacements can be shown."""
    expected = len(bound.rest.points)
    if chain.broken:
        _note(deformer, "Another modifier stands between two deformers: this one adds its displacement")
        return None, True
    if chain.points is not None:
        if len(chain.points) != expected:
            raise TopologyChangedError("Topology changed - Rebind")
        return chain.points, False
    found = read_incoming(evaluated.data, *rig.attribute_names(deformer.uid), expected)
    if found.points is not None:
        _note(deformer, "")
        return (None if np.array_equal(found.points, bound.rest.compact) else found.points), False
    if found.count < 0 and obj.mode == "EDIT":
        return shown.incoming, False
    if found.count > expected or (0 <= found.count < expected and _is_last(obj, deformer, mode)):
        raise TopologyChangedError("Topology changed - Rebind")
    _note(deformer, "A later modifier reorders vertices: the deformation is added as displacement")
    return None, True


def _is_last(obj: Object, deformer: SinewDeformer, mode: str) -> bool:
    """No visible modifier follows this deformer's."""
    last = next((modifier for modifier in reversed(obj.modifiers) if _is_shown(modifier, mode)), None)
    return last is not None and last == rig.find_modifier(obj, deformer)


def _note(deformer: SinewDeformer, text: str) -> None:
    """Keep one line about how incoming motion is followed."""
    others = tuple(line for line in status.notes(deformer.uid) if line.level is not Level.INFO)
    status.put_notes(deformer.uid, (*others, Status(Level.INFO, text)) if text else others)


def _same(a: np.ndarray | None, b: np.ndarray | None) -> bool:
    return a is b or (a is not None and b is not None and np.array_equal(a, b))


def _solve(
    deformer: SinewDeformer,
    settings: SinewDeformer,
    depsgraph: Depsgraph,
    obj: Object,
    session: Session,
    bound: Bound,
    incoming: np.ndarray | None,
    displacement: bool,
    preview: bool,
) -> None:
    shown = session.view(depsgraph.mode)
    affine, from_rest = poses.gather(deformer, obj, depsgraph, session, bound)
    options = regions.solve_options(settings)
    signature = (bound.key, affine.tobytes(), from_rest.tobytes(), tuple(options.items()), displacement)
    same = shown.signature == signature and _same(shown.incoming, incoming)
    final = session.settle and same
    early = preview and settings.definition.iterative and not final
    if same and (shown.converged or early):
        if shown.factor == settings.factor:
            return
        positions = shown.positions
    else:
        wide = None if incoming is None else incoming.astype(np.float64)
        options |= {"incoming": wide, "from_rest": from_rest}
        begin = time.perf_counter()
        if final and bind.may_wait(len(bound.rest.points)):
            solved = _final_answer(session, bound, affine, options, signature, incoming)
            if solved is None:
                return
        else:
            _drop_final(session)
            if early:
                options["max_iterations"] = PREVIEW_ITERATIONS
                if shown.positions is not None and not shown.displacement:
                    options["start"] = shown.positions.astype(np.float64)
            solved, _report = bound.factor.solve(affine, **options)
            session.solve_milliseconds = (time.perf_counter() - begin) * 1000.0
        if not np.isfinite(solved).all():
            raise SolverError("The solution is not finite - check the scale of the controls")
        positions = (solved - bound.rest.points if displacement else solved).astype(np.float32)
        shown.converged = not early
    proxy = deformer.proxy_render if depsgraph.mode == "RENDER" else deformer.proxy
    if proxy is None or not write_shape(proxy.data, positions, settings.factor, displacement):
        raise TopologyChangedError("Topology changed - Rebind")
    shown.signature, shown.incoming, shown.positions = signature, incoming, positions
    shown.displacement, shown.factor = displacement, settings.factor
    if shown.converged:
        session.settle = False
    if status.of(deformer.uid).level is not Level.INFO:
        status.put(deformer.uid, Status(Level.INFO, bind.summary(bound)))


def _final_answer(
    session: Session,
    bound: Bound,
    affine: np.ndarray,
    options: dict[str, object],
    signature: tuple,
    incoming: np.ndarray | None,
) -> np.ndarray | None:
    """The answer for these inputs from a thread; None until it has one."""
    work = session.final
    if work is None or work.subject[0] != signature or not _same(work.subject[1], incoming):
        _drop_final(session)
        session.settle = True
        session.final = Work(
            lambda progress: bound.factor.solve(affine, progress=progress, **options), (signature, incoming)
        )
        return None
    if not work.done:
        return None
    session.final = None
    if work.error is not None:
        raise work.error
    session.solve_milliseconds = work.seconds * 1000.0
    return work.result[0]


def _drop_final(session: Session) -> None:
    """Something newer is asked for."""
    session.settle = False
    if session.final is not None:
        session.final.cancel()
        session.final = None


def _after(session: Session, mode: str, settings: SinewDeformer) -> _Chain:
    """What leaves this deformer, as its node group computes it in float32."""
    shown = session.view(mode)
    if shown.positions is None or shown.displacement or settings.mask_group:
        return _Chain(broken=True)
    if shown.factor == 1.0:
        return _Chain(points=shown.positions)
    before = session.bound.rest.compact if shown.incoming is None else shown.incoming
    factor = np.float32(shown.factor)
    return _Chain(points=before * (np.float32(1.0) - factor) + shown.positions * factor)


def settle() -> bool:
    """Ask for the final answer of every preview; True where there was one. For a timer, and for tests."""
    asked = False
    for obj in owners():
        for deformer in obj.sinew.deformers:
            session = state.find(deformer.uid)
            if session is None or (session.final is not None and not session.final.done):
                continue
            if any(not shown.converged for shown in session.shown.values()):
                session.settle = asked = True
                obj.update_tag()
    return asked

# SPDX-License-Identifier: GPL-3.0-or-later
"""Colours of overlays, and the legends that explain them: NumPy only, nothing is drawn here.

Colours are as the screen shows them (not scene-linear), (n, 4), and premultiplied by how much they cover, so
that they can be mixed; ``straight`` makes of them what is drawn.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Colour = tuple[float, float, float]

NEUTRAL: Colour = (0.80, 0.80, 0.79)
HIDDEN: Colour = (0.07, 0.07, 0.08)  # what the mask keeps from moving

# From dark to light, the same order for the colour-blind and in black and white.
_SCALE = np.array(
    (
        (0.18, 0.11, 0.36),
        (0.16, 0.29, 0.55),
        (0.11, 0.47, 0.58),
        (0.18, 0.65, 0.51),
        (0.56, 0.81, 0.32),
        (0.98, 0.90, 0.20),
    )
)
_FAINT = 0.3  # the cover of what was not distorted, as a share of the rest's
_FAINT_FIELD = 0.6  # of the value 0
_EVEN = 2  # rounds over vertices in between
_STEPS = 33  # of a legend's bar


@dataclass(frozen=True)
class Legend:
    """``rows`` of a name and an opaque colour; or a bar, its colours from left to right and its numbers."""

    title: str
    rows: tuple[tuple[str, Colour], ...] = ()
    bar: np.ndarray | None = None
    ticks: tuple[tuple[float, str], ...] = ()
    ends: tuple[str, str] = ()
    note: str = ""


def on_screen(linear: Sequence[float]) -> Colour:
    """A scene-linear colour as the swatch in the panel shows it (IEC 61966-2-1)."""
    return tuple(
        12.92 * value if value <= 0.0031308 else 1.055 * value ** (1.0 / 2.4) - 0.055 for value in linear
    )


def regions(
    count: int,
    parts: Sequence[tuple[np.ndarray, np.ndarray | float, Colour]],
    opacity: float,
    mask: np.ndarray | None = None,
) -> np.ndarray:
    """Each part (members, weights, colour) in its colour, soft ones fading, mixed where they overlap.

    Free vertices stay bare; what the ``mask`` (n,) hides is dark.
    """
    mixed = np.zeros((count, 4), dtype=np.float32)
    for members, weights, colour in parts:
        mixed[members] += np.multiply.outer(np.broadcast_to(weights, len(members)), (*colour, 1.0))
    mixed /= np.maximum(mixed[:, 3:], 1.0)
    if mask is not None:
        shown = np.clip(mask, 0.0, 1.0)[:, None]
        mixed = mixed * shown + (1.0 - shown) * (*HIDDEN, 1.0)
    return (mixed * opacity).astype(np.float32)


def field(values: np.ndarray, opacity: float) -> np.ndarray:
    """Values from 0 (dark and faint) to 1 (bright)."""
    share = np.clip(values, 0.0, 1.0)
    return _covered(scale(share), opacity * (_FAINT_FIELD + (1.0 - _FAINT_FIELD) * share))


def influence(
    values: np.ndarray, opposed: Colour, lost: Colour, outside: np.ndarray, opacity: float
) -> np.ndarray:
    """Weights (n,): from 0 to 1 as a field; negative ones in the ``opposed`` colour, full at -0.25.

    Vertices ``outside`` the cage (indices) are ``lost``.
    """
    painted = field(values, opacity)
    against = np.clip(-4.0 * values, 0.0, 1.0)[:, None]
    painted += against * (opacity * np.array((*opposed, 1.0), dtype=np.float32) - painted)
    painted[outside] = opacity * np.array((*lost, 1.0), dtype=np.float32)
    return painted.astype(np.float32)


def scale(share: np.ndarray) -> np.ndarray:
    """The colours (n, 3) of shares (n,) from 0 to 1."""
    at = np.linspace(0.0, 1.0, len(_SCALE))
    return np.stack([np.interp(share, at, channel) for channel in _SCALE.T], axis=1)


def ratios(
    values: np.ndarray, largest: float, opacity: float, compressed: Colour, stretched: Colour
) -> np.ndarray:
    """Ratios (n,) around 1: below it towards one colour, above towards the other, in full at ``largest``."""
    signed = np.clip(np.log(values) / math.log(largest), -1.0, 1.0)
    return _covered(
        two_sided(signed, compressed, stretched), opacity * (_FAINT + (1.0 - _FAINT) * np.abs(signed))
    )


def two_sided(signed: np.ndarray, compressed: Colour, stretched: Colour) -> np.ndarray:
    """The colours (n, 3) of ``signed`` (n,): -1 compressed, 0 grey, 1 stretched."""
    amount = np.abs(signed)[:, None]
    full = np.where(signed[:, None] < 0.0, compressed, stretched)
    return NEUTRAL + amount * (full - NEUTRAL)


def spread(colours: np.ndarray, origin: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """Colours (m, 4) of a surface with more vertices, from those (n, 4) of its ``origin`` (m,).

    Vertices in between (-1) take the mean of their neighbours along the ``edges`` (e, 2), ring after ring,
    and are then evened out; those that no coloured vertex reaches stay bare.
    """
    finer = np.where(origin[:, None] >= 0, colours[origin], np.float32(0.0))
    known = origin >= 0
    here, there = np.concatenate((edges, edges[:, ::-1])).T
    inner = ~known[here]
    here, there = here[inner], there[inner]
    waiting = np.arange(len(here))
    while len(waiting):
        ready = known[there[waiting]]
        front = waiting[ready]
        if not len(front):
            break
        fresh = _average(finer, here[front], there[front])
        known[fresh] = True
        waiting = waiting[~ready]
        waiting = waiting[~known[here[waiting]]]
    linked = known[there]
    for _ in range(_EVEN):
        _average(finer, here[linked], there[linked])
    return finer


def _average(colours: np.ndarray, here: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Give each vertex of ``here`` the mean colour of its partners ``there``; the vertices, once each."""
    reached = np.bincount(here, minlength=len(colours))
    found = np.flatnonzero(reached)
    sums = [np.bincount(here, channel[there], len(colours))[found] for channel in colours.T]
    colours[found] = np.stack(sums, axis=1) / reached[found, None]
    return found


def straight(colours: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Colours (n, 4) not premultiplied.

    Bare vertices take on the colour of their neighbours, but cover nothing: where a colour ends it then fades
    without a dark seam.
    """
    drawn = colours.copy()
    bare = colours[:, 3] <= 0.0
    if not bare.any():
        drawn[:, :3] /= colours[:, 3:]
        return drawn
    drawn[~bare, :3] /= colours[~bare, 3:]
    seam = triangles[bare[triangles].any(axis=1) & ~bare[triangles].all(axis=1)]
    pairs = [seam[:, sides] for sides in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2))]
    here, there = np.concatenate(pairs).T
    use = bare[here] & ~bare[there]
    if use.any():
        found = _average(drawn, here[use], there[use])
        drawn[found, 3] = 0.0
    return drawn


def _covered(rgb: np.ndarray, cover: np.ndarray) -> np.ndarray:
    coloured = np.empty((len(rgb), 4), dtype=np.float32)
    coloured[:, :3] = rgb * cover[:, None]
    coloured[:, 3] = cover
    return coloured


def field_legend(title: str, largest: float = 1.0, note: str = "") -> Legend:
    """A bar from 0 to ``largest``."""
    ticks = tuple((share, f"{share * largest:.3g}") for share in (0.0, 0.25, 0.5, 0.75, 1.0))
    return Legend(title, bar=scale(np.linspace(0.0, 1.0, _STEPS)), ticks=ticks, note=note)


def ratio_legend(
    title: str,
    ends: tuple[str, str],
    largest: float,
    both: bool,
    compressed: Colour,
    stretched: Colour,
    found: np.ndarray,
) -> Legend:
    """A bar up to ``largest``, from 1, or from 1 over it for ``both`` sides; a note of what was ``found``."""
    signed = np.linspace(-1.0 if both else 0.0, 1.0, _STEPS)
    marks = (-1.0, -0.5, 0.0, 0.5, 1.0) if both else (0.0, 0.25, 0.5, 0.75, 1.0)
    ticks = tuple(
        ((mark - signed[0]) / (1.0 - signed[0]), number(math.exp(mark * math.log(largest)))) for mark in marks
    )
    low, high = (float(found.min()), float(found.max())) if len(found) else (1.0, 1.0)
    note = f"Here {number(low)} to {number(high)}" if both else f"Here up to {number(high)}"
    return Legend(title, bar=two_sided(signed, compressed, stretched), ticks=ticks, ends=ends, note=note)


def number(value: float) -> str:
    """A ratio as short as it can be said."""
    return f"{value:.0f}" if value >= 10.0 else f"{value:.2f}".rstrip("0").rstrip(".")

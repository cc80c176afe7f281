# SPDX-License-Identifier: GPL-3.0-or-later
"""The colours of overlays, and the legends that explain them, as NumPy arrays. Nothing is drawn here.

Colours (n, 4) are those of the screen (not scene-linear), and premultiplied by their opacity, so that they
can be mixed. ``straight`` divides by the opacity before they are drawn.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

Colour = tuple[float, float, float]

NEUTRAL: Colour = (0.80, 0.80, 0.79)
HIDDEN: Colour = (0.07, 0.07, 0.08)  # where the mask hides the deformation

# From dark to light, so that the order is also visible to the colour-blind and in black and white.
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
_FAINT = 0.3  # opacity of what is not distorted, as a share of the full opacity
_FAINT_FIELD = 0.6  # opacity of the value 0, as a share of the full opacity
_SMOOTHINGS = 2  # how often the colours of vertices in between are averaged
_STEPS = 33  # colours along the bar of a legend


@dataclass(frozen=True)
class Legend:
    """A legend: either ``rows`` of a name and an opaque colour each, or a ``bar`` of colours.

    ``bar`` (k, 3) holds colours from left to right, and ``ticks`` the numbers below it.
    """

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
    """The colours of regions. ``parts`` are their members, weights and colours.

    Low weights make a region transparent, and where regions overlap, their colours are mixed. Free vertices
    have no colour. Where the ``mask`` (n,) hides the deformation, the colour is dark.
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
    """The colours of values from 0 (dark and half transparent) to 1 (bright)."""
    share = np.clip(values, 0.0, 1.0)
    return _with_opacity(scale(share), opacity * (_FAINT_FIELD + (1.0 - _FAINT_FIELD) * share))


def bands(numbers: np.ndarray, opacity: float) -> np.ndarray:
    """The colours of bands (n,), light and dark by turns along the scale; those of number -1 have none."""
    count = max(1, int(numbers.max(initial=0)))
    rgb = scale(numbers / count)
    rgb[numbers % 2 == 1] = 0.35 * rgb[numbers % 2 == 1] + 0.65
    return _with_opacity(rgb, np.where(numbers < 0, 0.0, opacity))


def influence(
    values: np.ndarray, opposed: Colour, lost: Colour, outside: np.ndarray, opacity: float
) -> np.ndarray:
    """The colours of weights (n,): from 0 to 1 as in ``field``, below 0 towards the colour ``opposed``.

    At -0.25 that colour is reached. The vertices ``outside`` the cage (indices) have the colour ``lost``.
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
    """The colours of ratios (n,): below 1 towards ``compressed``, above 1 towards ``stretched``.

    The full colours are those of 1 / ``largest`` and of ``largest``.
    """
    signed = np.clip(np.log(values) / math.log(largest), -1.0, 1.0)
    return _with_opacity(
        two_sided(signed, compressed, stretched), opacity * (_FAINT + (1.0 - _FAINT) * np.abs(signed))
    )


def two_sided(signed: np.ndarray, compressed: Colour, stretched: Colour) -> np.ndarray:
    """The colours (n, 3) of the values ``signed`` (n,): -1 is compressed, 0 is grey, 1 is stretched."""
    amount = np.abs(signed)[:, None]
    full = np.where(signed[:, None] < 0.0, compressed, stretched)
    return NEUTRAL + amount * (full - NEUTRAL)


def spread(colours: np.ndarray, origin: np.ndarray, edges: np.ndarray) -> np.ndarray:
    """The colours (m, 4) of a surface with more vertices, from the colours (n, 4) of the coarser surface.

    ``origin`` (m,) is the coarse vertex of each vertex, or -1 for a vertex in between. Such a vertex takes
    the mean colour of its neighbours along the ``edges`` (e, 2), ring after ring; then these colours are
    averaged again. A vertex that is not connected to any coloured one has no colour.
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
    for _ in range(_SMOOTHINGS):
        _average(finer, here[linked], there[linked])
    return finer


def _average(colours: np.ndarray, here: np.ndarray, there: np.ndarray) -> np.ndarray:
    """Give each vertex of ``here`` the mean colour of its partners ``there``. Returns these vertices."""
    reached = np.bincount(here, minlength=len(colours))
    found = np.flatnonzero(reached)
    sums = [np.bincount(here, channel[there], len(colours))[found] for channel in colours.T]
    colours[found] = np.stack(sums, axis=1) / reached[found, None]
    return found


def straight(colours: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Colours (n, 4) that are not premultiplied.

    Vertices without a colour take the colour of their neighbours, with opacity 0. So the border of a coloured
    area fades out without a dark seam.
    """
    drawn = colours.copy()
    uncoloured = colours[:, 3] <= 0.0
    if not uncoloured.any():
        drawn[:, :3] /= colours[:, 3:]
        return drawn
    drawn[~uncoloured, :3] /= colours[~uncoloured, 3:]
    seam = triangles[uncoloured[triangles].any(axis=1) & ~uncoloured[triangles].all(axis=1)]
    pairs = [seam[:, sides] for sides in ((0, 1), (1, 2), (2, 0), (1, 0), (2, 1), (0, 2))]
    here, there = np.concatenate(pairs).T
    use = uncoloured[here] & ~uncoloured[there]
    if use.any():
        found = _average(drawn, here[use], there[use])
        drawn[found, 3] = 0.0
    return drawn


def _with_opacity(rgb: np.ndarray, opacity: np.ndarray) -> np.ndarray:
    coloured = np.empty((len(rgb), 4), dtype=np.float32)
    coloured[:, :3] = rgb * opacity[:, None]
    coloured[:, 3] = opacity
    return coloured


def field_legend(title: str, largest: float = 1.0, note: str = "") -> Legend:
    """A legend with a bar from 0 to ``largest``."""
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
    """A legend with a bar from 1, or for ``both`` sides from 1 / ``largest``, to ``largest``.

    Its note gives the range of the ratios that were ``found``.
    """
    signed = np.linspace(-1.0 if both else 0.0, 1.0, _STEPS)
    marks = (-1.0, -0.5, 0.0, 0.5, 1.0) if both else (0.0, 0.25, 0.5, 0.75, 1.0)
    ticks = tuple(
        ((mark - signed[0]) / (1.0 - signed[0]), number(math.exp(mark * math.log(largest)))) for mark in marks
    )
    low, high = (float(found.min()), float(found.max())) if len(found) else (1.0, 1.0)
    note = f"Here {number(low)} to {number(high)}" if both else f"Here up to {number(high)}"
    return Legend(title, bar=two_sided(signed, compressed, stretched), ticks=ticks, ends=ends, note=note)


def number(value: float) -> str:
    """A ratio as a short text."""
    return f"{value:.0f}" if value >= 10.0 else f"{value:.2f}".rstrip("0").rstrip(".")

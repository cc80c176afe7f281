# SPDX-License-Identifier: GPL-3.0-or-later
"""Space methods that curves control."""

from .schema import Control, Family, Float, Method, Moved, Span

ROWS = (
    Method(
        id="wires",
        number=46,
        label="Wires",
        known_as="Wires",
        search="brow lip fold crease curve face bulge",
        family=Family.SPACE_LINEAR,
        section="5.4",
        paper="Singh & Fiume 1998",
        summary="Carries what lies beside a curve: brows, lips, folds",
        fails="Loses twists about the curve itself",
        picture="wires: angry",
        control=Control.CURVES,
        moves=frozenset(Moved),
        bind_seconds=lambda points, size, _options: 5e-7 * points + 1.5e-8 * points * size,
        main=("radius", "exponent"),
        parameters=(
            Float("exponent", "Dominance", 1.0, Span(0.0, 100.0, soft=8.0)).described(
                "Let the wire with the longest move prevail where several reach; 0 takes the mean of all"
            ),
            Float(
                "smoothing",
                "Smoothing",
                0.2,
                Span(0.0, 10.0, soft=1.0),
                advanced=True,
                unit="share of the distance",
            ).described(
                "Set how much farther than the nearest place of a wire other places count; "
                "with 0 only the nearest counts, and the shape tears inside a bent wire"
            ),
        ),
        control_parameters=(
            Float("radius", "Radius", 0.5, Span(1e-6, digits=3), unit="length").described(
                "Set how far from the wire points follow it, in the space of the curve"
            ),
            Float("scale", "Scale", 1.0, Span(-100.0, 100.0, soft=3.0)).described(
                "Scale the distances from the wire near it, also while the wire rests"
            ),
            Float("rotation", "Rotation", 1.0, Span(0.0, 1.0, soft=1.0)).described(
                "Set how much of the turn of the wire points follow; with 0 they only move"
            ),
        ),
    ),
)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Space methods that curves control."""

from .schema import Control, Family, Float, Method, Moved

ROWS = (
    Method(
        id="wires",
        number=46,
        label="Wires",
        known_as="Wires",
        search="brow lip fold crease curve face bulge",
        family=Family.SPACE_LINEAR,
        control=Control.CURVES,
        native="Wires",
        section="5.4",
        paper="Singh & Fiume 1998",
        summary="Carries what lies beside a curve: brows, lips, folds",
        fails="Loses twists about the curve itself",
        picture="wires: angry",
        main=("radius", "exponent"),
        moves=frozenset(Moved),
        bind_seconds=lambda points, size, _options: 5e-7 * points + 1.5e-8 * points * size,
        parameters=(
            Float(
                "exponent",
                1.0,
                maximum=100.0,
                soft_maximum=8.0,
                rebinds=True,
                label="Dominance",
                description="Let the wire with the longest move prevail where several reach; 0 takes the "
                "mean of all",
            ),
            Float(
                "smoothing",
                0.2,
                maximum=10.0,
                soft_maximum=1.0,
                rebinds=True,
                advanced=True,
                unit="share of the distance",
                label="Smoothing",
                description="Set how much farther than the nearest place of a wire other places count; "
                "with 0 only the nearest counts, and the shape tears inside a bent wire",
            ),
        ),
        control_parameters=(
            Float(
                "radius",
                0.5,
                minimum=1e-6,
                precision=3,
                unit="length",
                rebinds=True,
                label="Radius",
                description="Set how far from the wire points follow it, in the space of the curve",
            ),
            Float(
                "scale",
                1.0,
                minimum=-100.0,
                maximum=100.0,
                soft_maximum=3.0,
                rebinds=True,
                label="Scale",
                description="Scale the distances from the wire near it, also while the wire rests",
            ),
            Float(
                "rotation",
                1.0,
                maximum=1.0,
                soft_maximum=1.0,
                rebinds=True,
                label="Rotation",
                description="Set how much of the turn of the wire points follow; with 0 they only move",
            ),
        ),
    ),
)

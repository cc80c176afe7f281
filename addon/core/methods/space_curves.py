# SPDX-License-Identifier: GPL-3.0-or-later
"""Space methods that curves control."""

from .schema import Control, Family, Float, Method, Moved, per_pair

ROWS = (
    Method(
        id="wires",
        number=46,
        label="Wires",
        family=Family.SPACE_LINEAR,
        control=Control.CURVES,
        native="Wires",
        section="5.4",
        paper="Singh & Fiume 1998",
        summary="Curves carry what lies within their radius, such as brows, lips and folds; the rest stays",
        moves=frozenset(Moved),
        bind_seconds=per_pair(1.5e-8),
        parameters=(
            Float(
                "exponent",
                1.0,
                maximum=100.0,
                soft_maximum=8.0,
                rebinds=True,
                label="Sharing",
                description="Where several wires reach, the one with the longest move prevails, the more so "
                "the larger this is. 0 takes the mean of all moves",
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
                description="How much farther than the nearest place of a wire other places count. With 0 "
                "only the nearest counts, and the shape tears inside a bent wire",
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
                description="How far from the wire points follow it, in the space of the curve",
            ),
            Float(
                "scale",
                1.0,
                minimum=-100.0,
                maximum=100.0,
                soft_maximum=3.0,
                rebinds=True,
                label="Scale",
                description="Scales the distances from the wire near it, also while the wire rests",
            ),
            Float(
                "rotation",
                1.0,
                maximum=1.0,
                soft_maximum=1.0,
                rebinds=True,
                label="Rotation",
                description="How much of the turn of the wire points follow. With 0 they only move",
            ),
        ),
    ),
)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Blender's own Laplacian Deform as a row of the comparison of methods."""

from __future__ import annotations

import sys
from pathlib import Path

import bpy

sys.path.insert(0, str(Path(__file__).resolve().parents[3]))

from blend_samples.comparison import filled
from blend_samples.comparison.cases import bar
from blend_samples.comparison.picture import laplacian_deform


def test_laplacian_deform_enters_the_matrix():
    """Blender answers: its handles are about where they belong, and the twisted bar is pinched."""
    before = len(bpy.data.objects)
    matrix = filled([("bar", bar(5)), ("gentle", bar(5, 30.0))], [("Laplacian Deform", laplacian_deform)])
    twisted, gentle = (matrix.cells["Laplacian Deform", name].distortion for name in ("bar", "gentle"))
    for found in (twisted, gentle):
        assert found.handle_error < 0.02  # it holds them in the sense of least squares
    assert gentle.edge_rms < 0.05 < 0.12 < twisted.edge_rms
    assert gentle.edge_least > 0.8 > 0.5 > twisted.edge_least
    assert len(bpy.data.objects) == before

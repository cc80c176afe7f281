# SPDX-License-Identifier: GPL-3.0-or-later
"""Wires against a loop over them in NumPy, which follows the paper step by step."""

import numpy as np
import pytest

import sinew_native as sn


def by_numpy(points, rest, posed, radius: float, scale: float = 1.0, rotation: float = 1.0) -> np.ndarray:
    """The moves D_i (n, 3) by one wire, with the rule of the nearest place."""
    sides = np.diff(rest, axis=0)
    along = np.einsum("nsk,sk->ns", points[:, None] - rest[:-1], sides) / (sides**2).sum(1)
    along = np.clip(along, 0.0, 1.0)
    feet = rest[:-1] + along[..., None] * sides
    near = np.linalg.norm(points[:, None] - feet, axis=2).argmin(1)
    row = np.arange(len(points))
    t = along[row, near][:, None]

    def at(curve):
        return (1 - t) * curve[near] + t * curve[near + 1]

    def tangents(curve):
        ends = np.concatenate((curve[:1], curve, curve[-1:]))
        found = ends[2:] - ends[:-2]
        return found / np.linalg.norm(found, axis=1, keepdims=True)

    before, after = tangents(rest), tangents(posed)
    axes = np.cross(before, after)
    sine = np.linalg.norm(axes, axis=1, keepdims=True)
    angle = np.arctan2(sine, (before * after).sum(1, keepdims=True))
    turns = rotation * angle * np.divide(axes, sine, out=np.zeros_like(axes), where=sine > 0)
    from_wire, turn, move = points - at(rest), at(turns), at(posed - rest)
    share = np.clip(np.linalg.norm(from_wire, axis=1, keepdims=True) / radius, 0.0, 1.0)
    F = (1 - share**2) ** 2
    scaled = from_wire * (1 + (scale - 1) * F)
    theta = np.linalg.norm(turn, axis=1, keepdims=True)
    axis = np.divide(turn, theta, out=np.zeros_like(turn), where=theta > 0)
    c, s = np.cos(F * theta), np.sin(F * theta)
    turned = c * scaled + s * np.cross(axis, scaled) + (1 - c) * axis * (axis * scaled).sum(1, keepdims=True)
    return turned - from_wire + F * move


@pytest.mark.parametrize("exponent", [0.0, 1.0, 3.0])
def test_several_wires_are_those_of_the_loop(exponent: float) -> None:
    rng = np.random.default_rng(4)
    points = rng.uniform(-1, 1, (2000, 3))
    rest = [np.cumsum(rng.normal(0, 0.2, (9, 3)), axis=0) for _ in range(4)]
    posed = [wire + rng.normal(0, 0.2, wire.shape) for wire in rest]
    if exponent:
        posed[3] = rest[3]  # which holds nothing back; without an exponent, all in reach count alike
    radius, scale, rotation = [0.9, 0.6, 1.2, 1.5], [1.0, 1.8, 0.4, 1.0], [1.0, 0.3, 0.0, 1.0]
    moves = [by_numpy(points, *each) for each in zip(rest, posed, radius, scale, rotation, strict=True)]
    weights = [
        np.where((length := np.linalg.norm(move, axis=1, keepdims=True)) > 0, length**exponent, 0.0)
        if exponent
        else (np.abs(move).max(1, keepdims=True) > 0).astype(float)
        for move in moves
    ]
    total = np.maximum(sum(weights), 1e-300)
    expected = points + sum(w * m for w, m in zip(weights, moves, strict=True)) / total
    wires = sn.Wires(
        np.concatenate(rest),
        [9, 9, 9, 9],
        radius=radius,
        scale=scale,
        rotation=rotation,
        exponent=exponent,
        smoothing=0.0,
    )
    wires.bind(points)
    np.testing.assert_allclose(wires.warp(np.concatenate(posed)), expected, atol=1e-12)


def test_beside_a_straight_wire_there_is_nothing_to_smooth() -> None:
    rest = np.linspace((-5, 0, 0), (5, 0, 0), 41)
    points, posed = np.random.default_rng(3).uniform(-1.5, 1.5, (300, 3)), rest + (0, 1, 0)
    wires = sn.Wires(rest, radius=1.25)
    wires.bind(points)
    np.testing.assert_allclose(wires.warp(posed) - points, by_numpy(points, rest, posed, 1.25), atol=1e-14)


def test_counts_flags_and_values_come_as_numbers_or_one_per_curve() -> None:
    line = np.array([(0.0, 0, 0), (1, 0, 0), (1, 1, 0)])
    twice = np.concatenate((line, line + (0, 0, 3)))
    wires = sn.Wires(twice, [3, 3], closed=[True, False], radius=[1.0, 2.0], domain=np.full((6, 3), np.nan))
    assert (wires.curve_count, wires.sample_count) == (2, 6)
    for wrong in (
        {"counts": [3, 2]},
        {"counts": [5, 1]},
        {"closed": [True, False, True]},
        {"radius": [1.0, 2.0, 3.0]},
        {"domain": line},
        {"rotation": 2.0},
    ):
        with pytest.raises(sn.Error):
            sn.Wires(twice, **{"counts": [3, 3], **wrong})
    for few in (line[:0], line[:1]):
        with pytest.raises(sn.Error):
            sn.Wires(few)
    with pytest.raises(sn.InvalidConstraint, match="no length") as refused:
        sn.Wires(np.concatenate((line, np.ones((3, 3)))), [3, 3])
    assert (refused.value.element_kind, list(refused.value.elements)) == ("handle", [1])
    with pytest.raises(sn.InvalidConstraint) as refused:
        sn.Wires([*line, (0, np.inf, 0)])
    assert (refused.value.element_kind, list(refused.value.elements)) == ("vertex", [3])

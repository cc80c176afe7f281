# SPDX-License-Identifier: GPL-3.0-or-later
"""Overlays in a real window: the colours that the settings promise, and nothing left when they are off."""

import numpy as np
import pytest
from blender_window import drive

TIMEOUT = 300.0  # a software renderer draws about two windows a second
SLACK = 0.04  # the viewport mixes in linear light and rounds to 8 bits; the oracle here does neither
STEADY = 0.002  # of the pixels: anti-aliasing is never twice the same


@pytest.fixture(scope="module")
def seen(tmp_path_factory: pytest.TempPathFactory) -> dict:
    """What the session in ``drive_overlay.py`` observed."""
    return drive("drive_overlay.py", tmp_path_factory.mktemp("overlay"), TIMEOUT)


def colour(seen: dict, picture: str, spot: str) -> np.ndarray:
    return np.array(seen["pixels"][picture][spot])


def over(seen: dict, spot: str, rgb: list[float]) -> np.ndarray:
    """A colour over what the viewport shows at a spot without overlays."""
    share = seen["opacity"]
    return (1.0 - share) * colour(seen, "off", spot) + share * np.array(rgb)


def redness(rgb: np.ndarray) -> float:
    return float(rgb[0] - rgb[2])


@pytest.mark.parametrize("spot", ["head", "hoof", "hooves"])
def test_regions_have_the_colours_of_their_swatches(seen: dict, spot: str):
    expected = over(seen, spot, seen["colours"][spot])
    assert np.abs(colour(seen, "regions", spot) - expected).max() < SLACK


@pytest.mark.parametrize("spot", ["chest", "flank"])
def test_free_parts_keep_their_shading(seen: dict, spot: str):
    assert np.abs(colour(seen, "regions", spot) - colour(seen, "off", spot)).max() < 0.01


def test_the_stretched_chest_is_red_and_the_rigid_head_grey(seen: dict):
    assert redness(colour(seen, "area", "chest")) > 0.2
    assert abs(redness(colour(seen, "area", "head"))) < 0.03
    assert redness(colour(seen, "off", "chest")) < 0.02


@pytest.mark.parametrize("name", ["regions", "area"])
def test_what_is_switched_on_shows(seen: dict, name: str):
    assert seen[name]["drawing"]
    assert seen["pixels"][name]["changed"] > 0.05


def test_redraws_without_a_change_paint_nothing(seen: dict):
    assert seen["painted_after_idle"] == seen["area"]["painted"]


def test_switched_off_the_picture_is_as_before(seen: dict):
    assert not seen["off-again"]["drawing"]
    assert seen["pixels"]["off-again"]["changed"] < STEADY


def test_x_ray_shows_each_place_once(seen: dict):
    """The far side of the head does not add to the near side."""
    plain, through = colour(seen, "regions", "head"), colour(seen, "x-ray", "head")
    assert np.abs(redness(plain) - redness(through)) < 0.08


def test_edit_mode_shows_the_regions(seen: dict):
    for spot in ("head", "hoof"):
        assert np.abs(colour(seen, "edit", spot) - colour(seen, "regions", spot)).max() < SLACK


def test_disabling_the_add_on_clears_the_picture(seen: dict):
    assert not seen["drawing_after_disable"]
    assert seen["pixels"]["disabled"]["changed"] < STEADY

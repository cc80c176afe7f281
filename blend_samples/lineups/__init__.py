# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples that show one model in a row, each time posed in another way: a table for each family of models."""

from . import cows, dragons, mannequins, pillars, plates

LINEUPS = pillars.LINEUPS | plates.LINEUPS | cows.LINEUPS | dragons.LINEUPS | mannequins.LINEUPS

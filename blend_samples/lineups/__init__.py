# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples that show one model in a row, each time posed in another way: a table for each family of models."""

from . import cages, cows, dragons, mannequins, pillars, plates, yetis

TABLES = (cages, cows, dragons, mannequins, pillars, plates, yetis)
LINEUPS = {name: row for table in TABLES for name, row in table.LINEUPS.items()}

# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes a live deformer to shapes that play without the add-on, makes it live again; transfers animations."""

from .alembic import export as export_alembic
from .alembic import is_available as can_write_alembic
from .job import Baking, Request
from .paths import choose as choose_path
from .paths import offered as offered_path
from .stretching import frame_at
from .there import has_files, look, play_instead
from .transfer import Transferring
from .unbake import unbake

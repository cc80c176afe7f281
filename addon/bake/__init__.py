# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes a live deformer to shapes that play without the add-on, makes it live again; transfers animations."""

from .alembic import can_write_alembic as can_write_alembic, export_alembic as export_alembic
from .job import Baking as Baking, Request as Request
from .paths import offered_path as offered_path
from .stretching import frame_at as frame_at
from .there import has_files as has_files, look as look, play_instead as play_instead
from .transfer import Transferring as Transferring
from .unbake import unbake as unbake

# SPDX-License-Identifier: GPL-3.0-or-later
"""Bakes a live deformer to shapes that play without the add-on, makes it live again; transfers animations."""

from .alembic import (
    can_write_alembic as can_write_alembic,
    export_alembic as export_alembic,
    require_exportable as require_exportable,
)
from .chunks import (
    Chunk as Chunk,
    ChunkBaking as ChunkBaking,
    ChunkShowing as ChunkShowing,
    Origin as Origin,
    chunk_path as chunk_path,
    difference as difference,
    file_name as file_name,
    find_all as find_all,
    is_made as is_made,
    write_joined as write_joined,
    write_object as write_object,
)
from .files import SUFFIXES as SUFFIXES, replacing as replacing
from .job import Baking as Baking, Request as Request
from .paths import below as below, offered_path as offered_path
from .sequences import missing_frames as missing_frames
from .stretching import frame_at as frame_at
from .there import has_files as has_files, look as look, play_instead as play_instead
from .transfer import Transferring as Transferring
from .unbake import unbake as unbake

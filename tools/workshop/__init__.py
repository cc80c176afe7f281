# SPDX-License-Identifier: GPL-3.0-or-later
"""The modules behind the commands in ``tools/`` and ``tests/run``. They need Debian's Python 3.11 alone."""

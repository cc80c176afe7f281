# SPDX-License-Identifier: GPL-3.0-or-later
"""The parts behind the commands in ``tools/`` and behind ``tests/run``: Debian's Python 3.11, no packages."""

# SPDX-License-Identifier: GPL-3.0-or-later
"""``python -m sinew_farm`` does what the command ``sinew-farm`` does."""

from .command import main

main()

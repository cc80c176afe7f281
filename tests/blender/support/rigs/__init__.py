# SPDX-License-Identifier: GPL-3.0-or-later
"""Objects with a deformer, ready to pose: one module for each kind of control, and what they share."""

# SPDX-License-Identifier: GPL-3.0-or-later
"""Samples of Sinew: each poses a model through the add-on, saves a .blend file and renders a picture."""

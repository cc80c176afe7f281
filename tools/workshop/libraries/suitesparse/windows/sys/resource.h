// SPDX-License-Identifier: GPL-3.0-or-later
// Windows has no such header; METIS includes it for its clocks (clocks.c).

// SPDX-License-Identifier: GPL-3.0-or-later
// Windows has no such header; CPython's include it.

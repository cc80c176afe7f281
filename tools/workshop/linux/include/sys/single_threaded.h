// SPDX-License-Identifier: GPL-3.0-or-later
// Stands for the header of this name, which CGAL includes and C libraries before 2.32 do not have.
#pragma once

static const bool __libc_single_threaded = false;

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

/// Moving least squares of Zhu & Gortler 2007 with rotations, one point after the other: the weights and the
/// centred handles anew for each point, and a singular value decomposition.
/// \param handles, posed  (handle_count, 3)
/// \param points          (count, 3)
/// \param[out] result     (count, 3)
void peer_rigid_mls(const double* handles, const double* posed, int handle_count, const double* points,
                    int count, double* result);

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <Eigen/Core>

/// A triangle cage, read in place.
struct PeerCage
{
    const double* vertices; ///< (vertex_count, 3)
    const int* triangles;   ///< (triangle_count, 3)
    int vertex_count, triangle_count;

    Eigen::Vector3d vertex(int v) const { return Eigen::Vector3d::Map(vertices + 3 * v); }
};

/// \param[out] weights  (count, vertex_count)
void peer_mean_value(const PeerCage& cage, const double* points, int count, double* weights);
/// \param[out] phi  (count, vertex_count)
/// \param[out] psi  (count, triangle_count)
void peer_green(const PeerCage& cage, const double* points, int count, double* phi, double* psi);

/// Moving least squares of Zhu & Gortler 2007 with rotations, one point after the other: the weights and the
/// centred handles anew for each point, and a singular value decomposition.
/// \param handles, posed  (handle_count, 3)
/// \param points          (count, 3)
/// \param[out] result     (count, 3)
void peer_rigid_mls(const double* handles, const double* posed, int handle_count, const double* points,
                    int count, double* result);

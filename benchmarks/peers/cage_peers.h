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
/// result (points, 3) = weights (points, columns) * factors (columns, 3), row-major, by BLAS on one thread.
void peer_sgemm(const float* weights, int points, int columns, const float* factors, float* result);

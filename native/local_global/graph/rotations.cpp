// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/graph/rotations.h"

#include "native/core/dense.h"
#include "native/operators/fits/rotation_fit.h"

namespace sinew {

std::vector<Eigen::Quaterniond> blended_rotations(const HandleGraph& graph,
                                                  const std::vector<double>& laplacian,
                                                  const SingleFactor& factor, const Poses& poses)
{
    const int handles = static_cast<int>(poses.size());
    Eigen::MatrixX4d q(handles, 4);
    for (int h = 0; h < handles; ++h)
        q.row(h) = Eigen::Quaterniond(fit_rotation(poses[h].leftCols<3>())).coeffs().transpose();
    // The dominant eigenvector is the mean of the rotations. A quaternion and its negative are the same
    // rotation, so those on the far side of the mean are negated.
    const Eigen::Matrix4d sum = (q.transpose() * q).triangularView<Eigen::Lower>();
    const Eigen::Vector4d mean = eigenvectors(sum).vectors.col(3);
    for (int h = 0; h < handles; ++h)
        if (q.row(h).dot(mean) < 0)
            q.row(h) *= -1;

    // Only departures from the mean are blended, so no rounding remains where all handles agree.
    const GraphEdges& edges = graph.edges();
    MatrixX sides = MatrixX::Zero(graph.free_count(), 4);
    for (int f = 0; f < graph.free_count(); ++f) {
        const int i = graph.free_nodes()[f];
        for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a)
            if (const int hard = graph.hard(edges.neighbours[a]); hard >= 0)
                sides.row(f) += laplacian[a] * (q.row(hard) - mean.transpose());
    }
    for (const GraphPull& pull : graph.pulls())
        sides.row(graph.place(pull.node)) += pull.stiffness * (q.row(pull.handle) - mean.transpose());
    factor.solve(sides, sides);

    std::vector<Eigen::Quaterniond> rotations(graph.size(), Eigen::Quaterniond::Identity());
    for (int i = 0; i < graph.size(); ++i) {
        if (graph.is_idle(i))
            continue;
        Eigen::Vector4d r = mean;
        if (graph.hard(i) >= 0)
            r = q.row(graph.hard(i)).transpose();
        else if ((mean + sides.row(graph.place(i)).transpose()).norm() > 1e-9)
            r += sides.row(graph.place(i)).transpose();
        rotations[i] = Eigen::Quaterniond(r.normalized());
    }
    return rotations;
}

Eigen::Quaterniond handed_down(const ClusterMap& map, const std::vector<Eigen::Quaterniond>& rotations,
                               int node)
{
    const Eigen::Quaterniond& own = rotations[map.label()[node]];
    const ClusterMap::Shares shares = map.shares(node);
    Eigen::Vector4d sum = Eigen::Vector4d::Zero();
    for (int k = 0; k < shares.count; ++k) {
        const Eigen::Quaterniond& r = rotations[shares.clusters[k]];
        sum += (r.dot(own) < 0 ? -shares.weights[k] : shares.weights[k]) * r.coeffs();
    }
    return Eigen::Quaterniond(sum.normalized());
}

} // namespace sinew

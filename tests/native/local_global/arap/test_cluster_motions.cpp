// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/cluster_motions.h"

#include "native/local_global/arap/multilevel_start.h"
#include "tests/native/local_global/arap/graphs.h"
#include "tests/native/shapes.h"

#include <Eigen/Geometry>

#include <cmath>

namespace sinew::test_cluster_motions {

Matrix3 turn(const Vector3& w)
{
    return Eigen::AngleAxisd(w.norm(), w.stableNormalized()).toRotationMatrix();
}

/// The energy of points and rotations, written down for itself.
struct Energy
{
    const ArapSystem& graph;
    Points rest, x; ///< of all nodes
    std::vector<Matrix3> R;

    double of_edges(int i) const
    {
        const GraphEdges& edges = graph.nodes().edges();
        double sum = 0.0;
        for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a) {
            const int j = edges.neighbours[a];
            const Vector3 e = (rest.row(i) - rest.row(j)).transpose(), d = (x.row(i) - x.row(j)).transpose();
            sum += edges.weights[a] * ((d - R[i] * e).squaredNorm() + (d - R[j] * e).squaredNorm() +
                                       2 * graph.cells().smoothing * (R[i] - R[j]).squaredNorm());
        }
        return sum / 4;
    }
    double of_pulls(int i) const // to the rest
    {
        double sum = 0.0;
        for (const GraphPull& pull : graph.nodes().pulls())
            sum += pull.node == i ? pull.stiffness / 2 * (x.row(i) - rest.row(i)).squaredNorm() : 0.0;
        return sum;
    }
    double all() const
    {
        double sum = 0.0;
        for (int i = 0; i < graph.size(); ++i)
            sum += of_edges(i) / 2 + of_pulls(i);
        return sum;
    }
    double slope(int i, int k, bool turned)
    {
        constexpr double h = 1e-5;
        double side[2];
        for (const int s : {0, 1}) {
            const double step = s == 0 ? -h : h;
            const Eigen::RowVector3d at = x.row(i);
            const Matrix3 turned_by = R[i];
            if (turned)
                R[i] = turn(step * Vector3::Unit(k)) * R[i];
            else
                x(i, k) += step;
            side[s] = of_edges(i) + of_pulls(i);
            x.row(i) = at;
            R[i] = turned_by;
        }
        return (side[1] - side[0]) / (2 * h);
    }
};

TEST(ClusterMotions, a_whole_step_leaves_no_slope_along_any_motion)
{
    for (const bool soft : {false, true}) {
        SurfaceMesh mesh = shapes::sphere(4);
        std::vector<Handle> handles = graphs::poles(mesh);
        if (soft)
            handles[1].weights.assign(handles[1].vertices.size(), 0.6);
        const ArapSystem graph = graphs::of(mesh, handles, 0.02);
        const Points& rest = mesh.points();
        const auto level = RotationLevel::coarser(graph.nodes(), graph.cells(), rest);
        ASSERT_TRUE(level);
        const ClusterMotions motions(graph, rest, level->map.label(), level->graph.nodes());

        Energy energy{graph, rest, rest, std::vector<Matrix3>(graph.size(), Matrix3::Identity())};
        const int free = graph.free_count();
        energy.x.topRows(free) += 1e-4 * shapes::Random(1).dense(free, 3);
        const MatrixX turns = 1e-4 * shapes::Random(2).dense(free, 3);
        for (int i = 0; i < free; ++i)
            energy.R[i] = turn(turns.row(i).transpose());

        ClusterMotions::Motion motion;
        const auto solve = [&] {
            Points gradient(free, 3), torque = Points::Zero(graph.size(), 3);
            for (int i = 0; i < free; ++i)
                for (int k = 0; k < 3; ++k) {
                    gradient(i, k) = energy.slope(i, k, false);
                    torque(i, k) = -energy.slope(i, k, true);
                }
            return motions.solve(energy.x.topRows(free), energy.x.data(), energy.R.front().data(), gradient,
                                 torque, 1.0, motion);
        };
        const double slope = solve(), before = energy.all();
        EXPECT_GT(slope, 1e-3 * before);
        motions.scale(1.0, motion);
        for (int i = 0; i < free; ++i) {
            Eigen::RowVector3d to, by;
            motions.move(motion, i, energy.x.row(i), to, by);
            energy.x.row(i) = to;
            energy.R[i] = turn(by.transpose()) * energy.R[i];
        }
        EXPECT_NEAR(before - energy.all(), 0.5 * slope, 1e-3 * slope); // turns are not infinitely small
        EXPECT_LT(solve(), 1e-6 * slope);
    }
}

TEST(ClusterMotions, bends_are_quadratic_in_the_points)
{
    SurfaceMesh mesh = shapes::grid(30, 30, 0.1);
    std::vector<Handle> pulled{{shapes::where(mesh, [](const Vector3& p) { return p.x() < 0.35; }), {}}};
    pulled[0].weights.assign(pulled[0].vertices.size(), 0.5); // so that no cluster is held
    const ArapSystem graph = graphs::of(mesh, pulled, 0.02);
    const Points& rest = mesh.points();
    const auto level = RotationLevel::coarser(graph.nodes(), graph.cells(), rest);
    ASSERT_TRUE(level);
    const ClusterMotions motions(graph, rest, level->map.label(), level->graph.nodes());
    ClusterMotions::Motion motion;
    const std::vector<Matrix3> R(graph.size(), Matrix3::Identity());
    motions.solve(rest, rest.data(), R.front().data(), rest, Points(), 1.0, motion);

    constexpr double curvature = 1e-6;
    for (int p = 0; p < level->graph.size(); ++p) { // z = curvature x^2 / 2; a solution is stepped against
        const double x = motion.places(p, 0);
        motion.solution.middleRows<6>(6 * p) << 0, 0, -curvature * x * x / 2, 0, curvature * x, 0;
    }
    motions.scale(1.0, motion);
    int inside = 0; // of a triangle of clusters
    for (int i = 0; i < graph.size(); ++i) {
        const double x = rest(i, 0);
        Eigen::RowVector3d to, turned;
        motions.move(motion, i, rest.row(i), to, turned);
        if (std::abs(2 * (x - motion.offsets(i, 0)) - x) > 1e-9)
            continue;
        ++inside;
        EXPECT_NEAR(to.z(), curvature * x * x / 2, 1e-5 * curvature) << i;
        EXPECT_NEAR(turned.y(), -curvature * x, 1e-9 * curvature) << i;
    }
    EXPECT_GT(inside, graph.size() / 2);
}

} // namespace sinew::test_cluster_motions

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/graph/rotations.h"

#include "tests/native/local_global/graph/mesh_graph.h"

namespace sinew::test_rotations {

struct Setting : graphs::BarAndSphere
{
    SingleFactor factor;

    explicit Setting(double weight = 1.0) : BarAndSphere(weight)
    {
        std::vector<Eigen::Triplet<double>> L;
        const GraphEdges& edges = graph.edges();
        for (int i : graph.free_nodes())
            for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a) {
                const int j = edges.neighbours[a];
                L.emplace_back(graph.place(i), graph.place(i), edges.weights[a]);
                if (graph.place(j) >= 0)
                    L.emplace_back(graph.place(i), graph.place(j), -edges.weights[a]);
            }
        for (const GraphPull& pull : graph.pulls())
            L.emplace_back(graph.place(pull.node), graph.place(pull.node), pull.stiffness);
        SparseMatrix matrix(graph.free_count(), graph.free_count());
        matrix.setFromTriplets(L.begin(), L.end());
        factor.factorize(matrix);
    }

    std::vector<Eigen::Quaterniond> blended(const Poses& poses) const
    {
        return blended_rotations(graph, graph.edges().weights, factor, poses);
    }
};

/// The angle between two rotations.
double apart(const Eigen::Quaterniond& a, const Matrix3& b)
{
    return Eigen::AngleAxisd(a.toRotationMatrix().transpose() * b).angle();
}

TEST(BlendedRotations, are_that_of_all_handles_where_these_agree)
{
    for (double weight : {1.0, 0.3}) {
        const Setting setting(weight);
        const Pose pose = shapes::turn({1, 2, -0.5}, 170, {3, 7, 1}, {30, -20, 10});
        const auto rotations = setting.blended({pose, pose});
        for (int i = 0; i < setting.graph.size(); ++i)
            EXPECT_LT(apart(rotations[i],
                            setting.graph.is_idle(i) ? Matrix3::Identity() : Matrix3(pose.leftCols<3>())),
                      1e-7);
    }
}

TEST(BlendedRotations, lie_between_those_of_the_handles)
{
    const Setting setting;
    const Poses poses{shapes::still(), shapes::turn({1, 0, 0}, 90)};
    const auto rotations = setting.blended(poses);
    for (int i = 0; i < setting.graph.size(); ++i) {
        if (setting.graph.is_idle(i))
            continue;
        if (const int handle = setting.graph.hard(i); handle >= 0) {
            EXPECT_LT(apart(rotations[i], poses[handle].leftCols<3>()), 1e-7);
        }
        // Harmonic along the bar is linear; quaternions of a quarter turn are nearly so.
        const double along = std::clamp((setting.mesh.point(i).x() - 2) / 20, 0.0, 1.0);
        EXPECT_NEAR(apart(rotations[i], Matrix3::Identity()), along * shapes::pi / 2, 0.1);
    }
}

TEST(BlendedRotations, take_the_short_way_between_half_turns_about_neighbouring_axes)
{
    // Their quaternions come out of their matrices with opposite signs: the largest component is made positive.
    const Setting setting;
    const auto rotations =
        setting.blended({shapes::turn({1, -0.9, 0}, 180), shapes::turn({0.9, -1, 0}, 180)});
    const Matrix3 half = shapes::rotation({1, -1, 0}, 180);
    for (int i = 0; i < setting.graph.size(); ++i)
        if (!setting.graph.is_idle(i)) {
            EXPECT_LT(apart(rotations[i], half), 0.11); // six degrees
        }
}

TEST(HandedDownRotations, are_means_of_those_near_whatever_their_signs)
{
    const Setting setting;
    const ClusterMap map(setting.graph,
                         Clusters(setting.graph, setting.mesh.points(), setting.graph.size() / 4));
    const Points means = map.restrict(view(setting.mesh.points()));
    std::vector<Eigen::Quaterniond> twist;
    for (int p = 0; p < map.cluster_count(); ++p) {
        twist.emplace_back(Eigen::AngleAxisd(means(p, 0) / 20, Vector3::UnitX()));
        if (p % 2)
            twist.back().coeffs() *= -1;
    }
    for (int i = 0; i < setting.graph.size(); ++i)
        if (map.label()[i] >= 0) {
            EXPECT_LT(apart(handed_down(map, twist, i),
                            shapes::rotation({1, 0, 0}, setting.mesh.point(i).x() / 20 * 180 / shapes::pi)),
                      0.1); // a cluster is 2 wide
        }
}

} // namespace sinew::test_rotations

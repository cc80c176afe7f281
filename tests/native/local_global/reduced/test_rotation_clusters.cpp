// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/reduced/rotation_clusters.h"

#include "native/operators/laplacian.h"
#include "tests/native/dense.h"
#include "tests/native/shapes.h"

#include <memory>

namespace sinew::test_rotation_clusters {

constexpr int clusters = 6;

/// A bar whose ends are handles, with dense algebra.
struct Setting
{
    SurfaceMesh mesh = shapes::bar(12, 3);
    SparseMatrix L = laplacian_matrix(mesh, Discretization::cotan);
    std::vector<int> labels;
    MatrixX X, Z;
    std::unique_ptr<RotationClusters> reduced;

    Setting()
    {
        const int n = mesh.vertex_count();
        std::vector<int> free, held;
        MatrixX H = MatrixX::Zero(n, 8);
        const std::vector<Handle> ends = shapes::ends(mesh, 2);
        for (int v = 0; v < n; ++v) {
            const double x = mesh.point(v).x();
            labels.push_back(std::min(clusters - 1, static_cast<int>(x / 2.0001)));
            const int handle = x <= 2 ? 0 : x >= 10 ? 1 : -1;
            (handle < 0 ? free : held).push_back(v);
            if (handle >= 0)
                H.block<1, 4>(v, 4 * handle) << mesh.points().row(v), 1.0;
        }
        const ClusterLoads loads(L, mesh.points(), labels, clusters);
        const MatrixX A(L), B(loads.B), inner = A(free, free);
        const MatrixX outer = -dense::product(A(free, held), H(held, Eigen::all)), load = B(free, Eigen::all);
        const MatrixX by_poses = dense::solution(inner, outer), by_turns = dense::solution(inner, load);
        X = H;
        X(free, Eigen::all) = by_poses;
        Z = MatrixX::Zero(n, 3 * clusters);
        Z(free, Eigen::all) = by_turns;
        reduced = std::make_unique<RotationClusters>(loads.own, dense::product(B.transpose(), Z),
                                                     dense::product(B.transpose(), X),
                                                     dense::product(X.transpose(), dense::product(A, X)));
    }

    /// The points of a state.
    Points points(const RotationClusters::State& state) const
    {
        return shapes::transformed(mesh.points(), state.mean) + dense::product(X, state.poses) +
               dense::product(Z, state.turns);
    }

    /// F, term by term.
    double energy(const RotationClusters::State& state) const
    {
        const Points x = points(state);
        double sum = 0.0;
        for (int i = 0; i < mesh.vertex_count(); ++i)
            for (SparseMatrix::InnerIterator it(L, i); it; ++it)
                if (it.row() != i)
                    sum -= 0.25 * it.value() *
                           ((x.row(i) - x.row(it.row())).transpose() -
                            state.rotation(labels[i]) *
                                (mesh.points().row(i) - mesh.points().row(it.row())).transpose())
                               .squaredNorm();
        return sum;
    }
};

Poses bent() { return {shapes::still(), shapes::turn({0, 0.3, 1}, 90, {10, 0, 0}, {-4, 5, 1})}; }

std::vector<Matrix3> start(bool random)
{
    shapes::Random numbers(8);
    std::vector<Matrix3> rotations(clusters, Matrix3::Identity());
    for (Matrix3& R : rotations)
        if (random)
            R = shapes::rotation(numbers.vector(), 60 * numbers.unit());
    return rotations;
}

TEST(RotationClusters, has_the_energy_of_the_points_and_never_raises_it)
{
    const Setting bar;
    RotationClusters::State state = bar.reduced->start(bent(), start(true));
    double before = std::numeric_limits<double>::infinity();
    for (int turn = 0; turn < 60; ++turn) {
        const double F = bar.reduced->energy(state);
        EXPECT_NEAR(F, bar.energy(state), 1e-11 * F);
        EXPECT_LE(F, before * (1 + 1e-13));
        before = F;
        const RotationClusters::Settled settled = bar.reduced->settle(state, 1, 0.0);
        EXPECT_NEAR(settled.energy, bar.energy(state), 1e-11 * F);
    }
}

TEST(RotationClusters, two_unrelated_starts_meet_where_no_turn_lowers_the_energy)
{
    const Setting bar;
    Points found[2];
    for (bool random : {false, true}) {
        RotationClusters::State state = bar.reduced->start(bent(), start(random));
        const RotationClusters::Settled settled = bar.reduced->settle(state, 2000, 1e-12);
        EXPECT_TRUE(settled.converged);
        found[random] = bar.points(state);
        for (int k = 0; k < clusters; ++k)
            for (int axis = 0; axis < 3; ++axis) {
                const auto turned = [&](double degrees) {
                    RotationClusters::State other = state;
                    const Matrix3 R = shapes::rotation(Vector3::Unit(axis), degrees) * state.rotation(k);
                    other.rotations.middleRows<3>(3 * k) = R.transpose();
                    other.turns.middleRows<3>(3 * k) = (R - state.mean.leftCols<3>()).transpose();
                    return bar.reduced->energy(other);
                };
                const double slope = (turned(1e-3) - turned(-1e-3)) / 2e-3;
                EXPECT_NEAR(slope, 0.0, 1e-7 * settled.energy);
            }
    }
    EXPECT_LT(shapes::distance(found[0], found[1]), 1e-8);
}

TEST(RotationClusters, a_rigid_motion_leaves_nothing_to_turn)
{
    const Setting bar;
    const Pose pose = shapes::turn({1, 2, -0.5}, 170, {3, 7, 1}, {30, -20, 10});
    RowMatrix shares(clusters, 2);
    for (int k = 0; k < clusters; ++k)
        shares.row(k) << 1 - k / 5.0, k / 5.0;
    const Poses both{pose, pose};
    RotationClusters::State state =
        bar.reduced->start(both, mean_rotations(shares, both, rigid_mean(both).leftCols<3>()));
    EXPECT_LT(bar.reduced->settle(state, 5, 0.0).energy, 1e-24);
    EXPECT_LT(shapes::distance(bar.points(state), shapes::transformed(bar.mesh.points(), pose)), 1e-13);
}

} // namespace sinew::test_rotation_clusters

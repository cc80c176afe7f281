// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/deformation_transfer.h"

#include "tests/native/dense.h"
#include "tests/native/methods/multiresolution/codings.h"

#include <Eigen/LU>

namespace sinew::test_deformation_transfer {

namespace {

CodingTraits traits()
{
    return {.name = "DeformationTransfer",
            .make =
                [](const Study& study) {
                    return std::make_unique<DeformationTransfer>(
                        study.mesh, study.regions, view(study.fine()), view(study.base), study.rings);
                },
            .bent_up = 0.0199,
            .bent_down = 0.0192,
            .zero = 1e-12,
            .rigid = 1e-11,
            .similar = true};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(DeformationTransfer, CodingContract, testing::Values(traits()));

TEST(DeformationTransfer, solves_as_dense_gradients_do)
{
    const Study study(12);
    const SurfaceMesh& mesh = study.mesh;
    const int n = mesh.vertex_count(), faces = static_cast<int>(mesh.triangles().size());
    shapes::Random random(8);
    const Points moved = study.base * random.rotation() + 0.1 * random.dense(n, 3);
    MatrixX G = MatrixX::Zero(3 * faces, n), goal(3 * faces, 3);
    VectorX D(3 * faces);
    const auto frame = [](const Points& p, const Triangle& t) {
        Matrix3 F;
        F.col(0) = (p.row(t[1]) - p.row(t[0])).transpose();
        F.col(1) = (p.row(t[2]) - p.row(t[0])).transpose();
        F.col(2) = F.col(0).cross(F.col(1)); // twice the area
        return F;
    };
    for (int f = 0; f < faces; ++f) {
        const Triangle& t = mesh.triangles()[f];
        const Matrix3 F = frame(mesh.points(), t), slopes = F.transpose().inverse();
        G.block<3, 1>(3 * f, t[1]) = slopes.col(0);
        G.block<3, 1>(3 * f, t[2]) = slopes.col(1);
        G.block<3, 1>(3 * f, t[0]) = -slopes.col(0) - slopes.col(1);
        D.segment<3>(3 * f).setConstant(0.5 * F.col(2).norm());
        Matrix3 B = frame(study.base, t), B1 = frame(moved, t);
        // A normal times the root of the area, on both sides.
        for (Matrix3* side : {&B, &B1})
            side->col(2) /= std::sqrt(side->col(2).norm());
        goal.middleRows<3>(3 * f) = G.middleRows<3>(3 * f) * mesh.points() * (B1 * B.inverse()).transpose();
    }
    std::vector<int> free;
    for (int v = 0; v < n; ++v)
        if (study.regions.is_free(v))
            free.push_back(v);
    const MatrixX L = G.transpose() * D.asDiagonal() * G;
    const MatrixX x = dense::solution(L, G.transpose() * D.asDiagonal() * goal, moved, free);
    EXPECT_LT(shapes::distance(bumps::detailed(*traits().make(study), study.fine(), study.base, moved), x),
              1e-11);
}

TEST(DeformationTransfer, vertices_that_are_pulled_softly_go_where_their_vectors_lead)
{
    const SurfaceMesh mesh = shapes::sphere(3);
    const Components parts = connected_components(mesh);
    const Regions regions({{{0, 5, 9, 200}, {0.7, 0.7, 0.7, 0.7}}}, parts);
    const auto rings = std::make_shared<const RingRotations>(mesh);
    Points base;
    Fairing(mesh, regions, 2.0).smooth(view(mesh.points()), base);
    const Pose pose = shapes::turn({1, 1, 2}, 100, {1, 2, 3}, {5, -4, 6});
    const DeformationTransfer coding(mesh, regions, view(mesh.points()), view(base), rings);
    EXPECT_LT(shapes::distance(bumps::detailed(coding, mesh.points(), base, shapes::transformed(base, pose)),
                               shapes::transformed(mesh.points(), pose)),
              1e-11);
}

} // namespace sinew::test_deformation_transfer

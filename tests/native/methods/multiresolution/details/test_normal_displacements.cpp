// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/normal_displacements.h"

#include "native/mesh/trees/triangle_tree.h"
#include "tests/native/methods/multiresolution/codings.h"

#include <Eigen/Geometry>

namespace sinew::test_normal_displacements {

namespace {

std::unique_ptr<NormalDisplacements> coding_of(const Study& study)
{
    return std::make_unique<NormalDisplacements>(view(study.fine()), view(study.base), study.rings);
}

CodingTraits traits()
{
    return {.name = "NormalDisplacements", .make = coding_of, .bent_up = 0.0221, .bent_down = 0.0236};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(NormalDisplacements, CodingContract, testing::Values(traits()));

TEST(NormalDisplacements, every_vertex_stands_on_the_base_by_the_formula_of_the_paper)
{
    const Study study(40);
    const auto coding = coding_of(study);
    EXPECT_EQ(coding->vectors(), 0);
    std::vector<Vector3> normals(study.mesh.vertex_count(), Vector3::Zero());
    for (const Triangle& t : study.mesh.triangles()) {
        const Vector3 a = (study.base.row(t[1]) - study.base.row(t[0])).transpose(),
                      b = (study.base.row(t[2]) - study.base.row(t[0])).transpose();
        for (int v : t)
            normals[v] += a.cross(b);
    }
    int found = 0;
    for (int v = 0; v < study.mesh.vertex_count(); ++v) {
        const auto& foot_point = coding->foot_points()[v];
        if (foot_point.triangle < 0) {
            EXPECT_EQ(study.fine().row(v), study.base.row(v));
            continue;
        }
        ++found;
        const Triangle& t = study.mesh.triangles()[foot_point.triangle];
        Vector3 foot = Vector3::Zero(), n = Vector3::Zero();
        const double shares[3] = {1 - foot_point.u - foot_point.v, foot_point.u, foot_point.v};
        for (int k = 0; k < 3; ++k) {
            EXPECT_GT(shares[k], -1e-6);
            foot += shares[k] * study.base.row(t[k]).transpose();
            n += shares[k] * normals[t[k]].normalized();
        }
        EXPECT_LT((foot + foot_point.height * n.normalized() - study.mesh.point(v)).norm(), 1e-12);
    }
    EXPECT_GT(found, 1000);
}

TEST(NormalDisplacements, stand_around_the_closest_triangle_of_a_messy_base)
{
    // A base that is noisy, has flat faces, and crosses itself; what is closest is often not below its
    // vertex.
    const SurfaceMesh mesh = shapes::grid(24, 24, 1.0 / 24);
    shapes::Random random(12);
    Points coarse = mesh.points() + 0.01 * random.dense(mesh.vertex_count(), 3);
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (coarse(v, 0) > 0.5)
            coarse.row(v) = Eigen::RowVector3d(1 - coarse(v, 0), coarse(v, 1), coarse(v, 2) + 0.02);
    for (int v : {30, 31, 32, 55, 56, 57, 80, 81, 82, 200, 300})
        coarse.row(v) = coarse.row(55); // around 56, and at some more, faces are flat
    Points fine = coarse + 0.04 * random.dense(mesh.vertex_count(), 3);
    const auto rings = std::make_shared<const RingRotations>(mesh);
    const NormalDisplacements coding(view(fine), view(coarse), rings);
    const TriangleTree tree(shapes::list_of(coarse), mesh.triangles());
    int closest = 0, near = 0, vectors = 0;
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const auto& foot_point = coding.foot_points()[v];
        if (foot_point.triangle < 0) {
            ++vectors;
            continue;
        }
        const int expected = tree.closest_place(fine.row(v).transpose()).triangle;
        std::vector<int> around{expected};
        for (int ring = 0; ring < 2; ++ring)
            for (int t : std::vector<int>(around))
                for (int corner : mesh.triangles()[t])
                    around.insert(around.end(), rings->around(corner).begin(), rings->around(corner).end());
        closest += foot_point.triangle == expected;
        near += std::ranges::find(around, foot_point.triangle) != around.end();
    }
    EXPECT_EQ(near, mesh.vertex_count() - vectors);
    EXPECT_EQ(vectors, coding.vectors());
    EXPECT_GT(closest, mesh.vertex_count() / 3);
    EXPECT_LT(shapes::distance(bumps::detailed(coding, fine, coarse, coarse), fine), 1e-12);
}

TEST(NormalDisplacements, fold_over_in_a_tight_bend_where_vectors_do_not)
{
    const Study study(60);
    const double height = shapes::distance(study.fine(), study.base);
    const Points moved = bumps::bent(study.base, 200, 5 - 0.5 * 200 * shapes::pi / 180 * height / 1.27,
                                     5 + 0.5 * 200 * shapes::pi / 180 * height / 1.27);
    const Points x = bumps::detailed(*coding_of(study), study.fine(), study.base, moved);
    EXPECT_GT(bumps::turned_faces(study.mesh, study.base, moved, x), 0);
}

TEST(NormalDisplacements, details_that_stand_on_nothing_are_vectors_and_counted)
{
    // A tall fold that leans over the border of its base has no foot there.
    const SurfaceMesh mesh = shapes::hill(8, 8);
    Points coarse = mesh.points(), fine = mesh.points();
    fine.row(40) += Eigen::RowVector3d(30, 0, 0);
    const auto rings = std::make_shared<const RingRotations>(mesh);
    const NormalDisplacements coding(view(fine), view(coarse), rings);
    EXPECT_EQ(coding.vectors(), 1);
    const Pose pose = shapes::turn({1, 1, 2}, 100, {1, 2, 3}, {5, -4, 6});
    EXPECT_LT(shapes::distance(bumps::detailed(coding, fine, coarse, shapes::transformed(coarse, pose)),
                               shapes::transformed(fine, pose)),
              1e-12);
}

} // namespace sinew::test_normal_displacements

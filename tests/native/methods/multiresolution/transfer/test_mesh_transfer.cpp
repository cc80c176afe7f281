// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/transfer/mesh_transfer.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_mesh_transfer {

namespace {

/// Two spheres and a loose vertex.
SurfaceMesh spheres()
{
    const SurfaceMesh one = shapes::sphere(2);
    const int n = one.vertex_count();
    Points p(2 * n + 1, 3);
    p << one.points(), one.points().rowwise() + Eigen::RowVector3d(3, 1, 0), Eigen::RowVector3d(9, 0, 1);
    shapes::Polygons faces;
    for (int shift : {0, n})
        for (const Triangle& t : one.triangles())
            faces.push_back({t[0] + shift, t[1] + shift, t[2] + shift});
    return shapes::over(p, faces);
}

/// Wider, and higher at one end.
Points reshaped(const Points& points)
{
    Points found = points;
    found.col(0) *= 1.5;
    found.col(2).array() *= 1 + 0.1 * points.col(0).array();
    return found;
}

Points transferred(const SurfaceMesh& source, const SurfaceMesh& target, const Points& deformed)
{
    Points found;
    MeshTransfer(source, target).transfer(view(deformed), found);
    return found;
}

Points deformed(const SurfaceMesh& mesh)
{
    shapes::Random random(5);
    return reshaped(mesh.points()) * random.rotation() + 0.05 * random.dense(mesh.vertex_count(), 3);
}

} // namespace

TEST(MeshTransfer, a_target_like_the_source_is_deformed_as_the_source_in_its_own_size)
{
    const SurfaceMesh source = spheres();
    for (double size : {1.0, 0.4}) {
        const SurfaceMesh target = shapes::moved(source, size * source.points());
        EXPECT_LT(shapes::distance(transferred(source, target, deformed(source)), size * deformed(source)),
                  1e-11); // rounding of one solve
    }
}

TEST(MeshTransfer, a_source_that_is_turned_turns_a_target_of_any_shape)
{
    const SurfaceMesh source = spheres(), target = shapes::moved(source, reshaped(source.points()));
    const Pose turn = shapes::turn({1, -3, 2}, 130, {0, 0, 0}, {0, 0, 0});
    EXPECT_LT(shapes::distance(transferred(source, target, shapes::transformed(source.points(), turn)),
                               shapes::transformed(target.points(), turn)),
              1e-11);
    EXPECT_LT(shapes::distance(transferred(source, target, source.points()), target.points()), 1e-12);
}

TEST(MeshTransfer, steps_are_in_proportion_to_the_size)
{
    const SurfaceMesh source = shapes::sphere(2), target = shapes::moved(source, 3 * source.points());
    const Points step = source.points().rowwise() + Eigen::RowVector3d(1, 2, 3);
    const Points found = transferred(source, target, step);
    EXPECT_LT(shapes::distance(found, target.points().rowwise() + Eigen::RowVector3d(3, 6, 9)), 1e-11);
}

} // namespace sinew::test_mesh_transfer

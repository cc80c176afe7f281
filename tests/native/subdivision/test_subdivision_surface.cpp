// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/subdivision/subdivision_surface.h"

#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_subdivision_surface {

namespace {

Points refined(const SubdivisionSurface& surface, const Points& points)
{
    Points result(surface.vertex_count(), 3);
    surface.refine(points.data(), result.data());
    return result;
}

SubdivisionSurface subdivided(const SurfaceMesh& mesh, SubdivisionScheme scheme, int level,
                              bool limit = false)
{
    SubdivisionOptions options;
    options.scheme = scheme;
    options.level = level;
    options.limit = limit;
    return SubdivisionSurface(mesh, options);
}

constexpr SubdivisionScheme schemes[] = {SubdivisionScheme::catmull_clark, SubdivisionScheme::loop,
                                         SubdivisionScheme::bilinear};

} // namespace

TEST(SubdivisionSurface, rows_sum_to_one_and_affine_maps_pass_through)
{
    const Points whole = shapes::messy().points();
    shapes::Polygons faces = shapes::faces_of(shapes::messy());
    std::erase(faces, std::vector{40, 40, 41}); // a corner twice is refused
    const SurfaceMesh mesh = shapes::over(whole, faces);
    const Pose pose = shapes::affine(shapes::Random(2).matrix(), {1, 2, 3});
    for (SubdivisionScheme scheme : {SubdivisionScheme::catmull_clark, SubdivisionScheme::bilinear})
        for (bool limit : {false, true}) {
            SubdivisionOptions options;
            options.scheme = scheme;
            options.limit = limit;
            options.crease_edges = {{0, 1}, {10, 11}};
            options.crease_sharpness = {2.5, 10.0};
            options.corner_vertices = {30};
            options.corner_sharpness = {1.5};
            const SubdivisionSurface surface(mesh, options);
            const VectorX ones = surface.matrix() * VectorX::Ones(surface.control_count());
            EXPECT_LT((ones.array() - 1).abs().maxCoeff(), 1e-14);
            const Points a = refined(surface, shapes::transformed(whole, pose));
            const Points b = shapes::transformed(refined(surface, whole), pose);
            EXPECT_LT(shapes::distance(a, b), 1e-13 * shapes::size(b));
            EXPECT_TRUE(a.allFinite());
        }
}

TEST(SubdivisionSurface, announces_its_memory)
{
    const SurfaceMesh sheet = shapes::quad_grid(30, 30);
    {
        const MemoryLimit limit(1 << 20);
        EXPECT_THROW(subdivided(sheet, SubdivisionScheme::catmull_clark, 4), OutOfMemory);
        EXPECT_NO_THROW(subdivided(sheet, SubdivisionScheme::catmull_clark, 0));
    }
    EXPECT_THROW(subdivided(sheet, SubdivisionScheme::catmull_clark, 10), OutOfMemory); // 9e8 vertices
}

} // namespace sinew::test_subdivision_surface

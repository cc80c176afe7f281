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

// The published masks of a vertex of three faces, at each corner of the unit cube: the vertex point
// (F + 2 R + (n - 3) P) / n with F the mean of face points and R of edge middles.
TEST(SubdivisionSurface, catmull_clark_follows_the_published_rules_on_a_cube)
{
    const SurfaceMesh cube = shapes::cube();
    const SubdivisionSurface surface = subdivided(cube, SubdivisionScheme::catmull_clark, 1);
    ASSERT_EQ(surface.vertex_count(), 8 + 12 + 6);
    const Points fine = refined(surface, cube.points());
    for (int v = 0; v < 8; ++v) {
        const Vector3 inward = Vector3::Constant(0.5) - cube.point(v); // half an edge along each axis
        // Face points: (2/3) of the way by two axes each; edge middles: one axis of three each.
        const Vector3 F = cube.point(v) + 2.0 / 3.0 * inward, R = cube.point(v) + 1.0 / 3.0 * inward;
        EXPECT_LT((fine.row(v).transpose() - (F + 2.0 * R) / 3.0).norm(), 1e-15);
    }
    // Edge points: the mean of both ends and both face points; face points: the middles.
    EXPECT_EQ((fine.rowwise().norm().array() > 0).count(), 26);
    const double quarter = 0.125; // of the edge's middle, towards the cube's
    int edges = 0, faces = 0;
    for (int v = 8; v < 26; ++v) {
        const auto offset = (fine.row(v).array() - 0.5).abs().eval();
        const double inner = (offset < 1e-15).count();
        faces += inner == 2 && std::abs(offset.maxCoeff() - 0.5) < 1e-15;
        edges += inner == 1 && std::abs(offset.maxCoeff() - (0.5 - quarter)) < 1e-15;
    }
    EXPECT_EQ(faces, 6);
    EXPECT_EQ(edges, 12);
}

// Limit mask of Catmull-Clark for valence n: (n^2 P + 4 sum of edge neighbours + sum of face opposites) / n
// (n + 5); at a cube's corner every sum is along its diagonal.
TEST(SubdivisionSurface, limit_is_that_of_the_published_masks)
{
    const SurfaceMesh cube = shapes::cube();
    const Points limit = refined(subdivided(cube, SubdivisionScheme::catmull_clark, 0, true), cube.points());
    for (int v = 0; v < 8; ++v) {
        const Vector3 p = cube.point(v), across = Vector3::Ones() - 2 * p; // to the opposite corner
        const Vector3 expected = (9 * p + 4 * (3 * p + across) + 3 * p + 2 * across) / 24;
        EXPECT_LT((limit.row(v).transpose() - expected).norm(), 1e-15);
    }
    // Loop, valence 4: (P + (8 b / 3) sum of neighbours) / (1 + 8 b n / 3) with b = (5/8 - (3/8 + cos(2 pi /
    // n) / 4)^2) / n; the neighbours of an octahedron's corner sum to zero.
    const SurfaceMesh octahedron = shapes::octahedron();
    const Points smooth =
        refined(subdivided(octahedron, SubdivisionScheme::loop, 0, true), octahedron.points());
    const double b = (5.0 / 8.0 - 9.0 / 64.0) / 4.0;
    EXPECT_LT(shapes::distance(smooth, octahedron.points() / (1.0 + 8.0 * b * 4.0 / 3.0)), 1e-15);
}

// A point of the limit surface is one of every level.
TEST(SubdivisionSurface, limit_does_not_depend_on_the_level)
{
    for (SubdivisionScheme scheme : schemes) {
        const SurfaceMesh mesh = shapes::hill(4, 3);
        const Points coarse = refined(subdivided(mesh, scheme, 1, true), mesh.points());
        const Points fine = refined(subdivided(mesh, scheme, 3, true), mesh.points());
        EXPECT_LT(shapes::distance(coarse, fine.topRows(coarse.rows())), 1e-14 * shapes::size(coarse));
    }
}

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

// Regular inner vertices of a sheet in parameters: bicubic B-splines reproduce linear functions, so a flat
// sheet refines to a flat sheet and bilinear halves every quad.
TEST(SubdivisionSurface, bilinear_halves_quads)
{
    const SurfaceMesh sheet = shapes::quad_grid(3, 2);
    const Points fine = refined(subdivided(sheet, SubdivisionScheme::bilinear, 2), sheet.points());
    EXPECT_EQ(fine.rows(), 13 * 9);
    for (int v = 0; v < fine.rows(); ++v)
        EXPECT_EQ((4 * fine.row(v).array() - (4 * fine.row(v).array()).round()).abs().maxCoeff(), 0.0);
}

TEST(SubdivisionSurface, creases_and_corners_hold)
{
    const SurfaceMesh cube = shapes::cube();
    SubdivisionOptions options;
    options.level = 3;
    for (int f : {0, 1}) // the rims of bottom and top
        for (int k = 0; k < 4; ++k) {
            options.crease_edges.push_back({cube.face(f)[k], cube.face(f)[(k + 1) % 4]});
            options.crease_sharpness.push_back(10.0);
        }
    const Points rims = refined(SubdivisionSurface(cube, options), cube.points());
    EXPECT_DOUBLE_EQ(rims.col(2).maxCoeff(), 1.0);
    EXPECT_DOUBLE_EQ(rims.col(2).minCoeff(), 0.0);
    options.corner_vertices = {0, 1, 2, 3, 4, 5, 6, 7};
    options.corner_sharpness.assign(8, 10.0);
    EXPECT_EQ(refined(SubdivisionSurface(cube, options), cube.points()).topRows(8), cube.points());
}

TEST(SubdivisionSurface, open_corners_are_kept_by_choice)
{
    const SurfaceMesh sheet = shapes::quad_grid(2, 2);
    SubdivisionOptions options;
    EXPECT_GT(
        (refined(SubdivisionSurface(sheet, options), sheet.points()).row(0) - sheet.points().row(0)).norm(),
        0.1);
    options.boundary_smooth = BoundarySmooth::preserve_corners;
    EXPECT_EQ(refined(SubdivisionSurface(sheet, options), sheet.points()).row(0), sheet.points().row(0));
}

TEST(SubdivisionSurface, faces_are_four_a_quad_and_name_their_vertices)
{
    const SurfaceMesh cube = shapes::cube();
    const SubdivisionSurface surface = subdivided(cube, SubdivisionScheme::catmull_clark, 2);
    EXPECT_EQ(surface.face_counts(), std::vector<int>(6 * 16, 4));
    const SurfaceMesh fine(refined(surface, cube.points()), surface.face_counts(), surface.face_corners());
    EXPECT_EQ(fine.edges().size(), 2u * 6 * 16);
    // A closed surface around the middle: normals look away from it.
    const Points normals = surface.normals(view(fine.points()));
    const auto middle = Eigen::RowVector3d::Constant(0.5);
    for (int v = 0; v < fine.vertex_count(); ++v) {
        EXPECT_NEAR(normals.row(v).norm(), 1.0, 1e-14);
        EXPECT_GT(normals.row(v).dot(fine.points().row(v) - middle), 0.3);
    }
}

// Two quads side by side with separate values along the common edge.
TEST(SubdivisionSurface, face_varying_values_keep_their_seams)
{
    const SurfaceMesh sheet = shapes::quad_grid(2, 1);
    SubdivisionOptions options;
    options.level = 1;
    options.face_varying = {0, 1, 2, 3, 4, 5, 6, 7};
    for (UvSmooth smooth : {UvSmooth::none, UvSmooth::preserve_boundaries, UvSmooth::smooth_all}) {
        options.uv_smooth = smooth;
        const SubdivisionSurface surface(sheet, options);
        EXPECT_EQ(surface.face_varying_matrix().rows(), 18);
        EXPECT_EQ(surface.face_varying_matrix().cols(), 8);
        const VectorX sums = surface.face_varying_matrix() * VectorX::Ones(8);
        EXPECT_LT((sums.array() - 1).abs().maxCoeff(), 1e-15);
        ASSERT_EQ(surface.face_varying_corners().size(), surface.face_corners().size());
        // No refined value mixes both islands.
        VectorX island = VectorX::Zero(8);
        island.tail(4).setOnes();
        const VectorX mixed = surface.face_varying_matrix() * island;
        for (int k = 0; k < mixed.size(); ++k)
            EXPECT_TRUE(mixed[k] == 0.0 || mixed[k] == 1.0);
        // The island's corners stay unless all is smoothed.
        const bool kept = surface.face_varying_matrix().coeff(0, 0) == 1.0;
        EXPECT_EQ(kept, smooth != UvSmooth::smooth_all);
    }
}

TEST(SubdivisionSurface, level_zero_and_no_faces_are_the_mesh_itself)
{
    const SurfaceMesh mesh = shapes::hill(3, 3);
    EXPECT_EQ(refined(subdivided(mesh, SubdivisionScheme::loop, 0), mesh.points()), mesh.points());
    const SurfaceMesh loose = shapes::mesh({{0, 1, 2}, {3, 4, 5}}, {});
    const SubdivisionSurface surface = subdivided(loose, SubdivisionScheme::catmull_clark, 3, true);
    EXPECT_EQ(refined(surface, loose.points()), loose.points());
    EXPECT_EQ(surface.normals(view(loose.points())), Points::Zero(2, 3));
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

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/subdivision_editing.h"

#include "native/methods/surface/linear/thin_shell.h"
#include "native/subdivision/subdivision_surface.h"
#include "tests/native/methods/surface/fixture.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sinew::test_subdivision_editing {

namespace {

using Faces = shapes::Polygons;
using shapes::torus;

/// Quads over a hill without symmetry, with noise on every vertex.
SurfaceMesh rough_hill(int columns, int rows)
{
    const SurfaceMesh plain = shapes::quad_grid(columns, rows);
    Points p = plain.points();
    for (int i = 0; i < p.rows(); ++i)
        p(i, 2) = 2 * std::sin(3.0 * p(i, 0) / columns) * std::cos(2.0 * p(i, 1) / rows);
    return shapes::moved(plain, shapes::Random(5).shaken(p, 0.1));
}

/// The refined mesh of OpenSubdiv, whose first vertices are those of the control mesh.
SurfaceMesh refined(const SurfaceMesh& mesh, SubdivisionScheme scheme, int level)
{
    SubdivisionOptions options;
    options.scheme = scheme;
    options.level = level;
    const SubdivisionSurface surface(mesh, options);
    Points points(surface.vertex_count(), 3);
    surface.refine(mesh.points().data(), points.data());
    return {points, surface.face_counts(), surface.face_corners()};
}

/// The faces, each from its lowest corner on, sorted.
Faces sorted_faces(const SurfaceMesh& mesh)
{
    Faces faces = shapes::faces_of(mesh);
    for (std::vector<int>& face : faces)
        std::ranges::rotate(face, std::ranges::min_element(face));
    std::ranges::sort(faces);
    return faces;
}

/// The same mesh with its vertices and faces in another order.
SurfaceMesh shuffled(const SurfaceMesh& mesh, std::uint64_t seed)
{
    shapes::Random random(seed);
    const std::vector<int> place = random.shuffled(mesh.vertex_count());
    Points points(mesh.vertex_count(), 3);
    for (int v = 0; v < mesh.vertex_count(); ++v)
        points.row(place[v]) = mesh.points().row(v);
    Faces faces = shapes::faces_of(mesh);
    for (std::vector<int>& face : faces) {
        for (int& v : face)
            v = place[v];
        std::ranges::rotate(face, face.begin() + random.below(static_cast<int>(face.size())));
    }
    for (std::size_t f = faces.size(); f-- > 1;)
        std::swap(faces[f], faces[random.below(static_cast<int>(f) + 1)]);
    return shapes::over(points, faces);
}

/// A pentagon, a triangle and quads in an open surface, no vertex of which is like another.
SurfaceMesh polygons()
{
    return shapes::mesh({{0, 0, 0},
                         {2, 0, .1},
                         {4, 0, 0},
                         {0, 2, .3},
                         {2, 2, 1},
                         {4, 2, .2},
                         {1, 4, 0},
                         {3, 4, .4},
                         {6, 1, 0}},
                        {{0, 1, 4, 3}, {1, 2, 5, 4}, {3, 4, 5, 7, 6}, {2, 8, 5}});
}

struct Case
{
    SurfaceMesh mesh;
    SubdivisionScheme scheme;
};

std::vector<Case> control_meshes()
{
    constexpr auto quads = SubdivisionScheme::catmull_clark, triangles = SubdivisionScheme::loop;
    return {{shapes::cube(), quads},           {polygons(), quads},
            {shapes::bar(5, 2), quads},        {torus(7, 5), quads},
            {rough_hill(5, 3), quads},         {shapes::octahedron(), quads},
            {shapes::octahedron(), triangles}, {shapes::hill(5, 4), triangles},
            {shapes::sphere(1), triangles}};
}

class SubdivisionEditing : public SurfaceFixture<sinew::SubdivisionEditing, SubdivisionEditingOptions>
{
public:
    static SurfaceTraits traits()
    {
        SurfaceTraits made = linear("SubdivisionEditing", {{"automatic", maker({Coarsening::automatic, 1}),
                                                            3}, // the level, the control mesh, the band
                                                           {"two levels", maker({Coarsening::levels, 2}), 4},
                                                           {"no level", maker({Coarsening::levels, 0}), 1}});
        made.mesh = rough_hill(24, 16);
        made.large = rough_hill(28, 20);
        made.many = rough_hill(96, 64);
        made.bent = bent;
        made.many_enter = true;
        made.rest = made.incoming = 1e-13; // each level takes its details apart and puts them together
        made.translation = 1e-9;
        made.rigid = 1e-11; // rounding errors, carried through all levels
        made.similar = made.scaled = 1e-9;
        made.updates = "coarsening";
        made.updated = maker({Coarsening::levels, 1});
        return made;
    }
    static Method bound(const SurfaceMesh& mesh, int levels, const std::vector<Handle>& handles = {{{0}, {}}})
    {
        return SurfaceFixture::bound(mesh, {Coarsening::levels, levels}, handles);
    }
    static Points solved(const SurfaceMethod& method, const Poses& poses)
    {
        return solve(method, poses).positions;
    }

    inline static const Poses bent{shapes::still(), shapes::turn({0, 1, 0}, 40, {18, 0, 0}, {-1, 0.5, 2})};
};

} // namespace

INSTANTIATE_TEST_SUITE_P(SubdivisionEditing, SurfaceContract, testing::Values(SubdivisionEditing::traits()));

TEST_F(SubdivisionEditing, finds_the_control_meshes_of_opensubdiv)
{
    int number = 0;
    for (const auto& [control, scheme] : control_meshes()) {
        for (int level : {1, 2, 3}) {
            SCOPED_TRACE(std::to_string(number) + " at level " + std::to_string(level));
            const SurfaceMesh fine = refined(control, scheme, level);
            const Method editing = bound(fine, level);
            EXPECT_EQ(editing.level_counts(), std::vector<int>{level});
            const SurfaceMesh found = editing.control_mesh();
            EXPECT_EQ(sorted_faces(found), sorted_faces(control));
            ASSERT_EQ(found.vertex_count(), control.vertex_count());
            EXPECT_LT(shapes::distance(found.points(), control.points()), 1e-9)
                << "rounding, times the damping of what alternates on a cube";
        }
        ++number;
    }
}

TEST_F(SubdivisionEditing, finds_control_meshes_whatever_the_order_of_the_vertices)
{
    const SurfaceMesh control = shapes::bar(5, 2);
    for (std::uint64_t seed : {1, 2, 3, 4, 5, 6, 7, 8}) {
        const SurfaceMesh fine = shuffled(refined(control, SubdivisionScheme::catmull_clark, 2), seed);
        const SurfaceMesh found = bound(fine, 2).control_mesh();
        ASSERT_EQ(found.vertex_count(), control.vertex_count());
        ASSERT_EQ(found.face_count(), control.face_count());
        for (int v = 0; v < found.vertex_count(); ++v)
            EXPECT_LT((control.points().rowwise() - found.points().row(v)).rowwise().norm().minCoeff(), 1e-9);
    }
}

TEST_F(SubdivisionEditing, regular_meshes_keep_their_lowest_vertex)
{
    // Each of the four colourings of a torus is a subdivision.
    for (std::uint64_t seed : {1, 2, 3}) {
        const SurfaceMesh fine = shuffled(torus(12, 8), seed);
        const SurfaceMesh one = bound(fine, 1).control_mesh(), other = bound(fine, 1).control_mesh();
        EXPECT_EQ(one.vertex_count(), 24);
        EXPECT_EQ(one.points(), other.points());
        Eigen::Index nearest = -1;
        (one.points().rowwise() - fine.points().row(0)).rowwise().norm().minCoeff(&nearest);
        EXPECT_EQ(nearest, 0);
    }
    // Opposite corners of a torus of two quads around are one vertex.
    EXPECT_EQ(bound(torus(8, 8), 9).level_counts(), std::vector<int>{1});
    EXPECT_EQ(bound(torus(4, 4), 9).level_counts(), std::vector<int>{0});
}

TEST_F(SubdivisionEditing, what_alternates_on_a_cube_is_lost_and_stays_at_rest)
{
    // Catmull-Clark takes the shape that alternates from corner to corner of a cube to zero, so that a
    // control mesh is not unique. The fit does not add any of it.
    const SurfaceMesh fine = refined(shapes::cube(), SubdivisionScheme::catmull_clark, 1);
    const SurfaceMesh found = bound(fine, 1).control_mesh();
    EXPECT_LT(shapes::distance(found.points(), shapes::cube().points()), 1e-9);
    EXPECT_TRUE(solved(bound(fine, 1, shapes::ends(fine, 0.2)), bent).allFinite());
}

TEST_F(SubdivisionEditing, without_levels_is_a_thin_shell)
{
    const SurfaceMesh mesh = rough_hill(12, 8);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    ThinShell shell(mesh);
    shell.set_handles(handles);
    const Poses lift{shapes::still(), shapes::shift(1, -2, 3)};
    EXPECT_LT(shapes::distance(solved(bound(mesh, 0, handles), lift), solved(shell, lift)), 1e-10);
}

TEST_F(SubdivisionEditing, details_turn_with_the_surface)
{
    // Studs on a flat strip that is bent upwards stand on the bent strip as they stood on the flat one.
    const SurfaceMesh flat = shapes::quad_grid(64, 16, 0.25);
    Points p = flat.points();
    std::vector<int> studs;
    for (int v = 0; v < p.rows(); ++v)
        if (v % 65 % 8 == 5 && v / 65 % 4 == 2 && v % 65 > 12 && v % 65 < 52) {
            p(v, 2) = 0.1;
            studs.push_back(v);
        }
    const SurfaceMesh mesh = shapes::moved(flat, p);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Poses bend{shapes::still(), shapes::turn({0, 1, 0}, -80, {11, 0, 0})};
    const Points q = solved(bound(mesh, 3, handles), bend), base = solved(bound(flat, 3, handles), bend);
    double worst = 0.0, steepest = 0.0;
    for (int v : studs) {
        const Vector3 along = (base.row(v + 1) - base.row(v - 1)).transpose(),
                      across = (base.row(v + 65) - base.row(v - 65)).transpose();
        const Vector3 normal = along.cross(across).normalized();
        const auto height = [&](const Points& x) -> Vector3 {
            return (x.row(v) - 0.25 * (x.row(v - 1) + x.row(v + 1) + x.row(v - 65) + x.row(v + 65)))
                .transpose();
        };
        worst = std::max(worst, (height(q) - height(base) - 0.1 * normal).norm());
        steepest = std::max(steepest, std::acos(normal.z()));
    }
    EXPECT_GT(steepest, 0.8);
    EXPECT_LT(worst, 0.01) << "a tenth; details that keep their directions are wrong by 0.08 here";
}

TEST_F(SubdivisionEditing, sculpted_meshes_rest_and_move_rigidly_with_all_their_details)
{
    for (const auto& [control, scheme] : control_meshes()) {
        const SurfaceMesh smooth = refined(control, scheme, 2);
        const Points sculpted = shapes::Random(3).shaken(smooth.points(), 0.05),
                     incoming = shapes::Random(4).shaken(smooth.points(), 0.2);
        const SurfaceMesh fine = shapes::moved(smooth, sculpted);
        const std::vector<Handle> handles{{{0, 1}, {}}, {{fine.vertex_count() - 1}, {0.5}}};
        const Method editing = bound(fine, 2, handles);
        const Pose pose = shapes::turn({1, 2, -0.5}, 170, {3, 7, 1}, {3, -2, 1});
        for (const Points& y : {sculpted, incoming}) {
            Points q;
            editing.solve({.poses = Poses(2, shapes::still()), .incoming = view(y)}, q);
            EXPECT_LT(shapes::distance(q, y), 1e-13);
            editing.solve({.poses = {pose, pose}, .incoming = view(y)}, q);
            EXPECT_LT(shapes::distance(q, shapes::transformed(y, pose)), 1e-11);
        }
    }
}

TEST_F(SubdivisionEditing, a_part_that_cannot_be_undone_stays_whole_and_the_others_do_not_mind)
{
    const SurfaceMesh ball = shapes::sphere(3),
                      box = refined(shapes::cube(), SubdivisionScheme::catmull_clark, 3);
    const SurfaceMesh holed = shapes::without_face(box, box.face_count() - 1);
    const SurfaceMesh all = shapes::joined(shapes::joined(ball, holed, {0, 9, 0}), box, {0, 18, 0});
    const int n = ball.vertex_count(), m = box.vertex_count();
    const std::vector<Handle> handles{{{0, n, n + m}, {}}, {{1, n + 1, n + m + 1}, {}}};
    Method editing(all, {Coarsening::levels, 2});
    const BindReport report = editing.set_handles(handles);
    EXPECT_EQ(editing.level_counts(), (std::vector<int>{2, 0, 2}));
    EXPECT_EQ(report.irregular_parts, 1);
    ASSERT_EQ(static_cast<int>(report.irregular_vertices.size()), m);
    EXPECT_EQ(report.irregular_vertices.front(), n);
    const Poses poses{shapes::still(), shapes::turn({1, 2, 3}, 30, {0, 0, 0}, {0.1, 0.2, 0.3})};
    const Points q = solved(editing, poses);
    EXPECT_LT(shapes::distance(q.topRows(n), solved(bound(ball, 2, {{{0}, {}}, {{1}, {}}}), poses)), 1e-9);
    // With nothing to undo, nothing is told; and a small part is not an irregular one.
    EXPECT_EQ(Method(all, {Coarsening::levels, 0}).set_handles(handles).irregular_parts, 0);
    const SurfaceMesh small = refined(shapes::cube(), SubdivisionScheme::catmull_clark, 1);
    EXPECT_EQ(Method(small).set_handles({{{0}, {}}}).irregular_parts, 0);
}

TEST_F(SubdivisionEditing, tiny_and_odd_parts_are_no_subdivisions)
{
    const std::vector<SurfaceMesh> odd{
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2, 3}}),
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, {{0, 1, 2}}),
        // two quads and two triangles, back to back
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2, 3}, {3, 2, 1, 0}}),
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}}, {{0, 1, 2}, {2, 1, 0}}),
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 2, 3}, {0, 1, 2, 3}}),
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}}, {{0, 1, 0, 1}, {0, 1, 2, 3}}),
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {0, 0, 0}, {2, 0, 0}, {3, 1, 0}, {4, 0, 0}, {1, 2, 0}},
                     {{0, 1, 7}, {1, 2, 7}, {4, 5, 6}}),
        shapes::joined(shapes::octahedron(), shapes::quad_grid(1, 1), {5, 0, 0})};
    for (std::size_t k = 0; k < odd.size(); ++k) {
        SCOPED_TRACE(k);
        const std::vector<int> all = shapes::numbers(0, odd[k].vertex_count());
        Method editing(odd[k], {Coarsening::levels, 5});
        for (const std::vector<int>& vertices : {std::vector<int>{0}, all}) {
            editing.set_handles({{vertices, std::vector<double>(vertices.size(), 0.5)}});
            EXPECT_EQ(std::ranges::count(editing.level_counts(), 0), std::ssize(editing.level_counts()));
            EXPECT_TRUE(solved(editing, {shapes::shift(1, 2, 3)}).allFinite());
        }
    }
    // Two fans of faces that meet in one vertex, of which each alone could be undone.
    Faces fans = shapes::faces_of(shapes::quad_grid(2, 2));
    for (std::vector<int> face : shapes::faces_of(shapes::quad_grid(2, 2))) {
        for (int& v : face)
            v = v == 0 ? 8 : v + 8;
        fans.push_back(face);
    }
    Points p(17, 3);
    p << shapes::grid_points(2, 2),
        shapes::grid_points(2, 2).bottomRows(8).rowwise() + Eigen::RowVector3d(2, 2, 0);
    EXPECT_EQ(bound(shapes::over(p, fans), 1).level_counts(), std::vector<int>{0});
    EXPECT_EQ(bound(shapes::quad_grid(2, 2), 1).level_counts(), std::vector<int>{1});
}

TEST_F(SubdivisionEditing, parts_without_area_are_solved_or_refused)
{
    for (double thickness : {0.0, 1e-9, 1.0}) {
        Points p = shapes::grid_points(8, 8);
        p.col(1) *= thickness;
        const SurfaceMesh mesh = shapes::moved(shapes::quad_grid(8, 8), p);
        try {
            EXPECT_TRUE(solved(bound(mesh, 2, {{{0, 1, 2}, {}}, {{80}, {}}}),
                               {shapes::still(), shapes::shift(0, 0, 1)})
                            .allFinite());
        } catch (const FactorizationFailed&) {
            EXPECT_EQ(thickness, 0.0);
        }
    }
}

TEST_F(SubdivisionEditing, two_handles_may_hold_the_vertices_of_one_quad)
{
    // And so two handles pull at each control point, which neither holds alone.
    const SurfaceMesh mesh = rough_hill(24, 16);
    Handle left, right;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        (v % 25 < 12 ? left : right).vertices.push_back(v);
    right.vertices.resize(right.vertices.size() - 20);
    const Method editing = bound(mesh, 3, {left, right});
    const Points q = solved(editing, bent);
    for (int v : left.vertices)
        EXPECT_EQ(q.row(v), mesh.points().row(v));
    for (int v : right.vertices)
        EXPECT_LT((q.row(v).transpose() - apply(bent[1], mesh.point(v))).norm(), 1e-13);
    EXPECT_TRUE(q.allFinite());
    EXPECT_LT(shapes::distance(q, mesh.points()), 40);
}

TEST_F(SubdivisionEditing, leaves_its_handles_without_a_crease)
{
    // The border of the handle lies across the faces of the control mesh.
    const SurfaceMesh mesh = shapes::quad_grid(48, 32);
    std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    handles[1].vertices = shapes::where(mesh, [](const Vector3& p) {
        return std::abs(p.x() - 25.0 + 0.3 * p.y()) < 5 && std::abs(p.y() - 15) < 6;
    });
    const Poses lift{shapes::still(), shapes::shift(0, 0, 6)};
    const auto sharpest = [&](const Points& q) {
        double most = 0.0;
        for (int v = 0; v < mesh.vertex_count(); ++v)
            if (v % 49 > 0 && v % 49 < 48 && v / 49 > 0 && v / 49 < 32)
                most = std::max({most, std::abs(q(v - 1, 2) - 2 * q(v, 2) + q(v + 1, 2)),
                                 std::abs(q(v - 49, 2) - 2 * q(v, 2) + q(v + 49, 2))});
        return most;
    };
    ThinShell shell(mesh);
    shell.set_handles(handles);
    const double smooth = sharpest(solved(shell, lift));
    for (int levels : {1, 2, 3})
        EXPECT_LT(sharpest(solved(bound(mesh, levels, handles), lift)), 2.5 * smooth) << levels;
}

TEST_F(SubdivisionEditing, levels_above_the_memory_limit_are_refused_before_they_are_made)
{
    const SurfaceMesh mesh = rough_hill(128, 128);
    Method editing(mesh, {Coarsening::levels, 5});
    editing.set_handles(shapes::ends(mesh, 1.5));
    const Points before = solved(editing, bent);
    for (std::int64_t limit : {1'000, 1'000'000, 5'000'000}) {
        const MemoryLimit most(limit);
        EXPECT_THROW(editing.set_handles(shapes::ends(mesh, 2.5)), OutOfMemory) << limit;
        EXPECT_EQ(solved(editing, bent), before);
    }
}

} // namespace sinew::test_subdivision_editing

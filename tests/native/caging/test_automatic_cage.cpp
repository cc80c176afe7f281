// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/caging/automatic_cage.h"

#include "native/caging/cage_diagnosis.h"
#include "native/mesh/frames/surface_frame.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <map>
#include <set>

namespace sinew::test_automatic_cage {

namespace {

/// A wide margin: a wrap of a few hundred faces, which takes little time.
constexpr double wide = 0.06;

SurfaceMesh mesh_of(const AutomaticCage& cage) { return {cage.points, cage.counts, cage.corners}; }

/// Whether the segment (a, b) goes through the triangle, in doubles; shares no code with the cage.
bool pierces(const Vector3& a, const Vector3& b, const Vector3& p, const Vector3& q, const Vector3& r)
{
    Matrix3 m;
    m << b - a, p - q, p - r;
    const Vector3 x = m.fullPivLu().solve(p - a);
    return (m * x - (p - a)).norm() < 1e-9 && x.minCoeff() >= 0 && x[0] <= 1 && x[1] + x[2] <= 1;
}

/// What a cage has inside: the vertices of faces, or all where there is no face.
std::vector<int> enclosed(const SurfaceMesh& target)
{
    std::set<int> in_faces;
    for (const Triangle& t : target.triangles())
        in_faces.insert(t.begin(), t.end());
    for (int v = 0; target.triangles().empty() && v < target.vertex_count(); ++v)
        in_faces.insert(v);
    return {in_faces.begin(), in_faces.end()};
}

/// Closed, outward, embedded and around the target, as far as edges and a few rays can tell.
void expect_good(const AutomaticCage& cage, const SurfaceMesh& target)
{
    const SurfaceMesh mesh = mesh_of(cage);
    const Points inside = target.points()(enclosed(target), Eigen::all);
    EXPECT_EQ(summary(diagnose_cage(mesh, view(inside))), "clean");
    std::map<std::pair<int, int>, int> balance;
    for (const Triangle& t : mesh.triangles())
        for (int k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3];
            balance[std::minmax(a, b)] += a < b ? 1 : -1;
        }
    for (const auto& [edge, sum] : balance)
        EXPECT_EQ(sum, 0);
    // A ray from each point leaves through one face more than it enters by.
    for (Eigen::Index v = 0; v < inside.rows(); v += 1 + inside.rows() / 30) {
        const Vector3 a = inside.row(v).transpose(),
                      b = a + 1e3 * shapes::size(target.points()) * Vector3(.31, .52, .79);
        int crossings = 0;
        for (const auto& [i, j, k] : mesh.triangles())
            crossings += pierces(a, b, mesh.point(i), mesh.point(j), mesh.point(k));
        EXPECT_EQ(crossings % 2, 1) << v;
    }
    EXPECT_GT(cage.report.clearance, 0.0);
}

} // namespace

TEST(AutomaticCage, encloses_in_as_many_faces_as_asked)
{
    const SurfaceMesh targets[] = {shapes::sphere(3), shapes::bar(8, 2), shapes::hill(12, 12),
                                   shapes::torus(40, 20), shapes::messy()};
    for (const SurfaceMesh& target : targets)
        for (int faces : {60, 150}) {
            const AutomaticCage cage = automatic_cage(target, {.faces = faces, .margin = wide});
            expect_good(cage, target);
            EXPECT_TRUE(cage.report.reached);
            EXPECT_LE(cage.report.faces, faces + 1);
            EXPECT_GE(cage.report.faces, faces - 2);
        }
}

TEST(AutomaticCage, leaves_out_vertices_without_a_face)
{
    // The last one, 20 from all others, would make a spike of the cage or a second part.
    const SurfaceMesh target = shapes::messy();
    const AutomaticCage cage = automatic_cage(target, {.faces = 60, .margin = wide});
    EXPECT_EQ(diagnose_cage(mesh_of(cage), view(target.points())).outside_points,
              std::vector<int>{target.vertex_count() - 1});
    const Points faces = target.points().topRows(target.vertex_count() - 1);
    EXPECT_LT(cage.points.col(1).maxCoeff(), faces.col(1).maxCoeff() + 3 * wide * shapes::size(faces));
}

TEST(AutomaticCage, keeps_parts_and_holes)
{
    const SurfaceMesh ring = shapes::torus(40, 20);
    const AutomaticCage cage = automatic_cage(ring, {.faces = 200, .margin = 0.03});
    expect_good(cage, ring);
    const SurfaceMesh around = mesh_of(cage);
    const int euler = around.vertex_count() - static_cast<int>(around.edges().size()) + around.face_count();
    EXPECT_EQ(euler, 0); // one hole, as the ring

    const SurfaceMesh two = shapes::joined(shapes::sphere(2), shapes::sphere(2), {5, 1, 0});
    const AutomaticCage apart = automatic_cage(two, {.faces = 150, .margin = 0.03});
    expect_good(apart, two);
    EXPECT_EQ(diagnose_cage(mesh_of(apart)).component_count, 2);
}

TEST(AutomaticCage, mirrors_where_the_target_does)
{
    const SurfaceMesh bar = shapes::bar(8, 2); // about y = 0 and z = 0, and x = 4
    for (auto symmetry : {AutomaticCageOptions::Symmetry::automatic, AutomaticCageOptions::Symmetry::y}) {
        const AutomaticCage cage = automatic_cage(bar, {.faces = 100, .margin = wide, .symmetry = symmetry});
        expect_good(cage, bar);
        const int axis = symmetry == AutomaticCageOptions::Symmetry::y ? 1 : 0;
        ASSERT_EQ(cage.report.mirror_axis, axis);
        const double middle = axis == 0 ? 4.0 : 0.0;
        const SurfaceMesh mesh = mesh_of(cage);
        std::vector<int> image;
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            Vector3 p = mesh.point(v);
            p[axis] = 2 * middle - p[axis];
            int best = 0;
            for (int w = 0; w < mesh.vertex_count(); ++w)
                if ((mesh.point(w) - p).norm() < (mesh.point(best) - p).norm())
                    best = w;
            EXPECT_LT((mesh.point(best) - p).norm(), 1e-14 * 9);
            image.push_back(best);
        }
        std::set<std::vector<int>> faces;
        const auto rotated = [](std::vector<int> face) {
            std::ranges::rotate(face, std::ranges::min_element(face));
            return face;
        };
        for (const auto& face : shapes::faces_of(mesh))
            faces.insert(rotated(face));
        for (auto face : shapes::faces_of(mesh)) {
            std::ranges::reverse(face);
            for (int& v : face)
                v = image[v];
            EXPECT_TRUE(faces.contains(rotated(face)));
        }
    }
    const AutomaticCage none =
        automatic_cage(bar, {.faces = 100, .margin = wide, .symmetry = AutomaticCageOptions::Symmetry::none});
    EXPECT_EQ(none.report.mirror_axis, -1);
    // No plane of symmetry, but one is asked for: the target and its image are inside.
    const SurfaceMesh hill = shapes::hill(12, 12);
    expect_good(
        automatic_cage(hill, {.faces = 100, .margin = wide, .symmetry = AutomaticCageOptions::Symmetry::x}),
        hill);
}

TEST(AutomaticCage, says_how_much_the_sides_differ)
{
    const SurfaceMesh bar = shapes::bar(8, 2);
    EXPECT_NEAR(automatic_cage(bar, {.faces = 60, .margin = wide}).report.asymmetry, 0.0, 1e-12);
    // One of eight corners, moved by `depth` along each axis: its mirror image is that deep in the bar, and
    // the image of the opposite corner is no farther from the bar than the corner has moved. About the
    // centroid, which the dent moves, images lie elsewhere by up to twice its way.
    Eigen::Index corner = 0;
    bar.points().rowwise().sum().maxCoeff(&corner);
    for (double depth : {0.4, 0.7}) {
        Points points = bar.points();
        points.row(corner).array() -= depth;
        const SurfaceMesh dented = shapes::moved(bar, points);
        const AutomaticCageReport report = automatic_cage(dented, {.faces = 60, .margin = wide}).report;
        EXPECT_EQ(report.mirror_axis, -1);
        const SurfaceFrame frame = surface_frame(dented);
        const double shift = 2.0 * (frame.centre - Vector3(4, 0, 0)).cwiseAbs().maxCoeff();
        EXPECT_GE(report.asymmetry * frame.size, depth * 0.999 - shift);
        EXPECT_LE(report.asymmetry * frame.size, std::sqrt(3.0) * depth * 1.001 + shift);
        EXPECT_EQ(automatic_cage(
                      dented, {.faces = 60, .margin = wide, .symmetry = AutomaticCageOptions::Symmetry::none})
                      .report.asymmetry,
                  0.0);
    }
}

TEST(AutomaticCage, joins_triangles_into_quads_that_are_safe_along_both_diagonals)
{
    const SurfaceMesh target = shapes::bar(8, 2);
    const AutomaticCage cage = automatic_cage(target, {.faces = 120, .margin = wide, .quads = true});
    expect_good(cage, target);
    EXPECT_GT(2 * cage.report.quads, cage.report.faces / 2); // more faces of quads than triangles left
    for (int first : {0, 1}) {
        shapes::Polygons cut;
        for (const auto& face : shapes::faces_of(mesh_of(cage))) {
            const std::size_t k = face.size();
            for (std::size_t j = 2; j < k; ++j)
                cut.push_back({face[first], face[(first + j - 1) % k], face[(first + j) % k]});
        }
        EXPECT_EQ(summary(diagnose_cage(shapes::over(cage.points, cut), view(target.points()))), "clean");
    }
}

// The sanitizer takes ten times as long for the same numbers: two sizes show it all of the code.
#ifdef __SANITIZE_ADDRESS__
const std::vector<int> sizes_of_cages = {12, 100};
#else
const std::vector<int> sizes_of_cages = {12, 16, 24, 40, 64, 100};
#endif

TEST(AutomaticCage, no_diagonal_of_a_quad_is_an_edge_or_a_diagonal_of_another)
{
    using Symmetry = AutomaticCageOptions::Symmetry;
    for (const SurfaceMesh& target :
         {shapes::sphere(2), shapes::bar(8, 2), shapes::hill(12, 12), shapes::torus(40, 20)})
        for (int faces : sizes_of_cages)
            for (Symmetry symmetry : {Symmetry::none, Symmetry::x, Symmetry::y}) {
                const AutomaticCage cage = automatic_cage(
                    target, {.faces = faces, .margin = 0.1, .symmetry = symmetry, .quads = true});
                std::map<std::pair<int, int>, int> used; // sides count half, as two faces have each
                for (const auto& face : shapes::faces_of(mesh_of(cage))) {
                    for (std::size_t k = 0; k < face.size(); ++k)
                        ++used[std::minmax(face[k], face[(k + 1) % face.size()])];
                    if (face.size() == 4)
                        for (int k : {0, 1})
                            used[std::minmax(face[k], face[k + 2])] += 2;
                }
                for (const auto& [pair, times] : used)
                    EXPECT_EQ(times, 2) << faces << ": " << pair.first << " " << pair.second;
                EXPECT_EQ(summary(diagnose_cage(mesh_of(cage), view(target.points()))), "clean");
            }
}

TEST(AutomaticCage, says_how_many_faces_were_asked_for_and_why_there_are_more)
{
    for (int faces : {12, 60}) {
        const AutomaticCageReport report =
            automatic_cage(shapes::torus(40, 20), {.faces = faces, .margin = wide}).report;
        EXPECT_EQ(report.wanted, faces);
        EXPECT_EQ(report.reached, report.faces <= faces + 1);
        EXPECT_EQ(report.reason.empty(), report.reached);
        EXPECT_EQ(report.reached, faces == 60) << "a ring needs more than twelve";
    }
}

// Loose triangles wrap into a surface of many holes, which no collapse may close: a wider margin does.
TEST(AutomaticCage, widens_the_margin_where_the_wrap_has_too_many_holes)
{
    shapes::Random random(11);
    std::vector<Vector3> points;
    shapes::Polygons faces;
    for (int t = 0; t < 60; ++t) {
        const Vector3 at = 2 * random.vector();
        for (int k = 0; k < 3; ++k)
            points.push_back(at + random.vector());
        faces.push_back({3 * t, 3 * t + 1, 3 * t + 2});
    }
    const SurfaceMesh target = shapes::mesh(points, faces);
    const AutomaticCage cage = automatic_cage(target, {.faces = 60, .margin = 0.03});
    expect_good(cage, target);
    EXPECT_TRUE(cage.report.reached);
    EXPECT_GT(cage.report.margin, 0.03);
}

TEST(AutomaticCage, takes_flat_open_and_loose_targets_of_any_scale)
{
    const SurfaceMesh flat = shapes::grid(6, 6);
    expect_good(automatic_cage(flat, {.faces = 40, .margin = wide}), flat);
    const std::vector<Vector3> corners{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {3, 3, 3}};
    const SurfaceMesh one = shapes::mesh({corners.begin(), corners.end() - 1}, {{0, 1, 2}});
    const AutomaticCage cage = automatic_cage(one, {.faces = 80, .margin = wide});
    expect_good(cage, one);
    const SurfaceMesh loose = shapes::mesh(corners, {{0, 1, 2}}), cloud = shapes::mesh(corners, {});
    EXPECT_EQ(automatic_cage(loose, {.faces = 80, .margin = wide}).points, cage.points);
    expect_good(automatic_cage(cloud, {.faces = 80, .margin = wide}), cloud);
    const SurfaceMesh line = shapes::mesh({{0, 0, 0}, {1, 0, 0}, {2, 0, 0}}, {{0, 1, 2}});
    expect_good(automatic_cage(line, {.faces = 40, .margin = wide}), line);
    for (double scale : {1e-6, 1e6}) {
        const SurfaceMesh sphere =
            shapes::moved(shapes::sphere(2), Points((scale * shapes::sphere(2).points()).rowwise() +
                                                    scale * Eigen::RowVector3d(100, 0, 0)));
        expect_good(automatic_cage(sphere, {.faces = 60, .margin = wide}), sphere);
    }
}

TEST(AutomaticCage, is_the_same_on_any_number_of_threads)
{
    const SurfaceMesh target = shapes::hill(12, 12);
    const AutomaticCage many = automatic_cage(target, {.faces = 80, .margin = wide});
    const ThreadLimit limit(1);
    const AutomaticCage one = automatic_cage(target, {.faces = 80, .margin = wide});
    EXPECT_EQ(one.points, many.points);
    EXPECT_EQ(one.corners, many.corners);
}

} // namespace sinew::test_automatic_cage

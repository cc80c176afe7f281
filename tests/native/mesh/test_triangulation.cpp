// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/triangulation.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sinew::test_triangulation {

namespace {

struct Cut
{
    std::vector<Triangle> triangles;
    double signed_area = 0.0; ///< of the triangles, along the polygon's own area vector
    double area = 0.0;        ///< of the triangles, all positive
    double polygon_area = 0.0;
};

Vector3 area_vector(const Points& p, const std::vector<int>& loop)
{
    Vector3 sum = Vector3::Zero();
    for (std::size_t k = 0; k < loop.size(); ++k) {
        const Vector3 a = p.row(loop[k]).transpose();
        const Vector3 b = p.row(loop[(k + 1) % loop.size()]).transpose();
        sum += 0.5 * a.cross(b);
    }
    return sum;
}

Cut cut(const std::vector<Vector3>& corners)
{
    const Points points = shapes::points_of(corners);
    const std::vector<int> loop = shapes::numbers(0, static_cast<int>(corners.size()));
    Cut result;
    triangulate(points, loop, result.triangles);
    const Vector3 whole = area_vector(points, loop);
    result.polygon_area = whole.norm();
    for (const Triangle& t : result.triangles) {
        const Vector3 part = area_vector(points, {t[0], t[1], t[2]});
        result.area += part.norm();
        result.signed_area += part.dot(whole.normalized());
    }
    return result;
}

/// Each corner is used, and every side of the polygon belongs to one triangle, run as given.
void expect_triangulation(const Cut& result, int corners)
{
    ASSERT_EQ(result.triangles.size(), static_cast<std::size_t>(corners - 2));
    std::map<std::pair<int, int>, int> sides;
    for (const Triangle& t : result.triangles)
        for (int k = 0; k < 3; ++k)
            ++sides[{t[k], t[(k + 1) % 3]}];
    for (int k = 0; k < corners; ++k)
        EXPECT_EQ((sides[{k, (k + 1) % corners}]), 1) << "side " << k;
}

/// A simple polygon seen from its area vector is covered once: no triangle is turned over.
void expect_cover(const Cut& result, int corners)
{
    expect_triangulation(result, corners);
    // Sums of some hundred products of coordinates of size 10: rounding alone.
    EXPECT_NEAR(result.signed_area, result.polygon_area, 1e-12 * result.polygon_area);
    EXPECT_NEAR(result.area, result.polygon_area, 1e-12 * result.polygon_area);
}

std::vector<Vector3> comb(int teeth)
{
    std::vector<Vector3> p{{0, 0, 0}, {2.0 * teeth, 0, 0}};
    for (int k = teeth - 1; k >= 0; --k)
        for (const auto& [x, y] : {std::pair{2.0, 1.0}, {1.9, 8.0}, {0.3, 8.0}, {0.2, 1.0}})
            p.emplace_back(2 * k + x, y, 0);
    return p;
}

std::vector<Vector3> spiral(int turns)
{
    std::vector<Vector3> p;
    const int steps = 12 * turns;
    for (int k = 0; k <= steps; ++k)
        p.emplace_back((1 + 0.2 * k) * std::cos(k * shapes::pi / 6),
                       (1 + 0.2 * k) * std::sin(k * shapes::pi / 6), 0);
    for (int k = steps; k >= 0; --k)
        p.emplace_back((2 + 0.2 * k) * std::cos(k * shapes::pi / 6),
                       (2 + 0.2 * k) * std::sin(k * shapes::pi / 6), 0);
    std::ranges::reverse(p);
    return p;
}

} // namespace

TEST(Triangulation, covers_convex_and_concave_polygons)
{
    std::vector<Vector3> convex;
    for (int k = 0; k < 17; ++k)
        convex.emplace_back(3 * std::cos(2 * shapes::pi * k / 17), std::sin(2 * shapes::pi * k / 17), 0);
    expect_cover(cut(convex), 17);
    expect_cover(cut({{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {2, 1, 0}, {0, 4, 0}}), 5);
    expect_cover(cut(comb(6)), 26);
    expect_cover(cut(spiral(2)), 50);
}

TEST(Triangulation, covers_random_star_shaped_polygons_in_any_plane)
{
    shapes::Random random(3);
    for (int trial = 0; trial < 50; ++trial) {
        const Matrix3 R = random.rotation();
        const Vector3 centre = 5 * random.vector();
        const int corners = 5 + random.below(20);
        std::vector<Vector3> p;
        for (int k = 0; k < corners; ++k) {
            const double angle = 2 * shapes::pi * (k + 0.8 * random.unit()) / corners;
            p.push_back(centre + R * (0.2 + random.unit()) * Vector3(std::cos(angle), std::sin(angle), 0));
        }
        expect_cover(cut(p), corners);
    }
}

TEST(Triangulation, concave_quads_are_cut_through_their_reflex_corner)
{
    const std::vector<Vector3> arrow{{0, 0, 0}, {4, 1, 0}, {0, 2, 0}, {1, 1, 0}};
    for (int start = 0; start < 4; ++start) {
        std::vector<Vector3> p = arrow;
        std::ranges::rotate(p, p.begin() + start);
        expect_cover(cut(p), 4);
    }
}

TEST(Triangulation, quads_take_the_diagonal_of_the_better_triangles)
{
    // A long kite: its short diagonal gives two fair triangles, its long one two needles.
    const Cut kite = cut({{0, 0, 0}, {5, -1, 0}, {10, 0, 0}, {5, 1, 0}});
    EXPECT_EQ(kite.triangles, (std::vector<Triangle>{{0, 1, 3}, {1, 2, 3}}));
}

TEST(Triangulation, keeps_the_orientation_of_a_polygon_that_is_not_planar)
{
    shapes::Random random(5);
    for (int trial = 0; trial < 30; ++trial) {
        std::vector<Vector3> p;
        for (int k = 0; k < 8; ++k) {
            const double angle = shapes::pi * k / 4;
            p.emplace_back(std::cos(angle), std::sin(angle), 0.2 * random.signed_unit());
        }
        const Cut result = cut(p);
        expect_triangulation(result, 8);
        // Whatever the cuts, the triangles' area vectors add up to the polygon's.
        EXPECT_NEAR(result.signed_area, result.polygon_area, 1e-12);
    }
}

TEST(Triangulation, polygons_without_an_ear_still_become_k_minus_2_triangles)
{
    const std::vector<Vector3> bow_tie{{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 2, 0}, {-1, 1, 0}};
    expect_triangulation(cut(bow_tie), 5);
    std::vector<Vector3> line, point(6, Vector3(1, 2, 3)), star;
    for (int k = 0; k < 7; ++k) {
        line.emplace_back(k, 2 * k, -k);
        star.emplace_back(std::cos(6 * shapes::pi * k / 7), std::sin(6 * shapes::pi * k / 7), 0);
    }
    expect_triangulation(cut(line), 7);
    expect_triangulation(cut(point), 6);
    expect_triangulation(cut(star), 7);
    expect_triangulation(cut(std::vector<Vector3>(4, Vector3::Zero())), 4);
}

TEST(Triangulation, covers_a_ring_that_is_cut_open_along_a_narrow_slit)
{
    const double slit = 1e-6;
    const Cut ring = cut({{slit, 0, 0},
                          {4, 0, 0},
                          {4, 4, 0},
                          {0, 4, 0},
                          {0, slit, 0},
                          {1, 1 + slit, 0},
                          {1, 3, 0},
                          {3, 3, 0},
                          {3, 1, 0},
                          {1 + slit, 1, 0}});
    expect_cover(ring, 10);
    EXPECT_NEAR(ring.area, 12, 1e-5); // 16 less the hole of 4 and the slit
}

/// A star-shaped outline around a star-shaped hole, joined by a slit of no width: two corners at each end of
/// it.
std::vector<Vector3> ring(shapes::Random& random, int outer, int inner, const Matrix3& R)
{
    const auto loop = [&](int corners, double least) {
        std::vector<Vector3> p;
        for (int k = 0; k < corners; ++k) {
            const double angle = 2 * shapes::pi * (k + (k > 0 ? 0.4 * random.signed_unit() : 0.0)) / corners;
            p.push_back(R * (least + random.unit()) * Vector3(std::cos(angle), std::sin(angle), 0));
        }
        p.push_back(p.front());
        return p;
    };
    std::vector<Vector3> p = loop(outer, 3.0), hole = loop(inner, 0.5);
    p.insert(p.end(), hole.rbegin(), hole.rend());
    return p;
}

TEST(Triangulation, covers_rings_with_a_slit_of_no_width_from_every_corner)
{
    std::vector<Vector3> square{{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                                {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
    for (std::size_t start = 0; start < square.size(); ++start) {
        const Cut result = cut(square);
        expect_cover(result, 10);
        EXPECT_NEAR(result.area, 12, 1e-12) << "from corner " << start; // 16 less the hole of 4
        std::ranges::rotate(square, square.begin() + 1);
    }
    shapes::Random random(7);
    for (int trial = 0; trial < 50; ++trial) {
        const int outer = 5 + random.below(12), inner = 5 + random.below(12);
        std::vector<Vector3> p = ring(random, outer, inner, random.rotation());
        for (std::size_t start = 0; start < p.size(); ++start) {
            expect_cover(cut(p), outer + inner + 2);
            std::ranges::rotate(p, p.begin() + 1);
        }
    }
}

TEST(Triangulation, does_not_depend_on_the_scale)
{
    const std::vector<Vector3> unit = comb(3);
    const Cut reference = cut(unit);
    for (double scale : {0x1p-40, 0x1p-20, 0x1p20, 0x1p40}) { // exact, so that ties stay ties
        std::vector<Vector3> p = unit;
        for (Vector3& x : p)
            x *= scale;
        EXPECT_EQ(cut(p).triangles, reference.triangles) << scale;
    }
}

} // namespace sinew::test_triangulation

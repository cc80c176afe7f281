// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/thin_shell.h"

#include "tests/native/shapes.h"

#include <Eigen/LU>
#include <gtest/gtest.h>

#include <cmath>
#include <string>

// The ring 1 <= r <= 2: lifted by 1 at r = 1, held at r = 2. Eq. 12 has closed solutions there.

namespace sinew::test_thin_shell_annulus {

namespace {

struct Annulus
{
    SurfaceMesh mesh;
    std::vector<Handle> handles; ///< what lies inside r = 1 and outside r = 2
    std::vector<int> middle;     ///< vertices at r = 1.5
};

/// `cells` rings between r = 1 and 2, `depth` more on either side, six sectors a ring and cell.
Annulus annulus(int cells, int depth)
{
    const int sectors = 6 * cells;
    const int rings = cells + 2 * depth + 1;
    std::vector<Vector3> p;
    shapes::Polygons faces;
    std::vector<int> inner, outer, middle;
    for (int i = 0; i < rings; ++i)
        for (int j = 0; j < sectors; ++j) {
            const double r = 1 + static_cast<double>(i - depth) / cells;
            const double angle = 2 * shapes::pi * (j + 0.5 * (i % 2)) / sectors;
            if (i <= depth)
                inner.push_back(static_cast<int>(p.size()));
            if (i >= cells + depth)
                outer.push_back(static_cast<int>(p.size()));
            if (i == depth + cells / 2)
                middle.push_back(static_cast<int>(p.size()));
            p.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
        }
    const auto v = [&](int i, int j) { return i * sectors + j % sectors; };
    for (int i = 0; i + 1 < rings; ++i)
        for (int j = 0; j < sectors; ++j) {
            const int far = i % 2 ? j + 1 : j; // odd rings are turned by half a sector
            faces.push_back({v(i, j), v(i + 1, far), v(i, j + 1)});
            faces.push_back({v(i + 1, i % 2 ? j : j), v(i + 1, j + 1), i % 2 ? v(i, j) : v(i, j + 1)});
        }
    return {shapes::mesh(p, faces), {{inner, {}}, {outer, {}}}, middle};
}

double height(int cells, int depth, const ThinShellOptions& options, double continuity = 2.0)
{
    Annulus ring = annulus(cells, depth);
    for (Handle& handle : ring.handles)
        handle.continuity = continuity;
    ThinShell shell(ring.mesh, options);
    shell.set_handles(ring.handles);
    Points positions;
    shell.solve({{shapes::shift(0, 0, 1), shapes::still()}}, positions);
    double mean = 0.0;
    for (int m : ring.middle)
        mean += positions(m, 2) / static_cast<double>(ring.middle.size());
    for (int m : ring.middle) // the mesh has the symmetry of its sectors
        EXPECT_NEAR(positions(m, 2), mean, 1e-6);
    return mean;
}

ThinShellOptions stiffness(double stretching, double bending, double variation = 0.0)
{
    return {.stretching = {stretching}, .bending = {bending}, .variation = {variation}};
}

/// Zero slope between the last two constrained rings is off by half a ring: the error is of first
/// order in h, and halving h twice lets Richardson take the first two orders away.
void expect_first_order(const ThinShellOptions& options, int depth, double exact, double extrapolated,
                        double continuity = 2.0)
{
    const double coarse = height(8, depth, options, continuity);
    const double middle = height(16, depth, options, continuity);
    const double fine = height(32, depth, options, continuity);
    EXPECT_NEAR(fine, exact, 3e-3);
    EXPECT_NEAR((middle - exact) / (fine - exact), 2.0, 0.2);
    const double first = 2 * middle - coarse, second = 2 * fine - middle;
    EXPECT_NEAR((4 * second - first) / 3, exact, extrapolated);
}

/// Radial solutions of Delta^3 u = 0: 1, ln r, r^2, r^2 ln r, r^4, r^4 ln r.
using Solutions = Eigen::Matrix<double, 1, 6>;

Solutions values(double r)
{
    const double l = std::log(r), q = r * r;
    return Solutions{1, l, q, q * l, q * q, q * q * l};
}

Solutions slopes(double r)
{
    const double l = std::log(r), c = r * r * r;
    return Solutions{0, 1 / r, 2 * r, 2 * r * l + r, 4 * c, 4 * c * l + c};
}

/// Slope of Delta u = u'' + u' / r.
Solutions slopes_of_laplacian(double r)
{
    return Solutions{0, 0, 0, 4 / r, 32 * r, 32 * r * std::log(r) + 32 * r};
}

/// Second derivative of u.
Solutions curvatures(double r)
{
    const double l = std::log(r), q = r * r;
    return Solutions{0, -1 / q, 2, 2 * l + 3, 12 * q, 12 * q * l + 7 * q};
}

/// u(1.5) for value 1 and 0 and slope 0 at the borders, and `third` = 0 there.
template <class Third>
double triharmonic(Third&& third)
{
    Eigen::Matrix<double, 6, 6> K;
    K << values(1), values(2), slopes(1), slopes(2), third(1), third(2);
    Eigen::Matrix<double, 6, 1> border;
    border << 1, 0, 0, 0, 0, 0;
    return values(1.5) * K.fullPivLu().solve(border);
}

} // namespace

TEST(ThinShellAnnulus, membrane_is_logarithmic)
{
    // 1 - ln 1.5 / ln 2. No slope is asked for, so the error is of second order.
    const double exact = 0.4150375;
    const double coarse = height(8, 0, stiffness(1, 0)), fine = height(16, 0, stiffness(1, 0));
    EXPECT_NEAR(fine, exact, 1e-6);
    EXPECT_LT(std::abs(fine - exact), 0.4 * std::abs(coarse - exact));
}

TEST(ThinShellAnnulus, thin_plate) { expect_first_order(stiffness(0, 1), 1, 0.4584346, 1e-4); }

TEST(ThinShellAnnulus, membrane_and_plate_together)
{
    expect_first_order(stiffness(1, 1), 1, 0.4575608, 1e-4);
    expect_first_order(stiffness(1, 0.1), 1, 0.4512592, 1e-4);
}

TEST(ThinShellAnnulus, minimum_variation)
{
    EXPECT_NEAR(triharmonic(curvatures), 0.4687138, 5e-8); // the closed form, to its digits
    expect_first_order(stiffness(0, 0, 1), 2, 0.4687138, 2e-4);
}

TEST(ThinShellAnnulus, deeper_handles_change_nothing)
{
    // A handle of two rings is all that the plate sees, of three what order 3 sees. Rounding of
    // systems of condition 1e6 and more.
    EXPECT_NEAR(height(8, 1, stiffness(0, 1)), height(8, 3, stiffness(0, 1)), 1e-8);
    EXPECT_NEAR(height(8, 2, stiffness(0, 0, 1)), height(8, 4, stiffness(0, 0, 1)), 1e-7);
}

TEST(ThinShellAnnulus, plate_and_minimum_variation_left_at_c0_are_the_membrane)
{
    // Without the handles' own curvature the harmonic surface has no bending energy at all.
    EXPECT_NEAR(height(16, 1, stiffness(0, 1), 0.0), height(16, 1, stiffness(1, 0)), 1e-8);
    EXPECT_NEAR(height(8, 2, stiffness(0, 0, 1), 0.0), height(8, 2, stiffness(1, 0)), 1e-6);
}

TEST(ThinShellAnnulus, minimum_variation_left_at_c1_keeps_the_slope_alone)
{
    // The third condition becomes natural: the slope of the curvature vanishes at the border.
    expect_first_order(stiffness(0, 0, 1), 2, triharmonic(slopes_of_laplacian), 2e-4, 1.0);
}

TEST(ThinShellAnnulus, continuity_blends_from_c0_to_c2)
{
    double before = height(8, 1, stiffness(0, 1), 0.0);
    for (double continuity : {0.25, 0.5, 0.75, 1.0}) {
        const double now = height(8, 1, stiffness(0, 1), continuity);
        EXPECT_GT(now, before);
        before = now;
    }
    EXPECT_NEAR(before, height(8, 1, stiffness(0, 1), 2.0), 1e-9); // a plate has no more to give
    before = height(8, 2, stiffness(0, 0, 1), 1.0);
    for (double continuity : {1.25, 1.5, 2.0}) {
        const double now = height(8, 2, stiffness(0, 0, 1), continuity);
        EXPECT_GT(std::abs(now - before), 1e-6);
        before = now;
    }
}

} // namespace sinew::test_thin_shell_annulus

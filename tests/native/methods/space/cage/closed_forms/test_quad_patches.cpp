// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/closed_forms/quad_patches.h"

#include "native/methods/space/cage/closed_forms/gauss_rules.h"
#include "tests/native/methods/space/cage/cages.h"
#include "tests/native/wide_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <vector>

namespace sinew::test_quad_patches {

namespace {

using Seven = Eigen::Matrix<double, 7, 1>;

/// The bilinear patch at (s, t) in [-1, 1]^2.
Vector3 on_patch(const std::array<Vector3, 4>& p, double s, double t)
{
    return 0.25 * ((1 - s) * (1 - t) * p[0] + (1 + s) * (1 - t) * p[1] + (1 + s) * (1 + t) * p[2] +
                   (1 - s) * (1 + t) * p[3]);
}

/// The seven integrals by Gauss's rule on pieces that are halved until they are small seen from x: no closed
/// form, no complex plane.
Seven by_pieces(const std::array<Vector3, 4>& p, const Vector3& x)
{
    static constexpr GaussRule rule = gauss_rule(10);
    Seven sum = Seven::Zero();
    const auto at = [&](double s, double t) { return on_patch(p, s, t); };
    const std::function<void(double, double, double, double, int)> piece = [&](double s0, double s1,
                                                                               double t0, double t1,
                                                                               int depth) {
        const double s = 0.5 * (s0 + s1), t = 0.5 * (t0 + t1);
        const double reach = std::max((at(s0, t0) - at(s1, t1)).norm(), (at(s0, t1) - at(s1, t0)).norm());
        if ((at(s, t) - x).norm() < 1.5 * reach && depth < 45) {
            piece(s0, s, t0, t, depth + 1);
            piece(s, s1, t0, t, depth + 1);
            piece(s0, s, t, t1, depth + 1);
            piece(s, s1, t, t1, depth + 1);
            return;
        }
        for (int i = 0; i < rule.count; ++i)
            for (int j = 0; j < rule.count; ++j) {
                const double u = s + 0.5 * (s1 - s0) * rule.node(i), v = t + 0.5 * (t1 - t0) * rule.node(j);
                const Vector3 r = at(u, v) - x;
                const Vector3 to_u = 0.25 * ((1 - v) * (p[1] - p[0]) + (1 + v) * (p[2] - p[3]));
                const Vector3 to_v = 0.25 * ((1 - u) * (p[3] - p[0]) + (1 + u) * (p[2] - p[1]));
                const double w =
                    0.25 * (s1 - s0) * (t1 - t0) * rule.weight(i) * rule.weight(j) / (4 * shapes::pi);
                const double layer = w * r.dot(to_u.cross(to_v)) / std::pow(r.norm(), 3), pole = w / r.norm();
                Seven part;
                part << layer, u * layer, v * layer, u * v * layer, pole, u * pole, v * pole;
                sum += part;
            }
    };
    piece(-1, 1, -1, 1, 0);
    return sum;
}

/// A box of twelve triangles but for its first face, a quad with these corners.
SurfaceMesh box_under(const std::array<Vector3, 4>& p)
{
    std::vector<Vector3> points(p.begin(), p.end());
    const Vector3 down = -3.0 * ((p[2] - p[0]).cross(p[3] - p[1])).normalized();
    for (const Vector3& corner : p)
        points.push_back(corner + down);
    shapes::Polygons faces{{0, 1, 2, 3}, {4, 6, 5}, {4, 7, 6}};
    for (int k = 0; k < 4; ++k) {
        const int a = k, b = (k + 1) % 4;
        faces.push_back({a, 4 + a, b});
        faces.push_back({b, 4 + a, 4 + b});
    }
    return shapes::mesh(points, faces);
}

/// What the patch says, in the frame of the geometry.
struct Patch
{
    Cage cage;
    std::vector<char> faces;
    CageGeometry geometry;
    QuadPatches patches;
    std::array<Vector3, 4> corners;

    explicit Patch(const std::array<Vector3, 4>& p)
        : cage(box_under(p)), faces(QuadPatches::faces(cage)), geometry(cage, faces),
          patches(cage, geometry, faces)
    {
        EXPECT_EQ(patches.count(), 1);
        for (int k = 0; k < 4; ++k)
            corners[static_cast<std::size_t>(k)] = geometry.normalized(cage.rest().point(k));
    }
    Seven at(const Vector3& x, bool* is_near = nullptr) const
    {
        MatrixX row = MatrixX::Zero(1, cage.vertex_count() + 3);
        VectorX winding = VectorX::Zero(1);
        std::vector<QuadPatches::Place> near(1);
        patches.add({x}, cage.vertex_count(), row, winding, near);
        if (is_near)
            *is_near = near[0].q >= 0;
        const auto w = row.row(0);
        Seven moments;
        moments << winding[0], (w[1] + w[2]) - (w[0] + w[3]), (w[2] + w[3]) - (w[0] + w[1]),
            (w[0] + w[2]) - (w[1] + w[3]), w[8], w[9], w[10];
        EXPECT_NEAR(w.head(4).sum(), winding[0], 1e-13);
        return moments;
    }
};

const std::vector<std::array<Vector3, 4>>& quads()
{
    static const std::vector<std::array<Vector3, 4>> some{
        {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1, 1, 0), Vector3(0, 1, 0)},
        {Vector3(0, 0, 0), Vector3(1, 0, 0), Vector3(1.7, 1, 0), Vector3(0.7, 1, 0)},
        {Vector3(0, 0, 0), Vector3(2, 0, 0), Vector3(1.3, 1, 0), Vector3(0.4, 1, 0)},
        {Vector3(0, 0, 0.3), Vector3(1, 0, -0.2), Vector3(1.1, 0.9, 0.4), Vector3(-0.1, 1.2, -0.3)},
        {Vector3(0, 0, 0), Vector3(4, 0, 0.3), Vector3(4, 0.6, -0.3), Vector3(0, 0.5, 0.2)}};
    return some;
}

} // namespace

TEST(GaussRule, integrates_polynomials)
{
    for (int n = 1; n <= most_gauss_nodes; ++n) {
        const GaussRule rule = gauss_rule(n);
        for (int power = 0; power < 2 * n; ++power) {
            double sum = 0.0;
            for (int k = 0; k < n; ++k)
                sum += rule.weight(k) * std::pow(rule.node(k), power);
            EXPECT_NEAR(sum, power % 2 ? 0.0 : 2.0 / (power + 1), 4e-15) << n << " nodes, power " << power;
        }
    }
}

TEST(QuadPatches, have_the_integrals_of_pieces_far_near_and_very_near)
{
    shapes::Random random(4);
    for (const auto& quad : quads()) {
        const Patch patch(quad);
        const double size = (patch.corners[2] - patch.corners[0]).norm(),
                     normal = patch.patches.rest_normal(0, 0).norm();
        std::array<int, 2> counts{};
        for (int i = 0; i < 330; ++i) {
            const double s = random.signed_unit(), t = random.signed_unit();
            const Vector3 on = on_patch(patch.corners, s, t),
                          x = i < 300
                                  ? on + size * std::pow(10.0, 1.2 * random.signed_unit() - 0.6) *
                                             random.vector()
                                  : on + std::pow(-0.01, 1 + i % 3) * patch.patches.normal({0, s, t, 0.0});
            bool is_near = false;
            Seven off = patch.at(x, &is_near) - by_pieces(patch.corners, x);
            off.tail<3>() *= normal; // psi counts times it, as in what they are for; measured up to 2e-12
            ++counts[is_near];
            EXPECT_LT(off.cwiseAbs().maxCoeff(), 1e-11) << i << ": " << x.transpose();
        }
        EXPECT_GT(std::min(counts[0], counts[1]), 40);
    }
}

TEST(QuadPatches, find_the_closest_place)
{
    shapes::Random random(7);
    for (const auto& quad : quads()) {
        const Patch patch(quad);
        for (int i = 0; i < 200; ++i) {
            const Vector3 x = 0.5 * random.vector();
            const QuadPatches::Place place = patch.patches.closest(0, x);
            double least = 1e9;
            for (int a = 0; a <= 60; ++a)
                for (int b = 0; b <= 60; ++b) {
                    const Vector3 on = on_patch(patch.corners, a / 30.0 - 1, b / 30.0 - 1);
                    least = std::min(least, (on - x).norm());
                }
            EXPECT_LE(place.distance, least + 1e-12);
        }
    }
}

TEST(QuadPatches, leave_out_darts_and_flat_quads)
{
    Points p = shapes::cube().points();
    p.row(6) = 0.9 * p.row(4) + 0.05 * (p.row(5) + p.row(7)); // one corner pushed in: a dart on top
    EXPECT_EQ(QuadPatches::faces(Cage(shapes::moved(shapes::cube(), p))),
              (std::vector<char>{1, 0, 1, 1, 1, 1}));
}

TEST(QuadKernels, agree_to_the_last_bit)
{
    shapes::Random random(8);
    QuadPatch patch;
    NearPatch near;
    for (double* vector :
         {patch.centre, patch.along, patch.across, patch.twist, patch.normal[0], patch.normal[1],
          patch.normal[2], near.along, near.across, near.twist, near.offset})
        Vector3::Map(vector) = random.vector();
    near.low = -1.3, near.high = 0.7;
    near.height[0] = 0.3, near.height[1] = 0.1, near.lean[0] = -0.2, near.lean[1] = 0.4;
    std::array<Vector3, 8> x;
    std::array<double, 8> places;
    for (int k = 0; k < 8; ++k) {
        x[k] = Vector3(6, 5, 4) + random.vector();
        places[k] = random.signed_unit();
    }
    static constexpr GaussRule rule = gauss_rule(6), other = gauss_rule(5);
    const auto of = [&](const QuadKernels& kernels) {
        std::vector<double> all(7 * 8 + 4 * 8);
        for (int first = 0; first < 8; first += kernels.lanes) {
            double points[24], moments[56];
            for (int lane = 0; lane < kernels.lanes; ++lane)
                for (int axis = 0; axis < 3; ++axis)
                    points[axis * kernels.lanes + lane] = x[first + lane][axis];
            kernels.moments(patch, points, rule.pairs, 6, other.pairs, 5, moments);
            for (int k = 0; k < 7; ++k)
                std::copy_n(moments + k * kernels.lanes, kernels.lanes, all.begin() + 8 * k + first);
        }
        kernels.lines(near, places.data(), 8, all.data() + 56);
        return all;
    };
    const std::vector<double> plain = of(QuadKernels::baseline);
    for (const double value : plain)
        EXPECT_TRUE(std::isfinite(value));
    for (const QuadKernels* kernels : wide_kernels<QuadKernels>())
        EXPECT_EQ(of(*kernels), plain);
}

} // namespace sinew::test_quad_patches

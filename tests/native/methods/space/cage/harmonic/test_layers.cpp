// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic/layers.h"

#include "native/methods/space/cage/closed_forms/gauss_rules.h"
#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <vector>

namespace sinew::test_layers {

namespace {

/// A triangle in space, as the kernels want it.
struct Example
{
    std::array<Vector3, 3> p;
    std::array<LayerEdge, 3> edges;
    std::array<double, 6> corners;
    LayerPanel panel{};
    LayerTriangle triangle{};

    explicit Example(const std::array<Vector3, 3>& at) : p(at)
    {
        const Vector3 x = (p[1] - p[0]).normalized();
        const Vector3 n = (p[1] - p[0]).cross(p[2] - p[0]).normalized(), y = n.cross(x);
        std::array<Eigen::Vector2d, 3> q;
        for (int k = 0; k < 3; ++k) {
            q[k] = {(p[k] - p[0]).dot(x), (p[k] - p[0]).dot(y)};
            corners[2 * k] = q[k].x();
            corners[2 * k + 1] = q[k].y();
        }
        panel.double_area = (p[1] - p[0]).cross(p[2] - p[0]).norm();
        std::array<Eigen::Vector2d, 3> m, gradient;
        for (int k = 0; k < 3; ++k) {
            const Eigen::Vector2d side = q[(k + 1) % 3] - q[k], s = side.normalized();
            m[k] = {s.y(), -s.x()};
            edges[k] = {k,        (k + 1) % 3,    s.x(),       s.y(),      m[k].x(),
                        m[k].y(), m[k].dot(q[k]), s.dot(q[k]), side.norm()};
        }
        for (int c = 0; c < 3; ++c) {
            panel.corner[c] = panel.edge[c] = c;
            panel.turn[c] = 1;
            panel.inverse_height[c] = edges[(c + 1) % 3].length / panel.double_area;
            gradient[c] = -panel.inverse_height[c] * m[(c + 1) % 3];
            for (int k = 0; k < 3; ++k)
                panel.slope[c][k] = gradient[c].dot(m[k]);
        }
        LayerFace& face = triangle.face;
        Vector3::Map(face.origin) = p[0];
        Vector3::Map(face.x) = x;
        Vector3::Map(face.y) = y;
        Vector3::Map(face.n) = n;
        face.corners = face.edges = 3;
        face.panels = 1;
        face.corner = corners.data();
        face.edge = edges.data();
        face.panel = &panel;
        triangle.diagonal = 1;
        triangle.product = gradient[1].dot(gradient[2]);
        for (int k = 0; k < 3; ++k)
            triangle.along[k] = gradient[1].dot(Eigen::Vector2d(edges[k].sx, edges[k].sy));
    }

    /// The fields of both() by Gauss's rule on pieces, halved until they are small beside their distance.
    std::array<double, 7> by_quadrature(const Vector3& x) const
    {
        static constexpr GaussRule rule = gauss_rule(6);
        Matrix3 triangle;
        triangle << p[0], p[1], p[2];
        const Vector3 normal = (p[1] - p[0]).cross(p[2] - p[0]).normalized();
        std::array<double, 7> sums{};
        std::vector<Matrix3> pieces{Matrix3::Identity()}; // the hats at three corners
        while (!pieces.empty()) {
            const Matrix3 hats = pieces.back(), q = triangle * hats;
            pieces.pop_back();
            const Vector3 middle = q.rowwise().mean();
            if ((q.colwise() - middle).colwise().norm().maxCoeff() > 0.3 * (middle - x).norm()) {
                Matrix3 middles; // of the sides
                middles << hats.col(1) + hats.col(2), hats.col(2) + hats.col(0), hats.col(0) + hats.col(1);
                pieces.insert(pieces.end(), 4, 0.5 * middles);
                for (int c = 0; c < 3; ++c)
                    pieces[pieces.size() - 1 - c].col(c) = hats.col(c);
                continue;
            }
            const double twice = (q.col(1) - q.col(0)).cross(q.col(2) - q.col(0)).norm();
            for (int i = 0; i < rule.count; ++i)
                for (int j = 0; j < rule.count; ++j) { // a square, one side of which is a corner
                    const double u = 0.5 + 0.5 * rule.node(i), v = 0.5 + 0.5 * rule.node(j);
                    const Vector3 h = hats * Vector3(1 - u, u * (1 - v), u * v), away = triangle * h - x;
                    const double w = rule.weight(i) * rule.weight(j) * u * twice / (16 * shapes::pi);
                    const double twofold = w * normal.dot(away) / std::pow(away.norm(), 3);
                    for (int c = 0; c < 3; ++c) {
                        sums[c] += twofold * h[c];
                        sums[4 + c] += w / away.norm() * h[c];
                    }
                    sums[3] += twofold * h[1] * h[2];
                }
        }
        return sums;
    }
};

std::array<double, 7> fields(const LayerKernels& kernels, const Example& example, const Vector3& x)
{
    std::array<double, 24> points;
    for (int k = 0; k < 3; ++k)
        for (int lane = 0; lane < 8; ++lane)
            points[8 * k + lane] = x[k];
    std::array<double, 56> out;
    kernels.both(example.triangle, points.data(), 8, 8, out.data());
    std::array<double, 7> result;
    for (int k = 0; k < 7; ++k)
        result[k] = out[8 * k + 7];
    return result;
}

const Example example({Vector3{.1, .2, -.3}, Vector3{.9, .1, .2}, Vector3{.3, .8, .4}});

Vector3 near(const Vector3& hats, double depth)
{
    const Vector3 n = (example.p[1] - example.p[0]).cross(example.p[2] - example.p[0]).normalized();
    return hats[0] * example.p[0] + hats[1] * example.p[1] + hats[2] * example.p[2] - depth * n;
}

} // namespace

TEST(HarmonicLayers, equal_quadrature)
{
    // Poles at 3.3 times the size of a piece leave a relative error of some 6^-12 in each.
    for (const Vector3& x :
         {Vector3(0, 0, 0), Vector3(5, -3, 2), near({.3, .3, .4}, .1), near({.3, .3, .4}, -.1),
          near({-.2, .5, .7}, .05), near({.5, .5, 0}, .02), near({1, 0, 0}, -.03)}) {
        const auto found = fields(LayerKernels::baseline, example, x);
        const auto expected = example.by_quadrature(x);
        for (int k = 0; k < 7; ++k)
            EXPECT_NEAR(found[k], expected[k], 1e-8) << k << " at " << x.transpose();
    }
}

TEST(HarmonicLayers, double_layer_close_to_the_face_is_half_of_the_data)
{
    for (const Vector3& hats : {Vector3(.2, .3, .5), Vector3(.98, .01, .01), Vector3(.001, .499, .5)})
        for (double side : {1.0, -1.0}) {
            const auto found = fields(LayerKernels::baseline, example, near(hats, side * 1e-10));
            for (int c = 0; c < 3; ++c)
                EXPECT_NEAR(found[c], side * hats[c] / 2, 1e-8);
            EXPECT_NEAR(found[3], side * hats[1] * hats[2] / 2, 1e-8);
        }
}

TEST(HarmonicLayers, are_finite_on_corners_edges_and_the_face)
{
    for (const Vector3& hats : {Vector3(1, 0, 0), Vector3(0, 1, 0), Vector3(0, 0, 1), Vector3(.5, .5, 0),
                                Vector3(.3, 0, .7), Vector3(.2, .3, .5), Vector3(2, -1, 0)})
        for (double depth : {0.0, 1e-9, -1e-9, 1e-17})
            for (double field : fields(LayerKernels::baseline, example, near(hats, depth)))
                EXPECT_LT(std::abs(field), 1.0) << hats.transpose() << " " << depth;
}

TEST(HarmonicLayers, single_layer_is_continuous_across_edges)
{
    for (const Vector3& hats : {Vector3(.5, .5, 0), Vector3(0, 1, 0)}) {
        const auto on = fields(LayerKernels::baseline, example, near(hats, 0));
        const auto beside = fields(LayerKernels::baseline, example, near(hats, 1e-9));
        for (int k = 4; k < 7; ++k)
            EXPECT_NEAR(on[k], beside[k], 1e-7); // its slope at an edge grows as log(1 / distance)
    }
}

TEST(HarmonicLayers, give_the_same_bits_with_wider_instructions)
{
    shapes::Random random(1);
    std::vector<double> points(24), plain(32);
    for (double& p : points)
        p = random.signed_unit();
    LayerKernels::baseline.single(example.triangle.face, points.data(), 8, 8, plain.data());
    for (const LayerKernels* kernels : wide_kernels<LayerKernels>()) {
        for (int k = 0; k < 200; ++k) {
            const Vector3 x = k % 2 ? near(random.vector(), 1e-9 * k) : Vector3(random.vector());
            EXPECT_EQ(fields(LayerKernels::baseline, example, x), fields(*kernels, example, x));
        }
        std::vector<double> wide(32);
        kernels->single(example.triangle.face, points.data(), 8, 8, wide.data());
        EXPECT_EQ(plain, wide);
    }
    for (int lane = 0; lane < 8; ++lane) { // and the whole face as a pattern of one panel
        const Vector3 x(points[lane], points[8 + lane], points[16 + lane]);
        for (int c = 0; c < 3; ++c)
            EXPECT_NEAR(plain[4 * lane + c], fields(LayerKernels::baseline, example, x)[4 + c], 1e-15);
    }
}

} // namespace sinew::test_layers

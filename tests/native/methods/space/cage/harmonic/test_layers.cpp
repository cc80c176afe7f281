// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic/layers.h"

#include "tests/native/methods/space/cage/cages.h"
#include "tests/native/wide_kernels.h"

#include <gtest/gtest.h>

#include <array>

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
        for (int k = 0; k < 3; ++k) {
            triangle.face.origin[k] = p[0][k];
            triangle.face.x[k] = x[k];
            triangle.face.y[k] = y[k];
            triangle.face.n[k] = n[k];
        }
        triangle.face.corners = triangle.face.edges = 3;
        triangle.face.panels = 1;
        triangle.face.corner = corners.data();
        triangle.face.edge = edges.data();
        triangle.face.panel = &panel;
        triangle.diagonal = 1;
        triangle.product = gradient[1].dot(gradient[2]);
        for (int k = 0; k < 3; ++k)
            triangle.along[k] = gradient[1].dot(Eigen::Vector2d(edges[k].sx, edges[k].sy));
    }

    /// The fields of both() by halving the triangle until its pieces are small beside their distance.
    std::array<double, 7> by_quadrature(const Vector3& x) const
    {
        std::array<double, 7> sums{};
        add({Vector3::UnitX(), Vector3::UnitY(), Vector3::UnitZ()}, x, 0, sums);
        for (double& sum : sums)
            sum /= 4 * shapes::pi;
        return sums;
    }

private:
    void add(const std::array<Vector3, 3>& hats, const Vector3& x, int depth,
             std::array<double, 7>& sums) const
    {
        const auto at = [&](const Vector3& h) -> Vector3 { return h[0] * p[0] + h[1] * p[1] + h[2] * p[2]; };
        const std::array<Vector3, 3> q{at(hats[0]), at(hats[1]), at(hats[2])};
        const Vector3 area = 0.5 * (q[1] - q[0]).cross(q[2] - q[0]);
        const double across = std::max({(q[1] - q[0]).norm(), (q[2] - q[1]).norm(), (q[0] - q[2]).norm()});
        if (depth < 12 && 15 * across > ((q[0] + q[1] + q[2]) / 3 - x).norm()) {
            const Vector3 ab = (hats[0] + hats[1]) / 2, bc = (hats[1] + hats[2]) / 2;
            const Vector3 ca = (hats[2] + hats[0]) / 2;
            add({hats[0], ab, ca}, x, depth + 1, sums);
            add({ab, hats[1], bc}, x, depth + 1, sums);
            add({ca, bc, hats[2]}, x, depth + 1, sums);
            add({ab, bc, ca}, x, depth + 1, sums);
            return;
        }
        // Seven points, exact for quintics [Radon 1948].
        const double s = std::sqrt(15.0);
        const std::array<double, 3> far{1.0 / 3, (6 - s) / 21, (6 + s) / 21};
        const std::array<double, 3> weight{9.0 / 40, (155 - s) / 1200, (155 + s) / 1200};
        for (int ring = 0; ring < 3; ++ring)
            for (int k = 0; k < (ring == 0 ? 1 : 3); ++k) {
                Vector3 mix = Vector3::Constant(far[ring]);
                mix[k] = 1 - 2 * far[ring];
                const Vector3 h = mix[0] * hats[0] + mix[1] * hats[1] + mix[2] * hats[2];
                const Vector3 away = at(h) - x;
                const double r = away.norm();
                const double twofold = weight[ring] * area.dot(away) / (r * r * r);
                const double single = weight[ring] * area.norm() / r;
                for (int c = 0; c < 3; ++c) {
                    sums[c] += twofold * h[c];
                    sums[4 + c] += single * h[c];
                }
                sums[3] += twofold * h[1] * h[2];
            }
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
    // Pieces of a fifteenth of their distance leave a relative error of some 15^-6 in each.
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

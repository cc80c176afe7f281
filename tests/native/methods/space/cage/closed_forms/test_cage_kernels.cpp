// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/closed_forms/cage_kernels.h"

#include "native/methods/space/cage/closed_forms/cage_geometry.h"
#include "tests/native/methods/space/cage/cages.h"
#include "tests/native/wide_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <vector>

namespace sinew::test_cage_kernels {

namespace {

struct Results
{
    std::vector<double> weights, sums, phi, psi, winding;
    std::vector<int> on;
    int touching = 0;
};

/// What the kernels tell of some points, which fill their lanes.
Results of(const CageKernels& kernels, const CageGeometry& geometry, const Points& points)
{
    const CageTables tables = geometry.tables();
    const std::size_t lanes = static_cast<std::size_t>(kernels.lanes);
    const std::size_t vertices = static_cast<std::size_t>(tables.vertex_count);
    const std::size_t triangles = static_cast<std::size_t>(tables.triangle_count);
    Results all{{}, {}, std::vector<double>(vertices * 8), std::vector<double>(triangles * 8), {}, {}, 0};
    all.weights.resize(vertices * 8);
    std::vector<double> scratch(geometry.scratch_size(kernels), 7.0);
    std::vector<double> weights(lanes * vertices), phi(weights), psi(lanes * triangles), sums(lanes),
        winding(lanes);
    std::vector<int> on(lanes), near_edge(static_cast<std::size_t>(tables.edge_count));
    for (int first = 0; first < 8; first += kernels.lanes) {
        PointLanes some(kernels);
        for (int lane = 0; lane < kernels.lanes; ++lane)
            some.set(lane, geometry.normalized(points.row(first + lane)));
        kernels.mean_value(tables, some.lanes, scratch.data(), weights.data(), sums.data(), on.data());
        all.touching |= kernels.green(tables, some.lanes, scratch.data(), near_edge.data(), phi.data(),
                                      psi.data(), winding.data())
                        << first;
        all.sums.insert(all.sums.end(), sums.begin(), sums.end());
        all.winding.insert(all.winding.end(), winding.begin(), winding.end());
        all.on.insert(all.on.end(), on.begin(), on.end());
        const auto spread = [&](const std::vector<double>& from, std::vector<double>& to) {
            for (std::size_t k = 0; k < from.size(); ++k)
                to[k / lanes * 8 + static_cast<std::size_t>(first) + k % lanes] = from[k];
        };
        spread(weights, all.weights);
        spread(phi, all.phi);
        spread(psi, all.psi);
    }
    return all;
}

} // namespace

TEST(CageKernels, agree_to_the_last_bit)
{
    for (const SurfaceMesh& mesh : {shapes::bumpy_sphere(2), shapes::u_prism()}) {
        const CageGeometry geometry{Cage(mesh)};
        Points points = shapes::points_near(mesh, {0.0, 1e-12, 1e-6, 1e-3});
        for (Eigen::Index first = 0; first + 8 <= points.rows(); first += 8) {
            const Points eight = points.middleRows(first, 8);
            const Results a = of(CageKernels::baseline, geometry, eight);
            for (const CageKernels* kernels : wide_kernels<CageKernels>()) {
                const Results b = of(*kernels, geometry, eight);
                // Bits are compared, as the results of points that touch an edge may be NaN.
                EXPECT_EQ(0, std::memcmp(a.weights.data(), b.weights.data(), 8 * a.weights.size()));
                EXPECT_EQ(0, std::memcmp(a.sums.data(), b.sums.data(), 8 * a.sums.size()));
                EXPECT_EQ(a.on, b.on);
                EXPECT_EQ(a.touching, b.touching);
                if (a.touching == 0) {
                    EXPECT_EQ(a.phi, b.phi);
                    EXPECT_EQ(a.psi, b.psi);
                    EXPECT_EQ(a.winding, b.winding);
                }
            }
        }
    }
}

TEST(CageKernels, give_the_same_bits_on_every_processor)
{
    const CageGeometry geometry{Cage(shapes::u_prism())};
    Points points(8, 3);
    for (int k = 0; k < 8; ++k)
        points.row(k) << 0.3 + 0.31 * k, 0.4 + 0.07 * k, 0.45 - 0.02 * k;
    for (const CageKernels* kernels : every_kernels<CageKernels>()) {
        const Results all = of(*kernels, geometry, points);
        EXPECT_EQ(all.touching, 0);
        EXPECT_EQ(digest(all.weights), 5264768334670266947ULL);
        EXPECT_EQ(digest(all.phi), 725038488493450765ULL);
        EXPECT_EQ(digest(all.psi), 3140023966079445290ULL);
    }
}

TEST(CageKernels, arcs_agree_and_are_right)
{
    constexpr int blocks = 3, width = most_cage_lanes;
    shapes::Random random(6);
    std::vector<double> arcs(blocks * 6 * width), plain(blocks * 3 * width);
    for (double& x : arcs)
        x = random.signed_unit();
    for (int axis = 0; axis < 3; ++axis) // one arc of no length
        arcs[axis * width] = arcs[(3 + axis) * width];
    CageKernels::baseline.arc_integrals(arcs.data(), blocks, plain.data());
    for (int i = 0; i < blocks * width; ++i) {
        const auto vector = [&](const std::vector<double>& all, int rows, int first) -> Vector3 {
            const double* at = all.data() + (i / width * rows + first) * width + i % width;
            return {at[0], at[width], at[2 * width]};
        };
        const Vector3 a = vector(arcs, 6, 0), b = vector(arcs, 6, 3), normal = a.cross(b);
        const double half = 0.5 * std::atan2(normal.norm(), a.dot(b));
        EXPECT_LT((vector(plain, 3, 0) - half * normal.normalized()).norm(), 1e-14);
    }
    for (const CageKernels* kernels : wide_kernels<CageKernels>()) {
        std::vector<double> wide(plain.size());
        kernels->arc_integrals(arcs.data(), blocks, wide.data());
        EXPECT_EQ(plain, wide);
    }
}

TEST(CageKernels, points_beyond_planes_agree_and_are_sure)
{
    constexpr int count = 101;
    shapes::Random random(7);
    std::vector<float> points(6 * count), planes(16);
    for (int v = 0; v < count; ++v) {
        const Vector3 p = random.vector(), u = p.normalized();
        for (int axis = 0; axis < 3; ++axis) {
            points[axis * count + v] = static_cast<float>(u[axis]);
            points[(3 + axis) * count + v] = static_cast<float>(p[axis]);
        }
    }
    for (int k = 0; k < 4; ++k) {
        const Vector3 n = random.vector().normalized();
        for (int axis = 0; axis < 3; ++axis)
            planes[4 * k + axis] = static_cast<float>(n[axis]);
        planes[4 * k + 3] = k < 3 ? 0.0f : 0.1f;
    }
    std::vector<int> plain(count);
    CageKernels::baseline.beyond_planes(points.data(), count, planes.data(), plain.data());
    for (int v = 0; v < count; ++v)
        for (int k = 0; k < 4; ++k) {
            double height = -static_cast<double>(planes[4 * k + 3]);
            for (int axis = 0; axis < 3; ++axis)
                height +=
                    static_cast<double>(planes[4 * k + axis]) * points[((k < 3 ? 0 : 3) + axis) * count + v];
            EXPECT_EQ(plain[v] >> k & 1, (k < 3 ? height < -2e-6 : height > 2e-6) ? 1 : 0);
        }
    for (const CageKernels* kernels : wide_kernels<CageKernels>()) {
        std::vector<int> wide(count);
        kernels->beyond_planes(points.data(), count, planes.data(), wide.data());
        EXPECT_EQ(plain, wide);
    }
}

} // namespace sinew::test_cage_kernels

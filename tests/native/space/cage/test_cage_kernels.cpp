// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/cage_kernels.h"

#include "native/space/cage/cage_geometry.h"
#include "tests/native/space/cage/cages.h"

#include <gtest/gtest.h>

#include <array>
#include <cstring>
#include <limits>
#include <vector>

namespace sinew {

namespace {

struct Results
{
    std::vector<double> weights, sums = std::vector<double>(4), phi, psi, winding = std::vector<double>(4);
    std::array<int, 4> on;
    int touching = 0;
    bool operator==(const Results&) const = default;
};

Results of(const CageKernels& kernels, const CageGeometry& geometry, const FourPoints& points)
{
    const CageTables tables = geometry.tables();
    Results r;
    std::vector<double> scratch(geometry.scratch_size(), 7.0);
    r.weights.resize(4 * tables.vertex_count);
    r.phi.resize(4 * tables.vertex_count);
    r.psi.resize(4 * tables.triangle_count);
    kernels.mean_value(tables, points.lanes, scratch.data(), r.weights.data(), r.sums.data(), r.on.data());
    r.touching =
        kernels.green(tables, points.lanes, scratch.data(), r.phi.data(), r.psi.data(), r.winding.data());
    return r;
}

template <class T>
void expect_same_products(void (*ours)(const T*, int, const T*, T*),
                          void (*other)(const T*, int, const T*, T*))
{
    constexpr int points = 64 / sizeof(T);
    shapes::Random random(5);
    for (const int columns : {1, 63, 64, 65, 300}) {
        std::vector<T> block(points * columns), factors(3 * columns);
        for (T& b : block)
            b = static_cast<T>(random.signed_unit());
        for (T& f : factors)
            f = static_cast<T>(random.signed_unit());
        std::array<T, 3 * points> sums, others;
        ours(block.data(), columns, factors.data(), sums.data());
        other(block.data(), columns, factors.data(), others.data());
        EXPECT_EQ(sums, others);
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < points; ++i) {
                double exact = 0.0;
                for (int c = 0; c < columns; ++c)
                    exact += static_cast<double>(block[points * c + i]) * factors[3 * c + axis];
                // 64 additions of sums up to 64, and as many of them as there are in the columns
                EXPECT_NEAR(sums[points * axis + i], exact, 64 * 64 * std::numeric_limits<T>::epsilon());
            }
    }
}

} // namespace

TEST(CageKernels, agree_to_the_last_bit)
{
    const CageKernels* const wide = avx2_cage_kernels();
    if (!wide)
        GTEST_SKIP() << "this processor has no AVX2";
    for (const SurfaceMesh& mesh : {shapes::bumpy_sphere(2), shapes::u_prism()}) {
        const CageGeometry geometry{Cage(mesh)};
        Points points = shapes::points_near(mesh, {0.0, 1e-12, 1e-6, 1e-3});
        for (Eigen::Index first = 0; first + 4 <= points.rows(); first += 4) {
            FourPoints four;
            for (int lane = 0; lane < 4; ++lane)
                four.set(lane, geometry.seen(points.row(first + lane)));
            const Results a = of(baseline_cage_kernels(), geometry, four), b = of(*wide, geometry, four);
            // By bits: what is told of points that touch an edge may be no number.
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

TEST(CageKernels, a_point_gets_the_same_beside_any_others)
{
    const SurfaceMesh mesh = shapes::bumpy_sphere(1);
    const CageGeometry geometry{Cage(mesh)};
    const Points points = shapes::points_around(mesh, 64, 1.5);
    FourPoints alone, mixed;
    for (int i = 0; i + 4 <= 64; ++i) {
        for (int lane = 0; lane < 4; ++lane) {
            alone.set(lane, geometry.seen(points.row(i)));
            mixed.set(lane, geometry.seen(points.row(i + lane)));
        }
        const Results a = of(cage_kernels(), geometry, alone), b = of(cage_kernels(), geometry, mixed);
        for (std::size_t k = 0; k < a.weights.size(); k += 4) {
            EXPECT_EQ(a.weights[k], a.weights[k + 3]);
            EXPECT_EQ(a.weights[k], b.weights[k]);
            EXPECT_EQ(a.phi[k], b.phi[k]);
        }
    }
}

TEST(CageKernels, products_agree_and_are_right)
{
    const CageKernels& base = baseline_cage_kernels();
    const CageKernels& wide = avx2_cage_kernels() ? *avx2_cage_kernels() : base;
    expect_same_products(base.product_of_doubles, wide.product_of_doubles);
    expect_same_products(base.product_of_floats, wide.product_of_floats);
}

TEST(CageKernels, sparse_products_agree_and_are_right)
{
    const std::vector<double> weights{0.5, 0.25, 2.0, -1.0}, factors{1, 2, 3, 0, 4, 5, 6, 0, 7, 8, 9, 0};
    const std::vector<int> columns{0, 2, 1, 1}, offsets{0, 3, 3, 4};
    const std::vector<double> exact{10.25, 13, 15.75, 0, 0, 0, 0, 0, -4, -5, -6, 0};
    std::vector<double> sums(12);
    for (const CageKernels* kernels : {&baseline_cage_kernels(), avx2_cage_kernels()})
        if (kernels) {
            kernels->sparse_product_of_doubles(weights.data(), columns.data(), offsets.data(), 3,
                                               factors.data(), sums.data());
            EXPECT_EQ(sums, exact);
        }
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/subdivision/stencils.h"

#include "native/subdivision/stencil_kernels.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <cstring>

namespace sinew::test_stencils {

/// Rows of 0 to 19 entries.
SparseRows random_matrix(int rows, int columns)
{
    shapes::Random random(5);
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < rows; ++i)
        for (int k = 0; k < i % 20; ++k)
            entries.emplace_back(i, random.below(columns), random.signed_unit());
    SparseRows matrix(rows, columns);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

TEST(Stencils, give_what_the_matrix_gives)
{
    const SparseRows matrix = random_matrix(20'011, 300);
    const Stencils stencils{SparseRows(matrix)};
    const Points points = shapes::Random(6).points(300);
    Points found(matrix.rows(), 3);
    stencils.apply(points.data(), found.data());
    EXPECT_LT(shapes::distance(found, matrix * points), 1e-14); // another order of sums of 20 numbers below 1

    Points zero = Points::Ones(3, 3);
    Stencils(SparseRows(3, 300)).apply(points.data(), zero.data());
    EXPECT_EQ(zero, Points::Zero(3, 3)) << "without an entry";
    Stencils(SparseRows(0, 300)).apply(points.data(), zero.data());

    using Single = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
    const Single narrow = points.cast<float>();
    Single single(matrix.rows(), 3);
    stencils.apply(narrow.data(), single.data());
    EXPECT_LT(shapes::distance(found, single.cast<double>()), 5e-6); // 20 roundings of 6e-8 each, twice
}

TEST(Stencils, do_not_depend_on_threads_or_instructions)
{
    const SparseRows matrix = random_matrix(20'011, 300);
    const Stencils stencils{SparseRows(matrix)};
    const Points points = shapes::Random(6).points(300);
    Points one(matrix.rows(), 3), many(matrix.rows(), 3), wide = Points::Zero(matrix.rows(), 3);
    {
        const ThreadLimit limit(1);
        stencils.apply(points.data(), one.data());
    }
    stencils.apply(points.data(), many.data());
    const std::size_t bytes = sizeof(double) * one.size();
    EXPECT_EQ(std::memcmp(one.data(), many.data(), bytes), 0);

    Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor> padded(points.rows(), 4);
    padded << points, VectorX::Zero(points.rows());
    for (const StencilKernels* kernels : every_kernels<StencilKernels>()) {
        kernels->in_double(matrix.outerIndexPtr(), matrix.innerIndexPtr(), matrix.valuePtr(), padded.data(),
                           0, static_cast<int>(matrix.rows()), wide.data());
        EXPECT_EQ(std::memcmp(one.data(), wide.data(), bytes), 0);
    }
}

} // namespace sinew::test_stencils

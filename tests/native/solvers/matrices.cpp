// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/solvers/matrices.h"

namespace sinew::matrices {

namespace {

/// The unknown of each node.
std::vector<int> names(int side) { return shapes::Random(11).shuffled(side * side); }

} // namespace

SparseMatrix shuffled_grid(int side, double shift)
{
    const std::vector<int> name = names(side);
    std::vector<Eigen::Triplet<double>> entries;
    const auto add = [&](int i, int j, double value) { entries.emplace_back(name[i], name[j], value); };
    for (int y = 0; y < side; ++y)
        for (int x = 0; x < side; ++x) {
            const int i = y * side + x;
            add(i, i, shift);
            for (int j : {x + 1 < side ? i + 1 : -1, y + 1 < side ? i + side : -1})
                if (j >= 0) {
                    add(i, i, 1);
                    add(j, j, 1);
                    add(i, j, -1);
                    add(j, i, -1);
                }
        }
    SparseMatrix matrix(side * side, side * side);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

Points points_of_shuffled_grid(int side)
{
    const std::vector<int> name = names(side);
    Points points(side * side, 3);
    for (int i = 0; i < side * side; ++i)
        points.row(name[i]) = Eigen::RowVector3d(i % side, i / side, 0.0);
    return points;
}

SparseMatrix random_spd(int n, int seed, int entries_per_row)
{
    shapes::Random random(seed);
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < entries_per_row; ++k)
            entries.emplace_back(i, random.below(n), random.signed_unit());
    SparseMatrix B(n, n);
    B.setFromTriplets(entries.begin(), entries.end());
    SparseMatrix identity(n, n);
    identity.setIdentity();
    return SparseMatrix(SparseMatrix(B.transpose()) * B) + 0.5 * identity;
}

SparseMatrix diagonal(const std::vector<double>& values)
{
    const int n = static_cast<int>(values.size());
    SparseMatrix matrix(n, n);
    for (int i = 0; i < n; ++i)
        matrix.insert(i, i) = values[i];
    matrix.makeCompressed();
    return matrix;
}

} // namespace sinew::matrices

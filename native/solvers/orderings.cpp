// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/orderings.h"

#include "native/core/errors.h"
#include "native/solvers/engines/cholmod_factor.h"
#include "native/solvers/patch_dissection.h"

#include <Eigen/OrderingMethods>

#include <algorithm>
#include <numeric>

namespace sinew {

namespace {

/// Appends to `order` what a breadth-first search from `start` visits, neighbours by rising degree.
/// E. Cuthill, J. McKee. "Reducing the bandwidth of sparse symmetric matrices." ACM 1969.
/// \param found_by  the last search that came to each vertex. This one passes those of former searches.
void append_levels(const SparseMatrix& matrix, int start, int search, std::vector<int>& found_by,
                   std::vector<int>& order)
{
    const int* offsets = matrix.outerIndexPtr();
    const auto degree = [&](int v) { return offsets[v + 1] - offsets[v]; };
    std::size_t head = order.size();
    found_by[start] = search;
    order.push_back(start);
    while (head < order.size()) {
        const int v = order[head++];
        const std::size_t begin = order.size();
        for (SparseMatrix::InnerIterator it(matrix, v); it; ++it) {
            const int u = static_cast<int>(it.row());
            if (found_by[u] < search) {
                found_by[u] = search;
                order.push_back(u);
            }
        }
        std::stable_sort(order.begin() + begin, order.end(),
                         [&](int a, int b) { return degree(a) < degree(b); });
    }
}

std::vector<int> cuthill_mckee(const SparseMatrix& lower)
{
    const SparseMatrix matrix = lower.selfadjointView<Eigen::Lower>();
    const int n = static_cast<int>(matrix.cols());
    std::vector<int> found_by(n, 0);
    std::vector<int> order, trial;
    order.reserve(n);
    for (int seed = 0; seed < n; ++seed) {
        if (found_by[seed] > 0)
            continue;
        // The levels of the search are narrowest from a vertex at one end of the part. A first search ends at
        // such a vertex, and a second one from there numbers the part.
        trial.clear();
        append_levels(matrix, seed, 1, found_by, trial);
        append_levels(matrix, trial.back(), 2, found_by, order);
    }
    return order;
}

std::vector<int> reverse_cuthill_mckee(const SparseMatrix& lower)
{
    std::vector<int> order = cuthill_mckee(lower);
    std::ranges::reverse(order);
    return order;
}

std::vector<int> minimum_degree(const SparseMatrix& matrix)
{
    if (have_cholmod()) // its minimum degree is twice as fast as Eigen's
        return cholmod_minimum_degree(matrix);
    Eigen::PermutationMatrix<Eigen::Dynamic, Eigen::Dynamic, int> permutation;
    Eigen::AMDOrdering<int>()(matrix.selfadjointView<Eigen::Lower>(), permutation);
    const auto& indices = permutation.indices();
    return {indices.data(), indices.data() + indices.size()};
}

} // namespace

std::vector<int> elimination_order(const SparseMatrix& matrix, Ordering ordering)
{
    switch (ordering) {
    case Ordering::automatic:
        return have_cholmod() && matrix.cols() >= fewest_to_dissect ? patch_dissection(matrix)
                                                                    : minimum_degree(matrix);
    case Ordering::cuthill_mckee:
        return cuthill_mckee(matrix);
    case Ordering::reverse_cuthill_mckee:
        return reverse_cuthill_mckee(matrix);
    case Ordering::minimum_degree:
        return minimum_degree(matrix);
    case Ordering::nested_dissection:
        return nested_dissection(matrix);
    case Ordering::patch_dissection:
        if (!have_cholmod())
            throw InvalidOption("patch dissection needs a build with CHOLMOD; choose minimum_degree");
        return patch_dissection(matrix);
    case Ordering::natural:
        break;
    }
    std::vector<int> order(matrix.cols());
    std::iota(order.begin(), order.end(), 0);
    return order;
}

} // namespace sinew

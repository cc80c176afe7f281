// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/orderings.h"

#include "native/core/errors.h"
#include "native/solvers/engines/cholmod_factor.h"
#include "native/solvers/spd_factor.h"
#include "tests/native/solvers/matrices.h"

#include <future>
#include <limits>
#include <set>

namespace sinew::test_orderings {

/// Entries of the factor by elimination on the graph, without numbers.
int fill_in(const SparseMatrix& matrix, const std::vector<int>& order)
{
    const int n = static_cast<int>(matrix.cols());
    std::vector<int> when(n);
    for (int i = 0; i < n; ++i)
        when[order[i]] = i;
    std::vector<std::set<int>> later(n);
    for (int c = 0; c < n; ++c)
        for (SparseMatrix::InnerIterator it(matrix, c); it; ++it) {
            const auto [first, second] = std::minmax(when[c], when[it.row()]);
            if (first != second)
                later[first].insert(second);
        }
    int entries = n;
    for (int i = 0; i < n; ++i) {
        entries += static_cast<int>(later[i].size());
        if (later[i].empty())
            continue;
        const int parent = *later[i].begin();
        later[parent].insert(std::next(later[i].begin()), later[i].end());
    }
    return entries;
}

std::vector<Ordering> available()
{
    std::vector all{Ordering::natural, Ordering::reverse_cuthill_mckee, Ordering::minimum_degree};
    if (have_cholmod())
        all.push_back(Ordering::nested_dissection);
    return all;
}

SparseMatrix two_parts_and_a_loner()
{
    const SparseMatrix grid = matrices::shuffled_grid(5);
    std::vector<Eigen::Triplet<double>> entries{{50, 50, 1.0}};
    for (int c = 0; c < 25; ++c)
        for (SparseMatrix::InnerIterator it(grid, c); it; ++it)
            for (int shift : {0, 25})
                entries.emplace_back(static_cast<int>(it.row()) + shift, c + shift, it.value());
    SparseMatrix matrix(51, 51);
    matrix.setFromTriplets(entries.begin(), entries.end());
    return matrix;
}

TEST(Orderings, name_every_unknown_once)
{
    for (const SparseMatrix& matrix : {matrices::shuffled_grid(13), two_parts_and_a_loner(),
                                       matrices::diagonal({1}), matrices::random_spd(70, 3)})
        for (Ordering ordering : available()) {
            std::vector<int> order = elimination_order(matrix, ordering);
            if (ordering != Ordering::natural)
                std::ranges::sort(order);
            EXPECT_EQ(order, shapes::numbers(0, static_cast<int>(matrix.cols())));
        }
    if (!have_cholmod()) {
        EXPECT_THROW(elimination_order(matrices::diagonal({1}), Ordering::nested_dissection), InvalidOption);
    }
}

TEST(Orderings, are_the_same_where_several_threads_look_for_one)
{
    const SparseMatrix matrix = matrices::shuffled_grid(40);
    for (Ordering ordering : available()) {
        const std::vector<int> alone = elimination_order(matrix, ordering);
        std::vector<std::future<std::vector<int>>> beside;
        for (int thread = 0; thread < 8; ++thread)
            beside.push_back(std::async(std::launch::async, elimination_order, matrix, ordering));
        for (auto& found : beside)
            EXPECT_EQ(found.get(), alone);
    }
}

// Figure 24 of the tutorial.
TEST(Orderings, fill_falls_from_natural_by_cuthill_mckee_to_the_others)
{
    const SparseMatrix matrix = matrices::shuffled_grid(30);
    const auto fill = [&](Ordering ordering) { return fill_in(matrix, elimination_order(matrix, ordering)); };
    const int band = fill(Ordering::reverse_cuthill_mckee);
    EXPECT_GT(fill(Ordering::natural), 2 * band);
    EXPECT_GT(band, 1.3 * fill(Ordering::minimum_degree));
    if (have_cholmod()) {
        EXPECT_GT(band, 1.3 * fill(Ordering::nested_dissection));
    }
}

TEST(Orderings, the_factor_has_the_entries_that_elimination_predicts)
{
    const SparseMatrix matrix = matrices::shuffled_grid(12);
    std::vector backends{FactorBackend::ldlt};
    if (have_cholmod())
        backends.push_back(FactorBackend::simplicial);
    for (Ordering ordering : available())
        for (FactorBackend backend : backends) {
            SpdFactor factor({.backend = backend, .ordering = ordering});
            factor.factorize(matrix);
            EXPECT_EQ(factor.nonzeros(), fill_in(matrix, elimination_order(matrix, ordering)));
        }
}

// Other refusals and solutions of factors are in tests/bindings/test_factors.py.
TEST(SpdFactor, refuses_what_is_no_number)
{
    std::vector backends{FactorBackend::automatic, FactorBackend::ldlt};
    if (have_cholmod())
        backends.insert(backends.end(), {FactorBackend::supernodal, FactorBackend::simplicial});
    const SparseMatrix wrong = matrices::diagonal({1, std::numeric_limits<double>::quiet_NaN(), 1});
    for (Ordering ordering : available())
        for (FactorBackend backend : backends) {
            SpdFactor factor({.backend = backend, .ordering = ordering});
            EXPECT_THROW(factor.factorize(wrong), FactorizationFailed);
        }
}

} // namespace sinew::test_orderings

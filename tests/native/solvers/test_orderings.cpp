// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/orderings.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/solvers/dissection/vertex_separator.h"
#include "native/solvers/engines/cholmod_factor.h"
#include "native/solvers/spd_factor.h"
#include "tests/native/solvers/matrices.h"

#include <bit>
#include <future>
#include <limits>
#include <random>
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
    std::vector all{Ordering::automatic, Ordering::natural, Ordering::cuthill_mckee,
                    Ordering::reverse_cuthill_mckee, Ordering::minimum_degree};
    if (have_cholmod())
        all.insert(all.end(), {Ordering::nested_dissection, Ordering::patch_dissection});
    return all;
}

/// The bi-Laplacian's pattern of a mesh: vertices meet within two edges of each other.
SparseMatrix two_rings(int vertices, const std::vector<std::array<int, 3>>& faces)
{
    std::vector<Eigen::Triplet<double>> entries;
    for (int v = 0; v < vertices; ++v)
        entries.emplace_back(v, v, 1.0);
    for (const auto& face : faces)
        for (const int a : face)
            for (const int b : face)
                entries.emplace_back(a, b, 1.0);
    SparseMatrix one(vertices, vertices);
    one.setFromTriplets(entries.begin(), entries.end());
    return one * one;
}

/// A grid of triangles whose diagonals are drawn at random, its vertices shuffled.
std::vector<std::array<int, 3>> jittered_faces(int side)
{
    std::mt19937 random(5);
    std::vector<int> name = shapes::numbers(0, side * side);
    for (int i = side * side - 1; i > 0; --i)
        std::swap(name[i], name[random() % (i + 1)]);
    std::vector<std::array<int, 3>> faces;
    for (int y = 0; y + 1 < side; ++y)
        for (int x = 0; x + 1 < side; ++x) {
            const int a = name[y * side + x], b = name[y * side + x + 1], c = name[(y + 1) * side + x + 1],
                      d = name[(y + 1) * side + x];
            const bool flipped = random() % 2 == 0;
            faces.push_back({a, b, flipped ? c : d});
            faces.push_back({flipped ? a : b, c, d});
        }
    return faces;
}

bool names_all(std::vector<int> order, const SparseMatrix& matrix)
{
    std::ranges::sort(order);
    return order == shapes::numbers(0, static_cast<int>(matrix.cols()));
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
            const std::vector<int> order = elimination_order(matrix, ordering);
            EXPECT_TRUE(names_all(order, matrix));
            EXPECT_EQ(order == shapes::numbers(0, static_cast<int>(order.size())),
                      ordering == Ordering::natural || order.size() < 2);
        }
    if (have_cholmod())
        return;
    for (Ordering ordering : {Ordering::nested_dissection, Ordering::patch_dissection})
        EXPECT_THROW(elimination_order(matrices::diagonal({1}), ordering), InvalidOption);
}

TEST(PatchDissection, names_every_vertex_of_broken_meshes_once)
{
    if (!have_cholmod())
        GTEST_SKIP() << "this build has no CHOLMOD";
    for (int seed = 0; seed < 30; ++seed) {
        std::mt19937 random(seed);
        const int side = 10 + static_cast<int>(random() % 60), grid = side * side;
        const int vertices = grid + static_cast<int>(random() % 3000); // some of them without a face
        std::vector<std::array<int, 3>> faces = jittered_faces(side);
        std::erase_if(faces, [&](const auto&) { return random() % 8 < static_cast<unsigned>(seed % 8); });
        const auto any = [&] { return static_cast<int>(random() % vertices); };
        for (int k = 0; k < seed % 4; ++k)
            faces.push_back({any(), any(), any()}); // through the inside
        for (int k = 0; k < seed * 5; ++k) {
            const int hub = seed % 5 == 0 ? 0 : any();
            faces.push_back({hub, hub + 1, any()}); // where more than two faces meet, or a fan of many
        }
        const SparseMatrix matrix = two_rings(vertices, faces);
        EXPECT_TRUE(names_all(elimination_order(matrix, Ordering::patch_dissection), matrix)) << seed;
    }
    const SparseMatrix loose = two_rings(3000, {});
    EXPECT_TRUE(names_all(elimination_order(loose, Ordering::patch_dissection), loose));
}

TEST(PatchDissection, comes_close_to_metis_and_leaves_minimum_degree_behind)
{
    if (!have_cholmod())
        GTEST_SKIP() << "this build has no CHOLMOD";
    const SparseMatrix matrix = two_rings(110 * 110, jittered_faces(110));
    const auto fill = [&](Ordering ordering) { return fill_in(matrix, elimination_order(matrix, ordering)); };
    const int ours = fill(Ordering::patch_dissection);
    EXPECT_LT(ours, 1.06 * fill(Ordering::nested_dissection));
    EXPECT_LT(ours, 0.95 * fill(Ordering::minimum_degree));
}

TEST(PatchDissection, is_the_same_on_any_number_of_threads_and_chosen_for_large_matrices)
{
    if (!have_cholmod())
        GTEST_SKIP() << "this build has no CHOLMOD";
    const SparseMatrix matrix = two_rings(50176, jittered_faces(224)),
                       small = two_rings(400, jittered_faces(20));
    const std::vector<int> order = elimination_order(matrix, Ordering::patch_dissection);
    limit_threads(1);
    EXPECT_EQ(elimination_order(matrix, Ordering::automatic), order);
    limit_threads(0);
    EXPECT_EQ(elimination_order(small, Ordering::automatic),
              elimination_order(small, Ordering::minimum_degree));
}

/// Whether no path leads from the first to the second ones without the nodes in `removed`.
bool is_separated(const Graph& graph, const std::vector<char>& first, const std::vector<char>& second,
                  unsigned removed)
{
    std::vector<int> reached;
    const auto reach = [&](int v) {
        if (!(removed >> v & 1u))
            reached.push_back(v);
        removed |= 1u << v;
    };
    for (int v = 0; v < graph.size(); ++v)
        if (first[v])
            reach(v);
    for (std::size_t k = 0; k < reached.size(); ++k)
        for (const int u : graph.of(reached[k]))
            reach(u);
    return std::ranges::none_of(reached, [&](int v) { return second[v]; });
}

TEST(VertexSeparator, is_the_smallest_of_all_sets_of_nodes_that_separate)
{
    std::mt19937 random(9);
    for (int trial = 0; trial < 300; ++trial) {
        const int n = 4 + trial % 8;
        const SparseMatrix matrix = matrices::random_spd(n, trial, 1 + trial % 3);
        const Graph graph = graph_of(matrix);
        std::vector<char> first(n), second(n);
        for (int v = 0; v < n; ++v) {
            first[v] = random() % 3 == 0;
            second[v] = random() % 3 == 0;
        }
        const std::vector<Side> sides = vertex_separator(graph, first, second);
        unsigned separator = 0;
        for (int v = 0; v < n; ++v)
            separator |= unsigned{sides[v] == Side::separator} << v;
        EXPECT_TRUE(is_separated(graph, first, second, separator)) << trial;
        for (int v = 0; v < n; ++v)
            for (const int u : graph.of(v))
                EXPECT_FALSE(sides[v] == Side::first && sides[u] == Side::second) << trial;
        for (unsigned other = 0; other < 1u << n; ++other)
            EXPECT_FALSE(std::popcount(other) < std::popcount(separator) &&
                         is_separated(graph, first, second, other))
                << trial;
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

// Figure 24 of the tutorial. In grids of triangles, the reverse of an order by levels fills less than the order itself.
TEST(Orderings, fill_falls_from_natural_by_cuthill_mckee_and_minimum_degree_to_nested_dissection)
{
    const auto fill = [](const SparseMatrix& matrix, Ordering ordering) {
        return fill_in(matrix, elimination_order(matrix, ordering));
    };
    const SparseMatrix small = matrices::shuffled_grid(30), grid = matrices::shuffled_grid(90),
                       mesh = two_rings(900, jittered_faces(30));
    EXPECT_GT(fill(small, Ordering::natural), 2 * fill(small, Ordering::reverse_cuthill_mckee));
    EXPECT_GT(fill(mesh, Ordering::cuthill_mckee), 1.02 * fill(mesh, Ordering::reverse_cuthill_mckee));
    const int degree = fill(grid, Ordering::minimum_degree);
    EXPECT_GT(fill(grid, Ordering::reverse_cuthill_mckee), 1.3 * degree);
    if (have_cholmod()) {
        EXPECT_GT(degree, 1.02 * fill(grid, Ordering::nested_dissection));
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

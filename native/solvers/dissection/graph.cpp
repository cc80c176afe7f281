// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/dissection/graph.h"

#include <numeric>

namespace sinew {

Graph graph_of(const SparseMatrix& matrix)
{
    const int n = static_cast<int>(matrix.cols());
    const auto for_each_edge = [&](auto&& visit) {
        for (int c = 0; c < n; ++c)
            for (SparseMatrix::InnerIterator it(matrix, c); it; ++it)
                if (it.row() > c)
                    visit(c, static_cast<int>(it.row()));
    };
    Graph graph;
    graph.offsets.assign(n + 1, 0);
    for_each_edge([&](int a, int b) {
        ++graph.offsets[a + 1];
        ++graph.offsets[b + 1];
    });
    std::partial_sum(graph.offsets.begin(), graph.offsets.end(), graph.offsets.begin());
    graph.neighbours.resize(graph.offsets[n]);
    std::vector<int> next(graph.offsets.begin(), graph.offsets.end() - 1);
    for_each_edge([&](int a, int b) {
        graph.neighbours[next[a]++] = b;
        graph.neighbours[next[b]++] = a;
    });
    return graph;
}

} // namespace sinew

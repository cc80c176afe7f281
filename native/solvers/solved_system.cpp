// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/solved_system.h"

#include "native/solvers/sparse_columns.h"

#include <utility>

namespace sinew {

thread_local SolvedSystem* SolvedSystem::current = nullptr;

void SolvedSystem::keep(const ConstrainedQuadratic::Problem& problem, const RowMatrix& x,
                        const RowMatrix& right_side)
{
    problem_ = problem;
    held_ = x;
    for (Eigen::Index i = 0; i < x.rows(); ++i)
        if (problem.free[i])
            held_.row(i).setZero();
    right_side_ = right_side;
    described_ = {};
}

void SolvedSystem::describe(const SparseMatrix& graph, VectorX mass, int order, double membrane)
{
    described_.graph = graph;
    described_.mass = std::move(mass);
    described_.order = order;
    described_.membrane = membrane;
}

LinearSystem SolvedSystem::system() const
{
    const auto& [matrix, free, unknowns] = problem_;
    LinearSystem system = described_;
    system.held = held_;
    if (system.graph.cols() == 0)
        system.graph = *matrix;
    std::vector<int> rows, place(free.size(), -1);
    for (int u = 0; u < static_cast<int>(unknowns.size()); ++u)
        if (free[unknowns[u]]) {
            place[unknowns[u]] = static_cast<int>(rows.size());
            rows.push_back(u);
            system.vertices.push_back(unknowns[u]);
        }
    const int m = static_cast<int>(rows.size());
    system.right_side.resize(m, right_side_.cols());
    for (int i = 0; i < m; ++i)
        system.right_side.row(i) = right_side_.row(rows[i]);
    system.matrix = sparse_by_columns(m, m, [&](int c, SparseColumn& column) {
        for (SparseMatrix::InnerIterator it(*matrix, system.vertices[c]); it; ++it)
            if (const int row = place[it.row()]; row >= 0)
                column.add(row, it.value());
    });
    return system;
}

} // namespace sinew

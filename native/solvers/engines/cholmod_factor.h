// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/solvers/dissection/graph.h"
#include "native/solvers/dissection/vertex_separator.h"
#include "native/solvers/engines/factor_engine.h"

namespace sinew {

/// Whether the build has CHOLMOD.
bool have_cholmod();

/// CHOLMOD with one dense block per supernode (fast for bi-Laplacians), or with one column at a time (faster
/// solves for small Laplacians). Null in a build without CHOLMOD.
std::unique_ptr<FactorEngine> make_cholmod_factor(bool supernodal);

/// Minimum degree by AMD, which is a part of CHOLMOD. Call it only in a build with CHOLMOD.
std::vector<int> cholmod_minimum_degree(const SparseMatrix& matrix);

/// Nested dissection by METIS, through CHOLMOD.
/// \throw InvalidOption  the build does not have it.
std::vector<int> nested_dissection(const SparseMatrix& matrix);

/// Two halves of a graph with edges and a separator between them, by METIS. Call it only in a build with CHOLMOD.
/// \param weights  of each node, at least 1.
std::vector<Side> bisection(const Graph& graph, const std::vector<int>& weights);

/// Minimum degree by CAMD, where all nodes of one set are eliminated before those of the next. Call it only in a build
/// with CHOLMOD.
/// \param graph  of an edge, only the direction to the smaller number needs to be there, at the larger one.
/// \param sets   of each node, counted from 0.
std::vector<int> constrained_minimum_degree(const Graph& graph, const std::vector<int>& sets);

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/solvers/linear_system.h"

#include "native/core/errors.h"

#include <cmath>
#include <string>

namespace sinew {

namespace {

void require_finite(const SparseMatrix& matrix, const char* name)
{
    for (int c = 0; c < matrix.cols(); ++c)
        for (SparseMatrix::InnerIterator it(matrix, c); it; ++it)
            if (!std::isfinite(it.value()))
                throw InvalidOption(std::string(name) + ": NaN or infinite entry in column " +
                                    std::to_string(c));
}

void require_size(Eigen::Index given, Eigen::Index wanted, const char* name)
{
    if (given != wanted)
        throw InvalidOption(std::string(name) + ": " + std::to_string(given) + " given for " +
                            std::to_string(wanted));
}

} // namespace

void require_consistent(const LinearSystem& system)
{
    const auto m = system.matrix.cols(), n = system.points.rows();
    require_size(system.matrix.rows(), m, "matrix: rows");
    require_finite(system.matrix, "matrix");
    if (system.right_side.size() > 0)
        require_size(system.right_side.rows(), m, "right_side: rows");
    require_size(static_cast<Eigen::Index>(system.vertices.size()), m, "vertices");
    if (system.order < 1)
        throw InvalidOption("order: must be >= 1");
    if (!(std::isfinite(system.membrane) && system.membrane >= 0))
        throw InvalidOption("membrane: must be >= 0");
    int last = -1;
    for (const int v : system.vertices) {
        if (v <= last || (n > 0 && v >= n))
            throw InvalidOption("vertices: must rise, and be below " + std::to_string(n) + "; " +
                                std::to_string(v) + " does not");
        last = v;
    }
    if (!system.points.allFinite())
        throw InvalidOption("points: NaN or infinite coordinates");
    if (system.graph.size() > 0) {
        require_size(system.graph.rows(), n, "graph: rows");
        require_size(system.graph.cols(), n, "graph: columns");
        require_finite(system.graph, "graph");
    }
    if (system.held.size() > 0) {
        require_size(system.held.rows(), n, "held: rows");
        require_size(system.held.cols(), system.right_side.cols(), "held: columns");
        if (!system.held.allFinite())
            throw InvalidOption("held: NaN or infinite entry");
    }
    if (system.mass.size() > 0)
        require_size(system.mass.size(), n, "mass");
    for (Eigen::Index i = 0; i < system.mass.size(); ++i)
        if (!(system.mass[i] > 0))
            throw InvalidOption("mass: must be > 0, unlike that of vertex " + std::to_string(i));
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/surface/linear/thin_shell.h"
#include "tests/native/methods/surface/linear/dense_operators.h"
#include "tests/native/shapes.h"

#include <algorithm>

namespace sinew {

/// The linear thin shell once more, written down from the formulas with dense matrices: shares no code with
/// the library but the mesh and the handles' definition.
class DenseShell
{
public:
    DenseShell(const SurfaceMesh& mesh, const ThinShellOptions& options, const std::vector<Handle>& handles);

    /// Deformed points; `energy` gets the elastic and the soft part.
    Points solve(const Poses& poses, double* energy = nullptr);

private:
    struct Pull
    {
        int vertex, handle;
        double stiffness;
    };

    VectorX spread(const Stiffness& k) const;

    const SurfaceMesh& mesh_;
    Discretization kind_;
    int n_;
    std::vector<int> hard_;
    std::vector<Pull> pulls_;
    MatrixX A_, elastic_;
};

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

namespace sinew {

/// What a rebind() took over from the earlier object.
enum class Reuse {
    anew,    ///< nothing
    updated, ///< a part; the rest was computed again
    kept     ///< everything: nothing was computed
};

/// A name, and whether what it names differs.
struct Difference
{
    const char* name;
    bool differs;
};
/// `names`, and those of what differs.
std::vector<std::string> names_of(std::initializer_list<Difference> differences,
                                  std::vector<std::string> names = {});
/// "bending, handles".
std::string in_a_row(const std::vector<std::string>& names);

/// What set_handles() or rebind() did.
struct BindReport
{
    Reuse reuse = Reuse::anew;
    std::string changed; ///< what differs from the earlier object: "bending, handles"; empty for none
    int handle_count = 0;
    int constrained_vertices = 0; ///< hard ones
    int soft_vertices = 0;
    int free_parts = 0; ///< connected parts without any constraint; they stay at rest
    std::vector<int> free_vertices; ///< the vertices of those parts
    int degenerate_faces = 0; ///< faces with a triangle of (nearly) no area, which is floored
    int factorizations = 0; ///< numeric factorisations so far, those of earlier objects of rebind() too
    int analyses = 0; ///< symbolic ones
    double refactored = 0.0; ///< share of the last numeric one that had to be computed
    std::int64_t factor_bytes = 0; ///< memory of the factors, without what solving them needs
    double seconds = 0.0; ///< wall clock of set_handles()
};

/// What solve() reached.
struct SolveReport
{
    int iterations = 0; ///< accepted steps; 1 for a linear method
    int rejected = 0; ///< trial steps that did not lower the energy
    double energy = 0.0; ///< of the returned shape, in the method's own units
    double residual = 0.0; ///< linear: |A d - b| / |b|; nonlinear: last relative decrease
    bool converged = false; ///< the tolerance was met before the budget ended
};

} // namespace sinew

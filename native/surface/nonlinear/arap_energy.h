// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/regions.h"
#include "native/solvers/metric_lbfgs.h"
#include "native/solvers/spd_factor.h"

#include <array>
#include <vector>

namespace sinew {

/// A soft pull on a node of an ARAP graph, in units of the Laplacian's diagonal entries.
struct ArapPull
{
    int node;
    int handle;
    double stiffness;
};

/// The two other corners of a triangle at a node, with half the cotangents opposite the
/// edges (node, b), (node, c) and (b, c): what the rims of a cell need.
struct ArapWing
{
    int b, c;
    double to_b, to_c, across;
};

/// An as-rigid-as-possible problem on a weighted graph: the mesh itself, or one level of the
/// cascade. Built once a bind; solve() only reads it.
struct ArapGraph
{
    int size = 0;
    std::vector<int> offsets, neighbours; ///< directed edges of each node, neighbours rising
    std::vector<double> weights;          ///< w_ij > 0, one a directed edge
    std::vector<int> wing_offsets;        ///< empty: spokes only
    std::vector<ArapWing> wings;
    std::vector<double> rigidity;         ///< of each node's cell, > 0
    std::vector<int> hard;                ///< handle of a held node, else -1
    std::vector<bool> idle;               ///< in a part without a handle
    std::vector<ArapPull> pulls;
    double smoothing = 0.0;               ///< alpha A: weight of |R_i - R_j|^2

    std::vector<int> free_nodes;
    std::vector<int> place;               ///< node -> index among the free ones, else -1
    SpdFactor position_factor{{.many_solves = true}}; ///< L on free nodes, pulls on the diagonal
    SpdFactor rotation_factor{{.many_solves = true}}; ///< of the rotation field; empty without smoothing

    /// Entries of L one a directed edge: weights times the rigidity of the cells they lie in.
    std::vector<double> metric;

    bool has_rims() const { return !wing_offsets.empty(); }
    double edge_rigidity(int i, int j) const { return 0.5 * (rigidity[i] + rigidity[j]); }
    /// E of arap.h is this many times the function whose Hessian L bounds.
    double energy_factor() const { return has_rims() ? 6.0 : 4.0; }
    std::int64_t factor_bytes() const { return position_factor.bytes() + rotation_factor.bytes(); }

    /// Fills metric from weights, wings and rigidity.
    void set_metric();

    /// Fills free_nodes, place and the factors from the rest.
    /// \param rest  (size, 3), for the rotation factor's edge lengths.
    /// \throw FactorizationFailed
    void factorize(const Points& rest);
};

/// One solve's state on one graph: positions and rotations. F = E / energy_factor() as a
/// function of the free positions, the rotations being fitted on every evaluation.
class ArapProblem final : public MetricProblem
{
public:
    /// \param base     (size, 3) shape whose edges are kept as rigid as possible.
    /// \param targets  (size, 3) where held nodes go; base for the idle ones; else unused.
    /// \param pulls    (pulls, 3) where pulled nodes would go.
    ArapProblem(const ArapGraph& graph, const PointsView& base, const Points& targets, const Points& pulls);

    std::vector<Matrix3> rotations; ///< one a node

    /// Free positions that answer the current rotations: one linear solve.
    Points positions_for_rotations();
    /// Rotations that answer the positions cell by cell, neighbours ignored.
    void fit_rotations(const Points& x);

    double evaluate(const Points& x, Points& gradient) override;
    void precondition(const Points& gradient, Points& z) const override;
    void keep_state() override { kept_ = rotations; }
    void restore_state() override { rotations = kept_; }

    /// All nodes, the free ones at x.
    const Points& place(const Points& x);
    /// (free, 3) of an (n, 3) array.
    Points free_rows(const PointsView& all) const;
    /// sum r_i w_ij |p_i - p_j|^2 of the base: rounding in F is relative to it.
    double scale() const { return scale_; }

private:
    Matrix3 covariance(int i) const;
    Matrix3 neighbour_rotations(int i, const std::vector<Matrix3>& from) const;
    void turn_rotation_field();
    double energy_and_gradient(Points& gradient) const;
    Vector3 edge(int i, int j) const { return (base_.row(i) - base_.row(j)).transpose(); }
    Vector3 span(int i, int j) const { return (all_.row(i) - all_.row(j)).transpose(); }

    const ArapGraph& graph_;
    PointsView base_;
    const Points& pulls_;
    Points all_;
    std::vector<Matrix3> covariances_, previous_, kept_;
    double scale_ = 0.0;
};

} // namespace sinew

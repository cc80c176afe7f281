// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/mesh/regions.h"
#include "native/solvers/metric_lbfgs.h"
#include "native/solvers/single_factor.h"
#include "native/surface/nonlinear/arap_kernels.h"

#include <cstdint>
#include <vector>

namespace sinew {

/// A soft pull on a node of an ARAP graph, in units of the Laplacian's diagonal entries.
struct ArapPull
{
    int node;
    int handle;
    double stiffness;
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
    std::vector<char> idle;               ///< in a part without a handle
    std::vector<ArapPull> pulls;
    double smoothing = 0.0;               ///< alpha A: weight of |R_i - R_j|^2

    std::vector<int> free_nodes;
    std::vector<int> place;               ///< node -> index among the free ones, else -1
    SingleFactor position_factor; ///< L on free nodes, pulls on the diagonal
    SingleFactor rotation_factor; ///< of the rotation field; empty without smoothing

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

    /// Numbers the nodes so that neighbours lie close in memory, along a curve that fills space.
    /// Returns the old number of each node.
    std::vector<int> renumber(const Points& rest);
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

    Matrix3 rotation(int i) const;
    void set_rotation(int i, const Matrix3& R);

    /// Free positions that answer the current rotations: a linear solve, and one for what it left.
    Points positions_for_rotations();
    /// Rotations that answer the positions cell by cell, neighbours ignored.
    void fit_rotations(const Points& x);

    double evaluate(const Points& x, Points& gradient) override;
    void precondition(const Points& gradient, Points& z) const override;
    void keep_state() override { kept_ = current_; }
    void restore_state() override { current_ = kept_; }

    /// All nodes, the free ones at x.
    Points place(const Points& x);
    /// (free, 3) of an (n, 3) array.
    Points free_rows(const PointsView& all) const;
    /// sum r_i w_ij |p_i - p_j|^2 of the base: rounding in F is relative to it.
    double scale() const { return scale_; }

private:
    using Matrices = std::vector<double>; ///< twelve numbers a node: three columns, four lanes each

    void move_to(const Points& x);
    /// A set of rotations that neither the kept ones nor `used` occupy.
    int spare(int used) const;
    void fit(const double* S, int begin, int end, const Matrices& before, double tie, Matrices& after) const;
    void turn_rotation_field();
    double energy_and_gradient(Points& gradient) const;

    const ArapGraph& graph_;
    const ArapKernels& kernels_;
    const Points& pulls_;
    std::vector<double> base_, points_; ///< four lanes a node
    ArapView view_;
    Matrices rotations_[3]; ///< those kept, and two to work with
    int current_ = 0, kept_ = -1;
    Matrices covariances_; ///< of all nodes, with smoothing
    Points torque_;
    double scale_ = 0.0;
};

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/graph/handle_graph.h"
#include "native/methods/space/nonlinear/graph/deformation_graph.h"
#include "native/methods/space/nonlinear/handles/handle_control.h"
#include "native/solvers/optimization/metric_lbfgs.h"
#include "native/solvers/single_factor.h"

#include <array>
#include <vector>

namespace sinew {

/// How much each part of the energy counts.
struct EmbeddedWeights
{
    double rotation = 1.0, regularity = 10.0, pulls = 100.0;

    bool operator==(const EmbeddedWeights&) const = default;
};

/// The energy of an embedded deformation, in lengths of the mean edge of the graph. A node j at g_j takes y
/// to y + U_j (y - g_j) + t_j; its unknowns are the columns of U_j and t_j, four rows of a (4 m, 3) matrix.
///
///     E = w_rot sum_j Rot(I + U_j) + w_reg sum_(j, k) |U_j (g_k - g_j) + t_j - t_k|^2
///       + w_con sum_p s_p |sum_j w_pj (U_j (p - g_j) + t_j) - d_p|^2
///
/// over both directions of each edge, with Rot(A) = |A^T A - I|^2. With d_p the displacement of point p by
/// its handle, all terms of the pulls of a handle are Y^T K Y, Y the unknowns less what the handle would make
/// them.
class EmbeddedEnergy
{
public:
    /// A point that a handle pulls.
    struct Pull
    {
        int handle;
        double strength; ///< s_p
        std::vector<BlendedMaps::Share> shares;
    };

    /// \param places  (m, 3) the nodes at rest
    /// \param points  (pulls, 3) at rest
    /// \throw FactorizationFailed
    EmbeddedEnergy(const std::vector<std::array<int, 2>>& edges, std::vector<Pull> pulls, int handles,
                   const EmbeddedWeights& weights, const Points& places, const Points& points);

    int size() const { return size_; }
    std::int64_t bytes() const { return factor_.bytes() + rotation_factor_.bytes(); }

    /// What depends on the base shape.
    struct Shape
    {
        Points places, points;
        std::vector<Eigen::Matrix4d> blocks; ///< of K
    };
    Shape shape(const Points& places, const Points& points) const;
    const Shape& rest() const { return rest_; }

private:
    friend class EmbeddedProblem;

    struct Block
    {
        int handle, a, b; ///< a <= b
    };
    void factorize();

    int size_, handles_;
    EmbeddedWeights weights_;
    std::vector<std::array<int, 2>> edges_;
    std::vector<Pull> pulls_;
    std::vector<Block> blocks_;
    std::vector<int> block_of_; ///< for each pull and each pair of its shares
    Shape rest_;
    SingleFactor factor_; ///< of a bound of the Hessian at rest
    HandleGraph nodes_;   ///< a node that a handle pulls most is held by it
    std::vector<double> laplacian_;
    SingleFactor rotation_factor_;
};

/// E as a function of the unknowns, for one base shape and one motion of the handles.
class EmbeddedProblem final : public MetricProblem
{
public:
    EmbeddedProblem(const EmbeddedEnergy& energy, const EmbeddedEnergy::Shape& shape,
                    const std::vector<HeldMotion>& motions);

    /// (4 m, 3) the unknowns that minimise the energy with |A_j - R_j|^2 in place of Rot, where the rotations
    /// R_j are blends of those of the handles. From the poses alone; exact where one rigid motion moves all.
    Points start() const;
    /// Another start: with no rotations.
    Points start_without_rotations() const;

    double evaluate(const Points& x, Points& gradient) override;
    void precondition(const Points& gradient, Points& z) const override;
    void keep_state() override {}
    void restore_state() override {}

private:
    Points solve_for(const std::vector<Matrix3>& turns, Points x) const;
    /// The energy without Rot; adds to the gradient.
    double quadratic(const Points& x, Points& gradient) const;

    const EmbeddedEnergy& energy_;
    const EmbeddedEnergy::Shape& shape_;
    const std::vector<HeldMotion>& motions_;
};

/// The maps of the nodes for BlendedMaps, in the coordinates of the places.
Poses displacements(const Points& unknowns, const Points& places);

} // namespace sinew

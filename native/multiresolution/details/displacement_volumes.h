// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/memory.h"
#include "native/mesh/regions.h"
#include "native/multiresolution/details/detail_coding.h"
#include "native/multiresolution/details/displacement_vectors.h"
#include "native/multiresolution/details/ring_rotations.h"
#include "native/solvers/spd_factor.h"

#include <array>
#include <memory>
#include <vector>

namespace sinew {

/// The signed volume of the prism between a triangle of the base and one of the surface, and its derivatives
/// by the three corners of the surface. The walls are the means of their two triangulations.
struct Prism
{
    double volume;
    std::array<Vector3, 3> gradient;
};
Prism prism_between(const PointsView& coarse, const PointsView& fine, const Triangle& triangle);

/// Details as volumes between the base and the surface, so that they do not meet where the base bends
/// inwards.
///
/// M. Botsch, L. Kobbelt. "Multiresolution Surface Representation Based on Displacement Volumes."
/// Eurographics 2003. Tutorial, section 4.4.3.
///
///     least |x - x_0|^2_M   such that   V_i(x, b') = V_i(y, b) at each free vertex
///
/// V_i is a third of the volumes of the prisms at a vertex, and x_0 the result of DisplacementVectors.
/// Departs from the paper by one volume per vertex, and by its solver. With J = dV/dx, a step is x += M^-1
/// J^T l:
///
///   chord   l = K^-1 r with the factor of K = J M^-1 J^T of the rest shape, as long as steps halve r. Of the
///           last steps that combination is taken off which leaves the least r^T K^-1 r (D. Anderson.
///           "Iterative Procedures for Nonlinear Integral Equations." Journal of the ACM, 1965)
///   Newton  J M^-1 J^T l = r by conjugate gradients with that factor as their preconditioner, where the
///           chord stalls, or where the area of the base changes by more than a tenth
///
/// Volumes are kept, so a base that is scaled by s has details that are lower by s^2.
///
///   call         cost
///   constructor  a factor of the thin shell's size
///   apply()      some 3 to 10 steps of a solve for one column each, where heights times curvature stay below
///                .7; beyond that, up to 150 solves
class DisplacementVolumes final : public DetailCoding
{
public:
    /// \param regions       those of the fairing.
    /// \param fine, coarse  (n, 3) the band at rest.
    /// \throw FactorizationFailed  the element is a vertex.
    DisplacementVolumes(const SurfaceMesh& rest, const Regions& regions, const PointsView& fine,
                        const PointsView& coarse, std::shared_ptr<const RingRotations> rings);

    /// Adds its steps to the iterations, and one to the fallbacks where it needs Newton's; the residual is
    /// the largest error of a volume, as a share of their mean. Where that is not below 1e-6, the report has
    /// not converged, and the shape is the best one found.
    void apply(const Band& band, Points& detailed, SolveReport& report) const override;
    void report(BindReport& report) const override;

    /// (n) V_i; 0 at vertices that are not free.
    VectorX volumes(const PointsView& fine, const PointsView& coarse) const;

private:
    /// What changed in a step of the chord.
    struct Step
    {
        VectorX left, multipliers;
        Points x;
    };
    static constexpr int kept_steps = 4;

    struct Workspace
    {
        std::vector<Prism> prisms; ///< of the triangles
        std::array<Step, kept_steps + 1> steps; ///< the last ones in turn, and where the next one starts
        VectorX goal, left, multipliers;
        Points x, move, best;
    };

    void evaluate(const PointsView& fine, const PointsView& coarse, std::vector<Prism>& prisms,
                  VectorX& volumes) const;
    /// move = M^-1 J^T multipliers.
    void pull(const std::vector<Prism>& prisms, const VectorX& multipliers, Points& move) const;
    /// J move.
    void push(const std::vector<Prism>& prisms, const Points& move, VectorX& change) const;
    VectorX precondition(const VectorX& r) const;
    /// Solves J M^-1 J^T l = r until the largest residual is below `least`, or by `most` solves; returns
    /// their number.
    int newton(const std::vector<Prism>& prisms, const VectorX& r, double least, int most,
               VectorX& multipliers) const;
    double area(const PointsView& points) const;
    /// Takes that combination of the last steps off x and the multipliers which leaves the least r^T K^-1 r.
    /// \param count  of steps before.
    static void mix(Workspace& work, int count);

    std::shared_ptr<const RingRotations> rings_;
    DisplacementVectors vectors_;
    std::vector<int> free_; ///< vertices
    std::vector<char> is_free_;
    VectorX mass_;
    double softness_ = 0; ///< on the diagonal of K
    SpdFactor factor_;
    mutable Pool<Workspace> workspaces_;
};

} // namespace sinew

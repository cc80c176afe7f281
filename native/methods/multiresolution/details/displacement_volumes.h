// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/memory.h"
#include "native/mesh/regions.h"
#include "native/methods/multiresolution/details/detail_coding.h"
#include "native/methods/multiresolution/details/displacement_vectors.h"
#include "native/methods/multiresolution/details/ring_rotations.h"
#include "native/solvers/single_factor.h"

#include <array>
#include <memory>
#include <vector>

namespace sinew {

/// The signed volume of the prism between a triangle b of the base and one x of the surface, with ruled
/// walls.
///
/// Over the point of b with barycentric coordinates u, the prism has the volume N d(u), where d = x - b is
/// linear on the triangle, and
///
///     N = 1/3 (Nb + 1/2 Nm + Nx),   Nb = e1 x e2,   Nx = f1 x f2,   Nm = e1 x f2 + f1 x e2
///
/// with the edges e of b and f of x. The cell of a corner is where its coordinate is the largest.
struct Prism
{
    std::array<double, 3> volumes; ///< over the cells of the corners
    std::array<Matrix3, 3> slopes; ///< of each volume by the three corners of the surface, column by column
};
Prism prism_between(const PointsView& coarse, const PointsView& fine, const Triangle& triangle);

/// Details as volumes between the base and the surface, so that they do not meet where the base bends
/// inwards.
///
/// M. Botsch, L. Kobbelt. "Multiresolution Surface Representation Based on Displacement Volumes."
/// Eurographics 2003. Tutorial, section 4.4.3.
///
///     least sum_i m_i |F_i^-1 (x_i - x0_i)|^2   such that   V_i(x, b') = V_i(y, b) at each free vertex
///
/// V_i is the volume over the cell of a vertex, and x0 the result of DisplacementVectors. F_i is the mean map
/// of the triangles of the base there (RingRotations), so moves are measured as they would be at rest.
/// Departs from the paper by one volume per vertex, and by its solver. With J = dV/dx and W = F M^-1 F^T, a
/// step is x += W J^T l. Where F changes little from vertex to vertex, J F is det(F) times what it was at
/// rest, so
///
///   chord   l = S^-1 K^-1 S^-1 r, with S = det F and the factor of K = J M^-1 J^T of the rest shape, takes
///           off nine tenths of the residual r where heights times curvature are small. It goes on as long as
///           two steps halve r. Of the last steps that combination is taken off which leaves the least r^T l
///           (D. Anderson. "Iterative Procedures for Nonlinear Integral Equations." Journal of the ACM, 1965)
///   Newton  J W J^T l = r by conjugate gradients with the same as their preconditioner, where the first
///           step of the chord changes an edge by more than .4 of its length, where the chord stalls, or
///           where the area of the base changes by more than a tenth. A step that changed an edge by more
///           than .8 of its length is made shorter: many shapes have these volumes, and a whole step from
///           where bumps meet on the inside of a bend leads to one with corners turned over
///
/// With thirds of the prisms at a vertex instead of cells, sums over each triangle could vanish while
/// vertices move to and fro, and the steps would not converge so fast on fine meshes. Volumes are kept, so a
/// base that is scaled by s has details that are lower by s^2.
///
///   call         cost
///   constructor  a factor of the thin shell's size
///   apply()      some 4 to 8 steps of a solve for one column each, where heights times curvature stay below
///                .7; beyond that 15 to 70 solves, and 150 at most
class DisplacementVolumes final : public DetailCoding
{
public:
    /// \param regions       those of the fairing.
    /// \param fine, coarse  (n, 3) the band at rest.
    /// \param wider         as for the fairing, whose analysis this shares.
    /// \throw FactorizationFailed  the element is a vertex.
    DisplacementVolumes(const SurfaceMesh& rest, const Regions& regions, const PointsView& fine,
                        const PointsView& coarse, std::shared_ptr<const RingRotations> rings,
                        const Regions* wider = nullptr);

    /// Adds its steps to the iterations, and one to the fallbacks where it needs Newton's; the residual is
    /// the largest error of a volume, as a share of their mean. Where that is not below 1e-6, the report has
    /// not converged, and the shape is the best one found.
    void apply(const Band& band, Points& detailed, SolveReport& report) const override;
    void report(BindReport& report) const override;

    /// (n) V_i; 0 at vertices that are not free.
    VectorX volumes(const PointsView& fine, const PointsView& coarse) const;

private:
    static constexpr int kept_steps = 4;

    /// The last steps of the chord, in turn.
    struct Steps
    {
        std::array<VectorX, kept_steps> left, multipliers; ///< their changes
        std::array<Points, kept_steps> x; ///< likewise
        Eigen::Matrix<double, kept_steps, kept_steps> products; ///< of changes of r and l
        VectorX last_left, last_multipliers;
    };

    struct Workspace
    {
        std::vector<std::array<double, 3>> cells; ///< volumes of the triangles
        std::vector<Matrix3> maps, forces; ///< of the triangles
        std::vector<Matrix3> metric; ///< (n) F F^T / m
        VectorX inverse; ///< (n) 1 / det F
        Steps steps;
        VectorX goal, left, multipliers;
        MatrixX unknowns;
        Points x, move, best;
    };

    void evaluate(const PointsView& fine, const PointsView& coarse, Workspace& work, VectorX& volumes) const;
    /// The last sum of RingRotations at a vertex, as `metric` and `inverse`.
    void take_map(int vertex, const Matrix3& rotation, const Matrix3& sum, Workspace& work) const;
    /// x0, and the maps of the base.
    void begin(const Band& band, Workspace& work, Points& detailed, SolveReport& report) const;
    /// move = W J^T multipliers.
    void pull(const PointsView& x, const PointsView& coarse, const VectorX& multipliers, Workspace& work,
              Points& move) const;
    /// J move.
    void push(const PointsView& x, const PointsView& coarse, const Points& move, Workspace& work,
              VectorX& change) const;
    /// S^-1 K^-1 S^-1 r
    void precondition(const VectorX& r, Workspace& work, VectorX& solved) const;
    /// Solves J W J^T l = r until the largest residual is below `least`, or by `most` solves; returns their
    /// number. l is the workspace's multipliers.
    int newton(const PointsView& x, const PointsView& coarse, const VectorX& r, double least, int most,
               Workspace& work) const;
    double area(const PointsView& points) const;
    /// The largest change of an edge by a move, as a share of the edge's length in a shape.
    double stretch(const PointsView& shape, const Points& move) const;
    /// (n, n) J M^-1 J^T of the free vertices, in the pattern of the thin shell.
    SparseMatrix stiffness(const PointsView& fine, const PointsView& coarse) const;
    /// Which share of each of the last steps to take off; takes it off the multipliers.
    /// \param count  of steps before.
    static std::array<double, kept_steps> mix(Workspace& work, int count);

    std::shared_ptr<const RingRotations> rings_;
    DisplacementVectors vectors_;
    std::vector<FaceDual> duals_; ///< of the base at rest
    std::vector<double> ring_area_; ///< (n) of the triangles with a dual there
    std::vector<int> free_; ///< vertices
    std::vector<char> is_free_;
    VectorX mass_, volumes_; ///< at rest
    double area_ = 0; ///< of the base at rest
    double softness_ = 0; ///< on the diagonal of K
    std::vector<int> unknowns_; ///< vertices
    SingleFactor factor_;
    mutable Pool<Workspace> workspaces_;
};

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/methods/space/cage/cage_coordinates.h"
#include "native/methods/space/cage/harmonic/data.h"
#include "native/methods/space/cage/harmonic/grid.h"
#include "native/methods/space/cage/inside/cage_surface.h"
#include "native/methods/space/cage/inside/outside_weights.h"

#include <memory>

namespace sinew {

class HarmonicBoundary;

enum class HarmonicQuality {
    fast,   ///< at most 1000 unknowns of flux, or a lattice of 96 steps
    medium, ///< at most 2000 unknowns, or 160 steps
    fine,   ///< at most 4100 unknowns, or 256 steps
    finest  ///< at most 12000 unknowns (a reference that takes minutes and 1.2 GB), or 384 steps
};

enum class HarmonicSolver {
    automatic, ///< boundary for up to 600 triangles, lattice for more
    boundary,  ///< boundary elements on the cage, see HarmonicBoundary
    lattice    ///< differences on a lattice inside the cage, see HarmonicGrid
};

constexpr auto choices(HarmonicQuality)
{
    return std::array{Choice{"fast", HarmonicQuality::fast}, Choice{"medium", HarmonicQuality::medium},
                      Choice{"fine", HarmonicQuality::fine}, Choice{"finest", HarmonicQuality::finest}};
}
constexpr auto choices(HarmonicSolver)
{
    return std::array{Choice{"auto", HarmonicSolver::automatic}, Choice{"boundary", HarmonicSolver::boundary},
                      Choice{"lattice", HarmonicSolver::lattice}};
}

struct HarmonicOptions
{
    PointWeightOptions weights;
    HarmonicQuality quality = HarmonicQuality::medium;
    CageOutside outside = CageOutside::refuse;
    HarmonicSolver solver = HarmonicSolver::automatic;

    static constexpr auto table()
    {
        using O = HarmonicOptions;
        return std::tuple{
            option("quality", &O::quality, Rebind::anew,
                   "'fast', 'medium', 'fine' or 'finest': at most 1000, 2000, 4100 or 12000 unknowns on "
                   "the cage, with time proportional to their cube and memory to their square; or 96, 160, "
                   "256 or 384 steps of the lattice along the cage's longest side"),
            option("outside", &O::outside, Rebind::anew,
                   "points outside: 'error' names them, 'mean_value' gives them mean value weights"),
            option("solver", &O::solver, Rebind::anew,
                   "'boundary' elements or a 'lattice'; 'auto' takes the lattice for more than 600 "
                   "triangles")};
    }
};

/// Harmonic coordinates of a closed cage.
///
/// P. Joshi, M. Meyer, T. DeRose, B. Green, T. Sanocki. "Harmonic Coordinates for Character Articulation."
/// ACM Transactions on Graphics 26(3), 2007. Tutorial, section 5.4.
///
/// w_v is harmonic inside the cage. On its faces, w_v is 1 at v and 0 at the other vertices: linear on
/// triangles and on the triangles that larger faces are cut into, bilinear on parallelograms. On other quads
/// that are plane and convex it is similar to that, see HarmonicData; twisted quads are cut into two
/// triangles. Departs from the paper, whose grid has the boundary only to the size of a cell. Cages of up to
/// 600 triangles are solved by boundary elements, see HarmonicBoundary: weights are smooth inside, and the
/// error falls with finer patterns of panels. For larger ones that would cost faces^3. They are solved on a
/// lattice whose lines end exactly on the cage, see HarmonicGrid. Both are exact on the cage (to 1e-10 of its
/// size).
///
/// The weights of both are then corrected: negative ones become 0, and each is multiplied by 1 + a . (1, v -
/// x), where a has four numbers per point that restore the sum 1 and linear precision.
///
///   call          cost
///   constructor   O(cage)
///   bind()        boundary: O(points x faces); the first call also solves, O((faces x unknowns per face)^3)
///                 lattice: O(steps^3 + vertices x nodes around a vertex + points x vertices)
class Harmonic : public CageCoordinates
{
public:
    explicit Harmonic(Cage cage, const HarmonicOptions& options = {});
    ~Harmonic() override;

    /// After bind(): the number of unknowns of the flux, or of nodes of the lattice.
    int unknowns() const { return unknowns_; }
    /// After bind(): how far the weights are from the data on the cage, see HarmonicBoundary; 0 with a
    /// lattice.
    double residual_rms() const;
    double residual_max() const;

protected:
    /// \throw InvalidMesh  with boundary elements, faces have no area or touch one another.
    double prepare(PointsView points, const Progress& progress) override;
    void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    void swap_weights(SpaceMethod& other) override;
    bool reaches_outside() const override { return outside_.reaches(); }
    void finish(SpaceReport& report) const override;
    void release() override { grid_.reset(); }

private:
    void solve_boundary(PointsView points, const Progress& progress);
    /// Computes the rows of points inside.
    /// \return whether each point is inside
    std::vector<char> evaluate(const HarmonicBoundary& boundary, PointsView block, RowMatrix& rows) const;
    void complete(PointsView block, RowMatrix& rows, std::vector<char>& inside) const;
    void correct(PointsView block, const std::vector<int>& inside, RowMatrix& rows) const;
    void correct_near_cage(const Vector3& point, Eigen::Ref<Eigen::RowVectorXd> row) const;

    HarmonicOptions options_;
    HarmonicSolver solver_; ///< never automatic
    CageSurface surface_;
    OutsideWeights outside_;
    std::vector<HarmonicData> data_;
    RowMatrix places_; ///< (4, vertices) 1 and the vertex relative to middle_, in units of the cage's size
    RowMatrix products_; ///< (vertices, 10) the products of these four with each other
    Vector3 middle_;
    std::unique_ptr<HarmonicBoundary> boundary_;
    std::unique_ptr<HarmonicBoundary> coarser_;   ///< for the estimate of the error
    std::unique_ptr<HarmonicGrid::Weights> grid_; ///< during bind(), the weights of the points
    int unknowns_ = 0;
    double error_ = 0.0;
};

} // namespace sinew

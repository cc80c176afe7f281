// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/cage_coordinates.h"
#include "native/space/cage/harmonic/data.h"
#include "native/space/cage/harmonic/grid.h"
#include "native/space/cage/inside/cage_surface.h"
#include "native/space/cage/inside/outside_weights.h"

#include <memory>

namespace sinew {

class HarmonicBoundary;

enum class HarmonicQuality {
    fast,   ///< at most 1000 unknowns of flux; a lattice of 96 steps
    medium, ///< at most 2000; 160
    fine,   ///< at most 4100; 256
    finest  ///< at most 12000: a reference, in minutes and 1.2 GB; 384
};

enum class HarmonicSolver {
    automatic, ///< elements up to 600 triangles, beyond them a lattice
    boundary,  ///< elements on the cage: see HarmonicBoundary
    lattice    ///< differences inside it: see HarmonicGrid
};

struct HarmonicOptions
{
    PointWeightOptions weights;
    HarmonicQuality quality = HarmonicQuality::medium;
    CageOutside outside = CageOutside::refuse;
    HarmonicSolver solver = HarmonicSolver::automatic;
};

/// Harmonic coordinates of a closed cage.
///
/// P. Joshi, M. Meyer, T. DeRose, B. Green, T. Sanocki. "Harmonic Coordinates for Character Articulation."
/// ACM Transactions on Graphics 26(3), 2007. Tutorial, section 5.4.
///
/// w_v is harmonic inside the cage, and on its faces 1 at v, 0 at the others: linear on triangles and on the
/// triangles of larger faces, bilinear on parallelograms. On other quads that are plane and convex it is the
/// quadratic on their halves closest to that; twisted quads are their two triangles. Departs from the paper,
/// whose grid holds the boundary to a cell. Cages of up to 600 triangles are solved by boundary elements, see
/// HarmonicBoundary: weights are smooth inside, and the error shrinks with the pattern of panels. Larger
/// ones, whose system would cost faces^3, are solved on a lattice that knows where it is cut, see
/// HarmonicGrid. Both are exact on the cage (to 1e-10 of its size).
///
/// Weights are mended: negative ones become 0, and a factor 1 + a . (1, v - x) a weight, with one a of four
/// numbers a point, gives back sum 1 and linear precision.
///
///   call          cost
///   constructor   O(cage)
///   bind()        boundary: the first one solves it, O((faces * unknowns a face)^3); O(points x faces)
///                 lattice: each one, O(steps^3 + vertices x nodes around one); O(points x vertices)
class Harmonic : public CageCoordinates
{
public:
    explicit Harmonic(Cage cage, const HarmonicOptions& options = {});
    ~Harmonic() override;

    /// Unknowns of the boundary's flux, or nodes of the lattice; once bound.
    int unknowns() const { return unknowns_; }
    /// How far the weights miss the data on the cage, once bound: see HarmonicBoundary. 0 on a lattice.
    double residual_rms() const;
    double residual_max() const;

protected:
    /// \throw InvalidMesh  boundary: faces without area, or that touch one another; named.
    double prepare(PointsView points, const Progress& progress) override;
    void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    void swap_weights(SpaceMethod& other) override;
    bool reaches_outside() const override { return outside_.reaches(); }
    void finish(SpaceReport& report) const override;
    void release() override { grid_.reset(); }

private:
    void solve_boundary(PointsView points, const Progress& progress);
    /// Rows of points inside; true where a point is.
    std::vector<char> evaluate(const HarmonicBoundary& boundary, PointsView block, RowMatrix& rows) const;
    void settle(PointsView block, RowMatrix& rows, std::vector<char>& inside) const;
    void mend(PointsView block, const std::vector<int>& inside, RowMatrix& rows) const;
    void mend_near(const Vector3& point, Eigen::Ref<Eigen::RowVectorXd> row) const;

    HarmonicOptions options_;
    HarmonicSolver solver_; ///< never automatic
    CageSurface surface_;
    OutsideWeights outside_;
    std::vector<HarmonicData> data_;
    RowMatrix places_;   ///< (4, vertices) a 1 and the vertex about the cage's middle, in units of its size
    RowMatrix products_; ///< (vertices, 10) products of these four with each other
    Vector3 middle_;
    std::unique_ptr<HarmonicBoundary> boundary_, coarser_;
    std::unique_ptr<HarmonicGrid::Weights> grid_; ///< of the points that are being bound
    int unknowns_ = 0;
    double error_ = 0.0;
};

} // namespace sinew

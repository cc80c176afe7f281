// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/cage/cage_coordinates.h"
#include "native/methods/space/cage/closed_forms/cage_geometry.h"
#include "native/methods/space/cage/closed_forms/flat_forms.h"

#include <optional>

namespace sinew {

/// Mean value coordinates of a closed triangle mesh.
///
/// T. Ju, S. Schaefer, J. Warren. "Mean Value Coordinates for Closed Triangular Meshes." ACM Transactions on
/// Graphics 24(3), 2005. Tutorial, section 5.4.
///
/// w_v(x) = sum over the triangles at v of the integral of v's hat function / |p - x| over the image of the
/// triangle on the unit sphere around x; the weights are w_v / sum w. They sum to 1 and have linear precision
/// everywhere, also on the cage and outside. They may be negative where, seen from x, one part of a concave
/// cage hides another.
///
/// They are computed in the plane of the triangle instead of on the sphere, with h the height of x below it,
/// p_k the distance of its foot from side k, H_k the height over side k, m_k the normals of the sides, and
/// J_k the integral of 1 / |y - x|^2 over side k (its angle divided by its distance):
///
///     w_k = (p_k T + h/2 sum_j (m_k . m_j) J_j) / H_k,    T = sum_j p_j J_j / 2h
///
/// This takes one angle per edge. Near the plane of a triangle, beside its sides, the sum for T would lose
/// 1e-16 / h, so T is the sum of separate integrals of the sides there. The weights are accurate to 1e-12
/// within some sizes of the cage, however near x is to its faces. Farther away, the error grows with the cube
/// of the distance, to 1e-7 at 1,000 sizes. A point even farther away takes the weights of the point at 1,000
/// sizes in the same direction.
///
/// A flat cage has the coordinates of its outline, in its plane:
///
/// M. S. Floater. "Mean Value Coordinates." Computer Aided Geometric Design 20(1), 2003. K. Hormann, M. S.
/// Floater. "Mean Value Coordinates for Arbitrary Planar Polygons." ACM Transactions on Graphics 25(4), 2006.
///
/// The outline may be concave and have holes. The weights sum to 1 and have linear precision in the plane. A
/// point over the plane keeps its distance from it: it moves along the normal of the posed cage.
///
/// If parts of a cage that crosses itself are inside out, there may be points where sum w is 0 and the
/// weights have no meaning. Such points stay at rest and are reported as outside.
class MeanValue : public CageCoordinates
{
public:
    static constexpr bool takes_flat = true;
    explicit MeanValue(Cage cage, const PointWeightOptions& options = {});

protected:
    void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const override;
    /// The vertices; of a flat cage also its normal, times its size.
    int columns() const override;
    void controls(PointsView vertices, Points& controls) const override;

private:
    CageGeometry geometry_;
    std::optional<FlatForms> flat_;
};

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/cage_coordinates.h"
#include "native/space/cage/closed_forms/cage_geometry.h"

namespace sinew {

/// Mean value coordinates of a closed triangle mesh.
///
/// T. Ju, S. Schaefer, J. Warren. "Mean Value Coordinates for Closed Triangular Meshes." ACM Transactions on
/// Graphics 24(3), 2005. Tutorial, section 5.4.
///
/// w_v(x) = sum over the triangles at v of the integral of v's hat function / |p - x| over the triangle's
/// image on the unit sphere around x; weights are w_v / sum w. Sum 1 and linear precision everywhere, on the
/// cage and outside it too; may be negative where a concave cage is seen through itself.
///
/// Written on the triangle's plane instead of the sphere, with h the height of x below it, p_k its foot's
/// distance from side k, H_k the height over side k, m_k the normals of the sides and J_k the integral of
/// 1 / |y - x|^2 over side k (its angle over its distance):
///
///     w_k = (p_k T + h/2 sum_j (m_k . m_j) J_j) / H_k,    T = sum_j p_j J_j / 2h
///
/// which takes one angle an edge. Near the plane of a triangle beyond whose sides x lies, T is the sum of the
/// sides' own integrals, where the sum above would lose 1e-16 / h. To 1e-12 within some sizes of the cage,
/// however near its faces; outside, digits are lost with the cube of the distance (1e-7 at 1,000 sizes), and
/// a point farther than that takes the weights of the one at 1,000 sizes on its way to the centre.
///
/// A cage that crosses itself inside out may have points where its parts balance, so that weights have no
/// meaning: these stay at rest, and are reported as outside.
class MeanValue : public CageCoordinates
{
public:
    explicit MeanValue(Cage cage, const PointWeightOptions& options = {})
        : CageCoordinates(std::move(cage), options), geometry_(this->cage())
    {
    }

protected:
    void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const override;

private:
    CageGeometry geometry_;
};

} // namespace sinew

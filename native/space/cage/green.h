// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/cage_coordinates.h"
#include "native/space/cage/closed_forms/cage_geometry.h"

namespace sinew {

/// What becomes of points outside, where Green's identity gives nothing.
enum class GreenOutside {
    nearest, ///< continued through the triangle nearest to each point
    face,    ///< continued through one triangle, the same for all points
    refuse   ///< they are an error that names them
};

struct GreenOptions
{
    PointWeightOptions weights;
    GreenOutside outside = GreenOutside::nearest;
    int exit_face = -1; ///< of the cage, for GreenOutside::face
};

/// Green coordinates of a closed triangle mesh.
///
/// Y. Lipman, D. Levin, D. Cohen-Or. "Green Coordinates." ACM Transactions on Graphics 27(3), 2008. Tutorial,
/// section 5.4.
///
///     x' = sum_v phi_v(x) v' + sum_t psi_t(x) s_t n'_t
///
/// phi and psi by Green's third identity, n'_t the normal of the deformed triangle t and s_t its stretch (the
/// paper's equation 9), which is 1 where the triangle is turned and moved alone. Shapes are kept instead of
/// following shears: similarities are reproduced, other affine maps are not.
///
/// With h, p_k, H_k, m_k as for MeanValue, l_k the integral of 1 / |y - x| over side k (one logarithm an
/// edge) and Omega the triangle's solid angle (one arc tangent a triangle),
///
///     4 pi psi = sum_k p_k l_k - h Omega,    4 pi phi_k = (p_k Omega + h sum_j (m_k . m_j) l_j) / H_k
///
/// to 1e-12, however near the faces, edges and vertices; a point nearer than 1e-13 of the cage's size to an
/// edge or vertex takes the coordinates of one 1e-12 further in.
///
/// Inside, phi sums to 1; outside to 0, and x' would be 0. The paper continues the map through a face t (its
/// section 5): x = sum alpha_v v + beta n_t over the corners of t, and alpha and beta are added to phi and
/// psi. Crossing t the map is then analytic. Through another face it is another map once the cage is
/// deformed: with GreenOutside::nearest, points move apart where the nearest triangle changes, the less the
/// nearer they are to the cage. Where parts of the cage overlap, phi and psi are divided by how often they
/// wind around x.
///
/// A point farther than 1,000 sizes of the cage takes the coordinates of the one at 1,000 sizes on its way to
/// the centre. A triangle without area, height below 1e-8 of the cage's size, has no psi. One that a pose
/// leaves without area has no normal: its s n' is 0, for as long as it is so.
class Green : public CageCoordinates
{
public:
    /// \throw InvalidOption  exit_face is no face of the cage, or none of its triangles has an area.
    explicit Green(Cage cage, const GreenOptions& options = {});

    /// (n, t) psi of each triangle that the cage's faces are cut into, in the cage's units of length.
    RowMatrix face_weights() const;

protected:
    void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    int columns() const override;
    /// The vertices, then s n' of each triangle times the cage's size: weights have no unit.
    void controls(PointsView vertices, Points& controls) const override;
    bool reaches_outside() const override { return options_.outside != GreenOutside::refuse; }

private:
    struct Told;
    /// Adds the continuation through a triangle to the row of a point outside.
    template <class Row>
    void continue_through(const Vector3& x, Row&& row) const;
    bool is_on_cage(const Vector3& x) const;
    /// A point on the cage, moved a little into it.
    Vector3 moved_in(const Vector3& x) const;

    CageGeometry geometry_;
    GreenOptions options_;
    int exit_ = -1; ///< of the geometry's triangles
};

} // namespace sinew

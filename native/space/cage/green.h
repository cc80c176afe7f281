// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/space/cage/cage_coordinates.h"
#include "native/space/cage/closed_forms/cage_geometry.h"

namespace sinew {

/// What to do with points outside, where Green's identity gives nothing.
enum class GreenOutside {
    nearest, ///< the map is continued through the triangle nearest to each point
    face,    ///< the map is continued through one triangle, the same for all points
    refuse   ///< bind() throws an error that names them
};

struct GreenOptions
{
    PointWeightOptions weights;
    GreenOutside outside = GreenOutside::nearest;
    int exit_face = -1; ///< the face of the cage that GreenOutside::face uses
};

/// Green coordinates of a closed triangle mesh.
///
/// Y. Lipman, D. Levin, D. Cohen-Or. "Green Coordinates." ACM Transactions on Graphics 27(3), 2008. Tutorial,
/// section 5.4.
///
///     x' = sum_v phi_v(x) v' + sum_t psi_t(x) s_t n'_t
///
/// phi and psi come from Green's third identity, n'_t is the normal of the deformed triangle t and s_t its
/// stretch (the paper's equation 9), which is 1 if the triangle is only rotated and translated. The
/// coordinates keep shapes and do not follow shears: they reproduce similarities, but no other affine maps.
///
/// With h, p_k, H_k, m_k as for MeanValue, l_k the integral of 1 / |y - x| over side k (one logarithm per
/// edge) and Omega the solid angle of the triangle (one arc tangent per triangle),
///
///     4 pi psi = sum_k p_k l_k - h Omega,    4 pi phi_k = (p_k Omega + h sum_j (m_k . m_j) l_j) / H_k
///
/// They are accurate to 1e-12, however near x is to the faces, edges and vertices. A point nearer to an edge
/// or vertex than 1e-13 of the cage's size takes the coordinates of a point 1e-12 further inside.
///
/// Inside, phi sums to 1. Outside, it sums to 0, and x' would be 0. The paper therefore continues the map
/// through a face t (its section 5): x = sum alpha_v v + beta n_t over the corners of t, and alpha and beta
/// are added to phi and psi. The map is then analytic across t. Through another face it is another map once
/// the cage is deformed: with GreenOutside::nearest, neighbouring points may move apart where the nearest
/// triangle changes; the nearer they are to the cage, the less. Where parts of the cage overlap, phi and psi
/// are divided by how often they wind around x.
///
/// A point farther from the centre of the cage than 1,000 of its sizes takes the coordinates of the point at
/// 1,000 sizes in the same direction. A triangle without area (its height is below 1e-8 of the cage's size)
/// has no psi. While a pose leaves a triangle without area, it has no normal, and its s n' is 0.
class Green : public CageCoordinates
{
public:
    /// \throw InvalidOption  exit_face is no face of the cage, or has no area.
    explicit Green(Cage cage, const GreenOptions& options = {});

    /// (n, t) psi of each triangle that the cage's faces are cut into, in the unit of length of the cage.
    RowMatrix face_weights() const;

protected:
    void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    int columns() const override;
    /// The vertices, then s n' of each triangle, multiplied by the cage's size so that the weights have no
    /// unit.
    void controls(PointsView vertices, Points& controls) const override;
    bool reaches_outside() const override { return options_.outside != GreenOutside::refuse; }

private:
    struct KernelResults;
    /// Adds alpha and beta to the row of a point outside.
    template <class Row>
    void continue_through(const Vector3& x, Row&& row) const;
    bool is_on_cage(const Vector3& x) const;
    /// The point of the cage x, moved a little into the cage.
    Vector3 moved_in(const Vector3& x) const;

    CageGeometry geometry_;
    GreenOptions options_;
    int exit_ = -1; ///< the triangle of the geometry that GreenOutside::face uses
};

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/methods/space/cage/cage_coordinates.h"
#include "native/methods/space/cage/closed_forms/cage_geometry.h"
#include "native/methods/space/cage/closed_forms/flat_forms.h"
#include "native/methods/space/cage/closed_forms/quad_patches.h"
#include "native/methods/space/cage/closed_forms/smooth_normals.h"

#include <optional>
#include <vector>

namespace sinew {

/// What to do with points outside, where Green's identity gives nothing.
enum class GreenOutside {
    nearest, ///< the map is continued through the triangle nearest to each point
    face,    ///< the map is continued through one triangle, the same for all points
    refuse   ///< bind() throws an error that names them
};

/// What a face with four corners is.
enum class GreenFaces {
    triangles, ///< two triangles; the map depends on which diagonal cuts the face
    quads      ///< a bilinear patch, which no diagonal cuts
};

/// How the normals of a smooth cage follow.
enum class GreenNormals {
    control_points, ///< by three columns per control point, to about 1/1000 of the cage's size
    faces           ///< each by itself: exact, but a frame costs as much as for a cage with all these faces
};

constexpr auto choices(GreenOutside)
{
    return std::array{Choice{"nearest", GreenOutside::nearest}, Choice{"face", GreenOutside::face},
                      Choice{"error", GreenOutside::refuse}};
}
constexpr auto choices(GreenFaces)
{
    return std::array{Choice{"triangles", GreenFaces::triangles}, Choice{"quads", GreenFaces::quads}};
}

constexpr auto choices(GreenNormals)
{
    return std::array{Choice{"control_points", GreenNormals::control_points},
                      Choice{"faces", GreenNormals::faces}};
}

struct GreenOptions
{
    PointWeightOptions weights;
    GreenOutside outside = GreenOutside::nearest;
    int exit_face = -1;
    GreenFaces faces = GreenFaces::triangles;
    GreenNormals normals = GreenNormals::control_points;

    static constexpr auto table()
    {
        using O = GreenOptions;
        return std::tuple{
            option("outside", &O::outside, Rebind::anew,
                   "for points outside, the map is continued through the 'nearest' triangle or through one "
                   "'face', or an 'error' names them"),
            option("exit_face", &O::exit_face, Rebind::anew, any_number(),
                   "the face of the cage for outside='face'"),
            option("faces", &O::faces, Rebind::anew,
                   "a face with four corners is two 'triangles', or a bilinear patch, which no diagonal "
                   "cuts: 'quads'"),
            option("normals", &O::normals, Rebind::anew,
                   "the normals of a smooth cage follow its 'control_points', three columns for each, or are "
                   "exact with a column per triangle, three per quad: 'faces'")};
    }
};

/// Green coordinates of a closed mesh of triangles and quads.
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
/// With GreenFaces::quads, faces with four corners are bilinear patches P(s, t):
///
/// J.-M. Thiery, T. Boubekeur. "Green Coordinates for Triquad Cages in 3D." SIGGRAPH Asia 2022 Conference
/// Papers.
///
///     x' = sum_v phi_v(x) v' + sum_t psi_t(x) s_t n'_t + sum_q sigma_q sum_k psi_qk(x) N'_qk
///
/// phi of a corner is the integral of its bilinear weight times (P - x) . n / 4 pi r^3 over the patch. The
/// normal dP/ds x dP/dt is N_0 + s N_1 + t N_2, in three parts and not four as in the paper, because that of
/// s t is 0; psi_qk is the integral of 1, s or t over 4 pi r. Departs from the paper: the stretch sigma_q is
/// one number per quad instead of one per corner, the mean stretch over the patch divided by the growth of
/// its area (Gauss's rule with 2 x 2 points). The integrals are computed to 1e-11, see QuadPatches. A point
/// nearer to a patch than 1e-10 of the cage's size takes the weights of a point 1e-9 further inside. Then
/// the weights of the patch nearest to a point are changed by what is left of sum phi = 1 and of
/// sum phi v + sum psi N = x, so that similarities are reproduced to rounding. Outside, the map is continued
/// through the place (s, t) of the patches nearest to x: x = P + alpha dP/ds + beta dP/dt + gamma n. Faces
/// that fold as patches, such as darts, are two triangles.
///
/// With a smooth cage, phi of its control points is phi S (SmoothCage). The stretched normals are not linear
/// in them; SmoothNormals fits them by three columns per control point, which reproduces similarities. For
/// poses that bend or twist a cage of 16 points by a right angle, or move one point by half its width, this
/// moves points by at most 1/500 of the size of the cage, a hundredth of their way. GreenNormals::faces has
/// no such error.
///
/// A flat cage has the coordinates of its outline, in its plane (the 2D case of Lipman et al.): n'_e is the
/// outer normal of an edge in the plane of the posed cage and s_e its stretch. The map of the plane is
/// conformal. Outside, it is continued through the nearest edge. A point over the plane keeps its distance
/// from it: it moves along the normal of the posed cage.
///
/// A point farther from the centre of the cage than 1,000 of its sizes takes the coordinates of the point at
/// 1,000 sizes in the same direction. A triangle without area (its height is below 1e-8 of the cage's size)
/// has no psi. While a pose leaves a triangle without area, it has no normal, and its s n' is 0.
class Green : public CageCoordinates
{
public:
    static constexpr bool takes_flat = true;
    /// \throw InvalidOption  GreenOutside::face is asked for with a flat cage, or exit_face is no face of the
    /// cage, or has no area.
    explicit Green(Cage cage, const GreenOptions& options = {});

    /// (n, f) psi of each triangle that the cage's faces are cut into, in the unit of length of the cage.
    /// With GreenFaces::quads, triangles of patches are left out, and behind the others are three columns per
    /// patch, in the inverse of that unit. Of a flat cage, those of the edges of the outline. Of a smooth cage
    /// whose normals follow its control points, three columns for each of these, see SmoothNormals.
    RowMatrix face_weights() const;

protected:
    void evaluate(int first, PointsView block, RowMatrix& rows, std::vector<char>& outside) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    int columns() const override;
    /// The control points, then s n' of each triangle and sigma N' of each patch, or SmoothNormals, scaled so that the weights have
    /// no unit.
    void controls(PointsView vertices, Points& controls) const override;
    bool reaches_outside() const override { return options_.outside != GreenOutside::refuse; }
    int block_size() const override { return (patches_.count() > 0 ? 4 : 1) * PointWeights::part; }

private:
    struct KernelResults;
    struct Integrals;
    /// phi and psi of normalised points, times how often the cage winds around each.
    void integrate(const std::vector<Vector3>& points, Integrals& found) const;
    /// A triangle of the geometry, or if that is -1 a place of a patch, through which the map is continued.
    struct Exit
    {
        int triangle;
        QuadPatches::Place place;
    };
    Exit place_near(const Vector3& x) const;
    std::vector<SmoothNormals::Column> normal_columns() const;
    /// Adds alpha and beta to a row: weights whose sum is `sum` and whose point is `vector`.
    void represent(const Exit& exit, double sum, const Vector3& vector,
                   Eigen::Ref<Eigen::RowVectorXd> row) const;
    bool is_on_cage(const Vector3& x) const;
    /// The point of the cage x, moved a little into the cage.
    Vector3 moved_in(const Vector3& x) const;
    /// The columns before they are folded: vertices of cage().rest(), triangles, parts of patches.
    int first_of_patches() const { return cage().vertex_count() + triangle_columns_; }
    int wide() const { return first_of_patches() + 3 * patches_.count(); }

    std::vector<char> patch_faces_; ///< which faces of the cage are patches; empty for none
    CageGeometry geometry_;
    QuadPatches patches_;
    std::optional<FlatForms> flat_;
    std::optional<SmoothNormals> normals_; ///< of a smooth cage whose normals follow its control points
    GreenOptions options_;
    std::vector<int> columns_; ///< of each triangle of the cage; -1 for those of patches
    int triangle_columns_ = 0;
    int exit_ = -1;       ///< the triangle of the geometry that GreenOutside::face uses
    int exit_patch_ = -1; ///< or the patch
    Points rest_;         ///< what each column stands for at rest, normalised
};

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/methods/space/cage/cage.h"
#include "native/methods/space/cage/closed_forms/cage_geometry.h"
#include "native/methods/space/cage/closed_forms/quad_kernels.h"

#include <array>
#include <vector>

namespace sinew {

/// The faces of a cage with four corners that are bilinear patches in Green coordinates, in the frame of
/// CageGeometry.
///
/// Each patch has seven integrals at a point x: of (P - x) . normal / 4 pi r^3 times 1, s, t, s t, which give
/// phi of its corners, and of 1 / 4 pi r times 1, s, t, which are psi of the three parts of its normal.
///
/// Away from x they are sums over n x m Gauss points, with n and m chosen from a bound: with a line s -> P
/// whose middle is m_s of its half lengths away from x, the error falls by (m_s + sqrt(m_s^2 - 1))^2 per
/// point. Near x, lines of constant t are integrated in closed form, and Gauss's rule with 12 points is used
/// over t on panels that are halved until no singularity of the integrand in the complex plane is nearer than
/// half a panel, after a substitution that stretches what is close to x (t = d sinh xi, with d the distance).
/// The errors are below 1e-11 of the largest weight; at a distance d from an edge, measured in sizes of the
/// cage, rounding adds 1e-16 / d.
class QuadPatches
{
public:
    /// The faces of the cage that can be patches: four corners, and a normal that turns by less than a right
    /// angle from that of the middle. Others, such as darts, are triangulated.
    static std::vector<char> faces(const Cage& cage);

    /// \param faces  which faces of the cage are patches, as given by faces(); empty for none.
    QuadPatches(const Cage& cage, const CageGeometry& geometry, const std::vector<char>& faces);

    int count() const { return static_cast<int>(patches_.size()); }
    int face(int q) const { return faces_[static_cast<std::size_t>(q)]; }

    /// The place of a patch that is closest to a point, and its distance; none if q is -1.
    struct Place
    {
        int q = -1;
        double s = 0.0, t = 0.0, distance = 0.0;
    };
    Place closest(int q, const Vector3& x) const;
    /// The closest of all patches; of several, the first.
    Place closest(const Vector3& x) const;
    Vector3 normal(const Place& place) const;

    /// Adds phi and psi of all patches to the weights of some points.
    /// \param first               the column of the first psi; each patch has three.
    /// \param[in,out] weights     (points, columns); its first columns are the vertices.
    /// \param[in,out] winding     (points) to which the solid angles over 4 pi are added.
    /// \param[in,out] near        the closest place of the patches near each point, if it is closer than the
    ///                            place in there.
    void add(const std::vector<Vector3>& points, int first, MatrixX& weights, VectorX& winding,
             std::vector<Place>& near) const;

    /// Adds to a row what represents `sum` and `vector` around a place: weights whose sum is `sum` and whose
    /// point is `vector`, by the corners and the normal of the patch.
    void represent(const Place& place, double sum, const Vector3& vector, int first,
                   Eigen::Ref<Eigen::RowVectorXd> row) const;

    /// (3 count, 3) the stretched parts of the normals of the posed patches, in the unit of `vertices`.
    void controls(PointsView vertices, Eigen::Ref<Points> controls) const;
    /// The same at rest, with normalised vertices, without stretch.
    Vector3 rest_normal(int q, int part) const
    {
        return Vector3::Map(patches_[static_cast<std::size_t>(q)].normal[part]);
    }

private:
    struct Panels;
    Vector3 point(int q, double s, double t) const;
    void integrate_near(const Place& place, const Vector3& x, Panels& panels, double* moments) const;

    std::vector<QuadPatch> patches_;
    std::vector<std::array<int, 4>> corners_;
    std::vector<int> faces_;
    struct Reach
    {
        double radius;                    ///< of a ball around the centre that holds the patch
        std::array<double, 6> of_s, of_t; ///< squared distances from which each rule is good enough
    };
    std::vector<Reach> reaches_;
};

} // namespace sinew

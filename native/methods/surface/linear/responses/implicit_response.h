// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/memory.h"
#include "native/core/types.h"
#include "native/handles/handle_groups.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"
#include "native/operators/fits/ring_fit.h"
#include "native/solvers/constrained_quadratic.h"

#include <memory>
#include <span>
#include <vector>

namespace sinew {

/// (3n, 3n) the matrix of M^-1 L x - T(x) delta, a linear map of the coordinates x, y, z of all vertices.
/// T_i is the linear similarity that fits best to the ring of vertex i (see operators/fits/ring_fit.h), from
/// rest to x; on the border it scales and does not turn.
/// \param L, mass  M^-1 L of operators/laplacian.h.
/// \param rings    (n) of the rest shape.
/// \param delta    (n, 3) M^-1 L of the rest shape.
SparseMatrix implicit_residual(const SurfaceMesh& rest, const SparseMatrix& L, const VectorX& mass,
                               std::span<const Ring> rings, const Points& delta);

/// The surface whose differential coordinates are those of the rest shape up to local similarities, which are
/// unknowns themselves: the linear system of Laplacian surface editing, solved at bind.
///
/// O. Sorkine et al. "Laplacian Surface Editing." SGP 2004. Tutorial, section 4.5.3.
///
/// It minimises
///
///     E(x) = 1/2 sum_i m_i (|(M^-1 L x)_i - T_i(x) delta_i|^2 + e |(M^-1 L (x - rest))_i|^2)
///
/// with T_i of implicit_residual(), which is linear in x. The second term, with e = 1e-7, decides where
/// handles leave a similarity of the whole part open, as a single vertex does. Soft handles pull as in
/// handles/constrained_system.h.
///
/// Departs from the paper: rows of the border only scale. There, delta is not a curvature but the direction
/// out of the surface divided by the length of an edge; turned along, it would wreck open meshes.
///
/// The answer is linear in the motions of the handles. Up to 16 handles of a part, it is computed for each of
/// the 12 numbers of a motion, and the factor is dropped.
///
///   call         repeat it when ...     cost
///   constructor  the handles changed    a factorisation with 3n unknowns: 6 to 14 times that of L M^-1 L; 12
///                                       solves per handle
///   displace()   the handles moved      O(n k) for k handles of a part; beyond 16, one solve of 3n unknowns
class ImplicitResponse
{
public:
    /// \throw FactorizationFailed  the system is singular; the element of the error is a vertex.
    /// \throw OutOfMemory          the factor or the answers take more than limit_memory() allows.
    ImplicitResponse(const SurfaceMesh& rest, const SparseMatrix& L, const VectorX& mass,
                     std::span<const Ring> rings, const Points& delta, const Regions& regions,
                     HandleGroups groups);

    /// Up to a translation of each part, the displacements of the shape that enters, as seen from `frames`:
    /// the targets of the handles are turned back by them. For that shape, each part is turned as a whole
    /// from rest, and each handle in a part as another whole; what is left of its pose has no influence.
    /// \param frames  (groups) rotations.
    /// \param[out] displacements  (3n, 1) x, y and z of each vertex; zero in parts without a handle.
    void displace(const Targets& targets, const std::vector<Matrix3>& frames, RowMatrix& displacements) const;

    std::int64_t bytes() const;
    int analyses() const { return analyses_; }

private:
    /// A row of Regions::constraints().
    struct Pull
    {
        int vertex, part_handle;
        double stiffness; ///< 0 where the vertex is held
        Vector3 from_centre;
    };
    struct Workspace
    {
        RowMatrix pulls; ///< (3n, 1)
        ConstrainedQuadratic::Workspace work;
    };

    /// (groups) the rotation of each part from rest to a shape.
    std::vector<Matrix3> turns(const PointsView& rest, const PointsView& shape) const;
    /// (part handles) the displacement of a rest point u + centre of a handle: u -> A u + b.
    std::vector<Pose> moves(const Targets& targets, const std::vector<Matrix3>& frames,
                            const std::vector<Matrix3>& turns) const;

    HandleGroups groups_;
    std::vector<Vector3>
        centres_; ///< (part handles) the mean of the vertices of each handle in a part, at rest
    std::vector<Pull> pulls_;
    bool soft_;
    RowMatrix basis_; ///< (3n, 12 handles of a part) or empty
    std::unique_ptr<ConstrainedQuadratic> system_; ///< null with a basis
    int analyses_;
    mutable Pool<Workspace> workspaces_;
};

} // namespace sinew

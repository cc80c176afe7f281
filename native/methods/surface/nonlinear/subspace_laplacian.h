// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/methods/surface/method.h"

#include <optional>
#include <string>
#include <vector>

namespace sinew {

struct SubspaceLaplacianOptions
{
    int cage_faces = 0;
    int clusters = 60;
    double bending = 0.0015; ///< b / A in the energy, with the rest area A of the part
    bool keep_volume = true;
    int max_iterations = 60;
    double tolerance = 1e-5;

    static constexpr auto table()
    {
        using O = SubspaceLaplacianOptions;
        return std::tuple{
            option("cage_faces", &O::cage_faces, Rebind::anew, between(0, 2000),
                   "triangles of an automatic cage, from 12, or 0 for 160, and more beside handles that "
                   "are smaller than its faces, at most 600; a part with no more vertices than such a cage "
                   "is its own subspace"),
            option("clusters", &O::clusters, Rebind::update, at_least(1),
                   "clusters of vertices that share a rotation, in each part; each handle has its own"),
            option("bending", &O::bending, Rebind::update, at_least(0),
                   "how stiff the surface is in bends, as a share of the rest area of the part"),
            option("keep_volume", &O::keep_volume, Rebind::update,
                   "whether parts that are closed, or nearly, keep their volume"),
            iteration_limit(&O::max_iterations),
            stopping_tolerance(&O::tolerance)};
    }
};

/// Nonlinear Laplacian editing in the subspace of a cage, with the volume kept.
///
/// J. Huang, X. Shi, X. Liu, K. Zhou, L.-Y. Wei, S.-H. Teng, H. Bao, B. Guo, H.-Y. Shum. "Subspace Gradient
/// Domain Mesh Deformation." SIGGRAPH 2006. Tutorial, section 6.
///
/// The unknowns are the vertices y of a cage around each part with a handle; the surface is x = B y with the
/// mean value coordinates B of the cage (methods/space/cage/mean_value.h). With one rotation per cluster of
/// vertices, over ordered pairs of neighbours,
///
///     E = 1/4 sum_ij w_ij |x_i - x_j - R_c(i) (x_i - x_j)^0|^2
///       + 1/2 sum_i b / m_i |(L x)_i - R_c(i) (L x)_i^0|^2 + 1/2 sum_i s_i |x_i - t_i|^2
///
/// is least (local_global/reduced/subspace_cells.h), subject to volume(x) = volume(x^0). The sums are
/// gathered when handles are set, so an iteration never touches the surface. Handles lie anywhere on the
/// surface, not on the cage. A held vertex is pulled with 1e5 / (held vertices of its handle), a soft one of
/// weight w with w / (1 - w) L_ii, at most as a held one. Above a weight of 0.9, it turns with its handle, as
/// held ones do.
///
/// Departs from the paper: it keeps lengths of edges by a term of their own, as Laplacian coordinates are
/// zero on flat parts; it solves with a constant matrix instead of one that is made in each step. While
/// iterating, the volume is that of a coarse copy of the surface; then one step along the answer of the cage
/// to that volume's gradient makes the volume of the surface exact: along that line it is a cubic polynomial.
/// What a handle holds is put exactly where it belongs, and the gap, which is small, fades over
/// 4 % of the part's size; at soft vertices, it is put right the more, the nearer their weight is to 1.
/// Negative weights w_ij are made positive. Open borders of less than a tenth of the area are closed by fans;
/// parts that are more open have no volume to keep. A part that has no more vertices than its cage would have
/// is its own subspace.
///
/// A shape that enters is split into the part that the cage can show, which is the base shape, and what is
/// left, which is turned by the rotations of the clusters around it. Where no handle moves, it passes
/// through.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   nothing
///   set_handles()  another set of handles        one factorisation of L; the matrices of the clusters, as
///                                                much as two products of all weights with each other; the
///                                                first call also makes the cages and their weights, and
///                                                so does one that holds other vertices, with 0 cage_faces
///   solve()        the handles moved             iterations with the unknowns of the cage and, with the
///                                                volume, some 500 points; then one product of the weights
///                                                with x, y and z, with the volume two, and one pass over the
///                                                faces
class SubspaceLaplacian final : public SurfaceMethodWith<SubspaceLaplacianOptions>
{
public:
    /// \param cage  a closed mesh around all parts with a handle; without one, each of them gets its own.
    /// \throw InvalidOption  a number is out of range or not finite.
    /// \throw InvalidMesh    see Cage.
    explicit SubspaceLaplacian(const SurfaceMesh& rest, const SubspaceLaplacianOptions& options = {},
                               std::optional<SurfaceMesh> cage = {});

    /// The rest cages of the parts, in the order of their lowest vertices; none for a part that is its own
    /// subspace. Empty before the first bind.
    std::vector<SurfaceMesh> cages() const;
    /// (n) the cluster of each vertex, -1 in a part without a handle. Empty before the first bind.
    std::vector<int> clusters() const;

protected:
    /// \throw InvalidConstraint  vertices of a part with a handle are outside the given cage; they are named.
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    std::vector<std::string> changed_options(const SurfaceMethod& former) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew

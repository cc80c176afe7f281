// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/handles/handle_fields.h"
#include "native/methods/surface/method.h"

#include <string>
#include <vector>

namespace sinew {

struct HandleAwareIsolinesOptions
{
    int bands = 24;
    Field field = Field::harmonic;
    int max_iterations = 200;
    double tolerance = 1e-6;

    static constexpr auto table()
    {
        using O = HandleAwareIsolinesOptions;
        return std::tuple{
            option("bands", &O::bands, Rebind::update, at_least(2),
                   "bands between two handles; each handle has half of them around it"),
            option("field", &O::field, Rebind::update,
                   "whose isolines bound the bands: 'harmonic', 'geodesic' or 'euclidean'"),
            iteration_limit(&O::max_iterations,
                            "largest number of turns of a solve; each fits the rotations of all bands once"),
            stopping_tolerance(&O::tolerance,
                               "a solve stops when the matrix of no rotation changes by more than this")};
    }
};

/// As-rigid-as-possible deformation with one rotation for each band between two isolines of the handles'
/// fields.
///
/// O. K.-C. Au, H. Fu, C.-L. Tai, D. Cohen-Or. "Handle-Aware Isolines for Scalable Shape Editing." ACM
/// Transactions on Graphics 26(3), 2007. Tutorial, section 6.
///
/// With base points y (the incoming shape, or the rest shape), the band c(i) of vertex i, and one rotation
/// per band, over ordered pairs of neighbours,
///
///     E = sum_ij w_ij |(x_i - x_j) - R_c(i) (y_i - y_j)|^2
///
/// is least. s_h is the field of handle h, 1 on it and 0 on the others (see handles/handle_fields.h). A
/// vertex belongs to the handle whose field is largest, and to one of bands / 2 bands between s_h = 1 and the
/// least s_h among the vertices of that handle. The points are eliminated
/// (local_global/reduced/rotation_clusters.h): x = X P + Z R for affine poses P of the handles, so that turns
/// of rotations and points cost nothing of the size of the mesh. Soft handles pull with w / (1 - w) L_ii.
///
/// Departs from the paper: rotations, not similarities, are fitted to whole bands instead of to points on
/// the isolines, and points belong to the exact minimum of E for them. Weights that are negative are made
/// positive, so that no turn raises E. The start is a mean of the handles' rotations, from the poses alone.
/// A shape that enters and is not the rest shape is handled apart. The rigid motions that fit the handles
/// best, from rest to that shape, give rotations T0 of the bands, and these with the poses give T; then
/// R = T T0^-1, and one solve on the mesh gives the points with the edges of that shape. Where no handle
/// moves, R = 1 and that shape passes through; a rigid motion of all handles is reproduced.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   nothing
///   set_handles()  another set of handles        one factorisation; one solve with three columns per band
///                                                and four per handle; 4 bytes per vertex for each of these
///   solve()        the handles moved             some microseconds per turn, then one product of these
///                                                columns; one solve for x, y and z more where another shape
///                                                than the rest shape enters
///
/// Suits few handles on heavy meshes. What lies between two isolines turns as one, also where it is two legs.
class HandleAwareIsolines final : public SurfaceMethodWith<HandleAwareIsolinesOptions>
{
public:
    /// \throw InvalidOption  bands < 2, max_iterations < 1, or tolerance is negative or not finite.
    explicit HandleAwareIsolines(const SurfaceMesh& rest, const HandleAwareIsolinesOptions& options = {});

    /// (n) the band of each vertex, -1 in a part without a handle. The bands around a handle follow each
    /// other, from the handle outwards. Empty before the first bind.
    std::vector<int> bands() const;

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew

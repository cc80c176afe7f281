// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/handles/handle_fields.h"
#include "native/methods/surface/method.h"
#include "native/operators/laplacian.h"

#include <memory>
#include <string>
#include <vector>

namespace sinew {

/// Where the local transformations T_i of LaplacianEditing come from.
enum class LocalTransforms {
    none,         ///< T_i = 1
    from_handles, ///< the maps of the handles, which fade by a field (Eq. 16)
    estimated,    ///< rotations that fit the neighbourhoods in a first solution [LSC*04]
    implicit      ///< unknowns of one linear system together with the positions [SCL*04]
};

/// How implicit transformations turn the differential coordinates of the solution.
enum class SecondStage {
    polar, ///< by the rotation that is closest to T_i
    length ///< by T_i, and scaled to their lengths at rest, as in the paper
};

constexpr auto choices(LocalTransforms)
{
    return std::array{
        Choice{"none", LocalTransforms::none}, Choice{"explicit", LocalTransforms::from_handles},
        Choice{"estimated", LocalTransforms::estimated}, Choice{"implicit", LocalTransforms::implicit}};
}
constexpr auto choices(SecondStage)
{
    return std::array{Choice{"polar", SecondStage::polar}, Choice{"length", SecondStage::length}};
}

struct LaplacianEditingOptions
{
    LocalTransforms transforms = LocalTransforms::estimated;
    Discretization laplacian = Discretization::cotan_voronoi;
    Field field = Field::harmonic;
    int refits = 2;
    SecondStage second_stage = SecondStage::polar;
    bool mean_frame = true;

    static constexpr auto table()
    {
        using O = LaplacianEditingOptions;
        return std::tuple{
            option("transforms", &O::transforms, Rebind::update,
                   "'none', 'explicit' (Eq. 16), 'estimated' or 'implicit': the local transformations"),
            option("laplacian", &O::laplacian, Rebind::anew,
                   "'uniform', 'cotan', 'cotan_voronoi' or 'robust' (section 3.2)"),
            option("field", &O::field, Rebind::update,
                   "of 'explicit', how the maps of the handles fade: 'harmonic' (Eq. 8), 'geodesic' or "
                   "'euclidean'"),
            option("refits", &O::refits, Rebind::update, at_least(0),
                   "of 'estimated', how often the rotations are fitted to the last solution"),
            option("second_stage", &O::second_stage, Rebind::update,
                   "of 'implicit', how differential coordinates are turned: 'polar' by the rotations, or "
                   "'length' by the transformations, with their lengths kept"),
            option("mean_frame", &O::mean_frame, Rebind::update,
                   "of 'estimated' and 'implicit', whether to solve as seen from the mean rotation of the "
                   "handles")};
    }
};

/// Laplacian editing: the surface keeps its differential coordinates, each turned by a local transformation.
///
/// Y. Lipman et al. "Differential Coordinates for Interactive Mesh Editing." Shape Modeling International
/// 2004.
/// O. Sorkine et al. "Laplacian Surface Editing." SGP 2004. Tutorial, sections 4.5.2 and 4.5.3.
///
/// With base points y (the incoming shape, or the rest shape) and their differential coordinates
/// delta = M^-1 L y, it minimises
///
///     E(x) = 1/2 sum_i m_i |(M^-1 L x)_i - T_i delta_i|^2,    L M^-1 L x = L (T delta)
///
/// with L and M of operators/laplacian.h, over all vertices, held ones included. Soft handles add
/// s_i |x_i - t_i|^2 / 2 with s_i = w / (1 - w) A_ii, A = L M^-1 L.
///
///   none          the thin plate: ThinShell with bending alone
///   from_handles  T_i blends the linear maps of the handles (see handles/map_blend.h) by their fields (see
///                 handles/handle_fields.h)
///   estimated     first T_i = R, then `refits` times the rotation that fits best to the edges at vertex i,
///                 from y to the last solution
///   implicit      the similarities that are unknowns of a first linear system (see
///                 responses/implicit_response.h), made rotations or lengths by the `second_stage`, without
///                 which shapes grow; times R
///
/// R is the mean frame: the mean of the rotations of the handles of the part (see handles/map_blend.h), or
/// the identity without `mean_frame`. A rigid motion of all handles is then exact, and between two handles
/// the first solution has to cope with half of their angle only; that of `implicit` is wrong by 1 - cos of
/// the angles that are left.
///
/// Departs from the papers: L is that of cotangents and areas unless the options say otherwise; several
/// handles are blended; the mean frame. A vertex whose edges fit several rotations equally well, because they
/// lie on one line, takes the one closest to R.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   nothing
///   set_handles()  another set of handles        one factorisation; `from_handles` with a harmonic field one
///                                                more, of L, and a solve of as many columns as handles less
///                                                one; `implicit` see responses/implicit_response.h
///   solve()        the handles moved             one solve for x, y and z; `estimated` one more per refit,
///                                                each with a rotation fit per vertex; `implicit` with O(n k)
///                                                for k handles of a part; per substep after the first the
///                                                same once more, with a bind for `none` and `implicit`
///
/// On a plane delta is zero, so `implicit` is `none` where its border is held. At a free border delta lies in
/// the plane, and the second stage turns it: a plate whose middle is lifted by a fifth of its size differs by
/// up to 4e-3, one that is pulled along by 7e-3.
///
/// Affine motions of all handles are reproduced by `from_handles`, rigid ones by `estimated` and `implicit`,
/// translations by all.
class LaplacianEditing final : public SurfaceMethodWith<LaplacianEditingOptions>
{
public:
    /// \throw InvalidOption  refits < 0.
    explicit LaplacianEditing(const SurfaceMesh& rest, const LaplacianEditingOptions& options = {});

    /// `none` and `implicit` are made anew. `estimated` fits its first rotations to the last step. The maps
    /// of handles fade in one step as in many.
    Stepping stepping() const override;
    /// Of `none` only.
    bool displaces_all_alike() const override;

protected:
    std::unique_ptr<SurfaceMethod> made_anew(const SurfaceMesh& rest) const override;
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew

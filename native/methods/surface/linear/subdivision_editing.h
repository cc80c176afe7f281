// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/hidden.h"
#include "native/core/options.h"
#include "native/methods/surface/method.h"

#include <string>
#include <vector>

namespace sinew {

/// How often a semi-regular mesh is coarsened.
enum class Coarsening {
    automatic, ///< as often as a part keeps 64 vertices
    levels     ///< as often as the options say, if there are so many levels
};

constexpr auto choices(Coarsening)
{
    return std::array{Choice{"automatic", Coarsening::automatic}, Choice{"levels", Coarsening::levels}};
}

struct SubdivisionEditingOptions
{
    Coarsening coarsening = Coarsening::automatic;
    int levels = 1;

    static constexpr auto table()
    {
        using O = SubdivisionEditingOptions;
        return std::tuple{
            option("coarsening", &O::coarsening, Rebind::update,
                   "'automatic': each part is coarsened as often as it keeps 64 vertices; 'levels': as "
                   "often as `levels` says"),
            option("levels", &O::levels, Rebind::update, at_least(0),
                   "of 'levels', how often, if there are so many levels; 0 solves on the mesh itself")};
    }
};

/// Multiresolution editing of meshes that come from subdividing a coarse one: the handles move a control
/// mesh, and what was sculpted on each finer level rides on it.
///
/// D. Zorin, P. Schroeder, W. Sweldens. "Interactive Multiresolution Mesh Editing." SIGGRAPH 1997.
/// Tutorial, section 4.3.
///
/// The bind finds the connectivity of subdivision in the faces alone, by Catmull-Clark's rules for quads and
/// Loop's for triangles, and undoes level after level, in each part on its own (semi_regular/undone_level.h).
/// The control points of a level are those whose subdivision is nearest to it, by least squares; the rest are
/// details in frames of the limit surface (semi_regular/subdivided_level.h). A frame
///
///   1. moves the control mesh as a thin plate: x = T y + u, with the smoothest u that brings the points of
///      the smooth surface to the handles (semi_regular/control_motion.h);
///   2. subdivides it level by level, and adds the details in the frames of the new surface;
///   3. meets the handles: what is left there is spread over their surroundings, without a crease, as far as
///      one face of the control mesh reaches (semi_regular/handle_band.h).
///
/// A part that does not come from subdivision is its own control mesh: it moves as a thin plate on the mesh
/// itself, and the report names it. An artist who joins a sculpted head and a scanned hat wants both to
/// move; an error would hold up the head, and one edge that was cut into a mesh would end all work with it.
///
/// Departs from the paper: handles hold and pull, instead of dragging control points one by one; analysis
/// fits the coarser level instead of smoothing and decimating the finer one, so that a mesh without details
/// gives back its control mesh; frames are not adaptive, and borders are smooth curves.
///
///   call           repeat it when ...            cost
///   constructor    rest shape or faces changed   nothing
///   set_handles()  another set of handles        the levels, O(n log n), and a factorisation per level
///                                                below the finest; one around the handles
///   solve()        the handles moved             O(n), and a solve around the handles; for a shape that
///                                                enters, also two solves per level
///
/// Rigid motions of all handles are reproduced; with levels = 0, affine ones. Details keep their lengths, and
/// the plate flattens between handles that are turned against each other by more than about a right angle.
class SubdivisionEditing final : public SurfaceMethodWith<SubdivisionEditingOptions>
{
public:
    /// \throw InvalidOption  levels < 0.
    explicit SubdivisionEditing(const SurfaceMesh& rest, const SubdivisionEditingOptions& options = {});

    /// How often the last bind coarsened each part of the mesh; parts are numbered by their lowest vertices.
    std::vector<int> level_counts() const;
    /// The control mesh of the last bind, of all parts together; before it, the rest shape.
    SurfaceMesh control_mesh() const;

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Impl;
    Hidden<Impl> impl_;
};

} // namespace sinew

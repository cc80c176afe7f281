// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/report.h"
#include "native/core/types.h"
#include "native/handles/constrained_system.h"
#include "native/mesh/components.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"

#include <memory>

namespace sinew {

/// Where a surface has no details: the handles, and where it has an open border the vertices of that border
/// and their neighbours, which become one handle more. A free border would shrink by some wavelengths, and
/// take what is inside along.
Regions faired_regions(const SurfaceMesh& mesh, const Regions& regions, const Components& parts);

/// The mean length of the edges of a mesh; 0 if there is none.
double mean_edge(const SurfaceMesh& mesh);

/// Implicit fairing: what is left of a shape without its details.
///
/// M. Desbrun, M. Meyer, P. Schroeder, A. Barr. "Implicit Fairing of Irregular Meshes Using Diffusion and
/// Curvature Flow." SIGGRAPH 1999. Tutorial, section 4.4.
///
///     (M + (wavelength / 2 pi)^4 L M^-1 L) b = M y
///
/// halves waves of this length on a plane; shorter ones vanish, and longer ones stay. Held vertices have b =
/// y. A vertex that handles pull softly keeps its place the better, the more they pull. L and M,
/// cotan_voronoi, are those of the rest shape for all y, so an affine map of y maps b alike.
///
///   call         cost
///   constructor  one factorisation of the thin shell's size
///   smooth()     one solve for x, y and z; safe from several threads
class Fairing
{
public:
    /// \param wavelength  a length > 0, unless the mesh has none.
    /// \param wider       those of faired_regions() without the border: the analysis is theirs, so that a
    ///   factor of the thin shell can share it. Null for none.
    /// \throw FactorizationFailed  the element is a vertex.
    Fairing(const SurfaceMesh& rest, const Regions& regions, double wavelength,
            const Regions* wider = nullptr);

    /// \param y              (n, 3)
    /// \param[out] smoothed  (n, 3)
    void smooth(const PointsView& y, Points& smoothed) const;

    void report(BindReport& report) const { system_.report(report); }

private:
    ConstrainedSystem system_;
    Poses still_; ///< one per handle
};

} // namespace sinew

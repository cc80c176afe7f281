// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/progress.h"
#include "native/core/report.h"
#include "native/core/types.h"
#include "native/mesh/regions.h"
#include "native/mesh/surface_mesh.h"
#include "native/methods/multiresolution/details/detail_coding.h"
#include "native/methods/multiresolution/details/fairing.h"
#include "native/methods/multiresolution/details/ring_rotations.h"

#include <cstdint>
#include <memory>
#include <vector>

namespace sinew {

/// How details are stored.
enum class DetailKind {
    displacement_vectors, ///< one vector per vertex, see DisplacementVectors
    normal_displacements, ///< heights, see NormalDisplacements
    displacement_volumes, ///< see DisplacementVolumes
    deformation_transfer, ///< no details at all, see DeformationTransfer
};

constexpr auto choices(DetailKind)
{
    return std::array{Choice{"displacement_vectors", DetailKind::displacement_vectors},
                      Choice{"normal_displacements", DetailKind::normal_displacements},
                      Choice{"displacement_volumes", DetailKind::displacement_volumes},
                      Choice{"deformation_transfer", DetailKind::deformation_transfer}};
}

struct MultiresolutionOptions
{
    DetailKind details = DetailKind::displacement_vectors;
    double wavelength = 10.0;
    int bands = 1;

    static constexpr auto table()
    {
        using O = MultiresolutionOptions;
        return std::tuple{
            option("details", &O::details, Rebind::update,
                   "how the details are stored: 'displacement_vectors' that turn with the base (section "
                   "4.4.1), 'normal_displacements', heights above it (4.4.2), 'displacement_volumes' "
                   "between it and the surface (4.4.3), or 'deformation_transfer': not at all, as its "
                   "faces are mapped like those of the base (4.4.4)"),
            option("wavelength", &O::wavelength, Rebind::update, more_than(0),
                   "in mean edge lengths: waves that are shorter are details"),
            option("bands", &O::bands, Rebind::update, between(1, 8),
                   "each further band takes the details of twice the wavelength off what the one before "
                   "left")};
    }
};

/// The bands of details between a rest shape and its smooth base.
class DetailBands
{
public:
    DetailBands() = default;
    /// \param handles  what is held.
    /// \param faired   faired_regions() of these.
    /// \throw FactorizationFailed, OutOfMemory, Cancelled
    DetailBands(const SurfaceMesh& rest, const Regions& handles, const Regions& faired,
                const MultiresolutionOptions& options, const std::shared_ptr<const RingRotations>& rings,
                const Progress& progress);

    /// (bands + 1) the rest shape and what each band left of it. Bands end before one whose base is so thin
    /// somewhere that it carries no frames, so there may be fewer than were asked for, or none.
    const std::vector<Points>& levels() const { return levels_; }
    /// Computes the levels below levels[0], the shape that enters.
    void smooth(std::vector<Points>& levels) const;
    /// What the smallest band makes of a whole shape: levels().back() of it.
    void smooth(Points& shape, Points& spare) const;
    /// Puts the details of all bands back on moved.back().
    /// \param levels    before the deformation.
    /// \param moved     (bands + 1) the others are workspaces.
    void put_back(const std::vector<Points>& levels, std::vector<Points>& moved, bool at_rest,
                  Points& detailed, SolveReport& report) const;

    /// Adds the factors, their memory, how many details are vectors, and whether there are fewer bands than
    /// were asked for.
    void report(BindReport& report) const;

private:
    std::vector<std::unique_ptr<Fairing>> fairings_;
    std::vector<std::unique_ptr<DetailCoding>> codings_;
    std::vector<Points> levels_;
    std::size_t asked_ = 0; ///< the bands of the options
};

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/multiresolution/details/bands.h"

#include "native/core/errors.h"
#include "native/multiresolution/details/deformation_transfer.h"
#include "native/multiresolution/details/displacement_vectors.h"
#include "native/multiresolution/details/displacement_volumes.h"
#include "native/multiresolution/details/normal_displacements.h"

#include <cmath>
#include <string>

namespace sinew {

namespace {

constexpr int most_bands = 8;

std::unique_ptr<DetailCoding> coding(DetailKind kind, const SurfaceMesh& rest, const Regions& regions,
                                     const Points& fine, const Points& coarse,
                                     const std::shared_ptr<const RingRotations>& rings,
                                     const Regions& handles)
{
    switch (kind) {
    case DetailKind::normal_displacements:
        return std::make_unique<NormalDisplacements>(view(fine), view(coarse), rings);
    case DetailKind::displacement_volumes:
        return std::make_unique<DisplacementVolumes>(rest, regions, view(fine), view(coarse), rings,
                                                     &handles);
    case DetailKind::deformation_transfer:
        return std::make_unique<DeformationTransfer>(rest, regions, view(fine), view(coarse), rings);
    case DetailKind::displacement_vectors:
        break;
    }
    return std::make_unique<DisplacementVectors>(rings, view(coarse));
}

} // namespace

void MultiresolutionOptions::check() const
{
    if (!(wavelength > 0) || !std::isfinite(wavelength))
        throw InvalidOption("wavelength must be a finite number above 0");
    if (bands < 1 || bands > most_bands)
        throw InvalidOption("bands must be from 1 to " + std::to_string(most_bands));
}

DetailBands::DetailBands(const SurfaceMesh& rest, const Regions& handles, const Regions& faired,
                         const MultiresolutionOptions& options,
                         const std::shared_ptr<const RingRotations>& rings, const Progress& progress)
{
    double wavelength = options.wavelength * mean_edge(rest);
    for (int k = 0; k < options.bands; ++k, wavelength *= 2) {
        progress.tick(static_cast<double>(k) / options.bands, "fairing the base");
        fairings_.push_back(std::make_unique<Fairing>(rest, faired, wavelength, &handles));
    }
    levels_ = {rest.points()};
    smooth(levels_);
    for (int k = 0; k < options.bands; ++k) {
        progress.tick(1.0, "coding the details");
        codings_.push_back(coding(options.details, rest, faired, levels_[k], levels_[k + 1], rings, handles));
    }
}

void DetailBands::smooth(std::vector<Points>& levels) const
{
    levels.resize(fairings_.size() + 1);
    for (std::size_t k = 0; k < fairings_.size(); ++k)
        fairings_[k]->smooth(view(levels[k]), levels[k + 1]);
}

void DetailBands::smooth(Points& shape, Points& spare) const
{
    for (const auto& fairing : fairings_) {
        fairing->smooth(view(shape), spare);
        shape.swap(spare);
    }
}

void DetailBands::put_back(const std::vector<Points>& levels, std::vector<Points>& moved, bool at_rest,
                           Points& detailed, SolveReport& report) const
{
    for (std::size_t k = codings_.size(); k-- > 0;)
        codings_[k]->apply({view(levels[k]), view(levels[k + 1]), view(moved[k + 1]), at_rest},
                           k == 0 ? detailed : moved[k], report);
}

void DetailBands::report(BindReport& report) const
{
    const auto count = [&](const auto& part) {
        BindReport own;
        part.report(own);
        report.factorizations += own.factorizations;
        report.analyses += own.analyses;
        report.factor_bytes += own.factor_bytes;
    };
    for (const auto& fairing : fairings_)
        count(*fairing);
    for (const auto& each : codings_) {
        count(*each);
        report.detail_vectors += each->vectors();
    }
}

} // namespace sinew

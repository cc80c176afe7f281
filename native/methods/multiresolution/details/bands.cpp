// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/bands.h"

#include "native/core/errors.h"
#include "native/methods/multiresolution/details/deformation_transfer.h"
#include "native/methods/multiresolution/details/displacement_vectors.h"
#include "native/methods/multiresolution/details/displacement_volumes.h"
#include "native/methods/multiresolution/details/normal_displacements.h"

#include <Eigen/Geometry>

#include <cmath>
#include <string>
#include <utility>

namespace sinew {

namespace {

/// A base whose faces around a vertex have less of their rest area there is a thread: rounding turns its
/// frames.
constexpr double least_area_left = 1e-5;

/// (n) the area of the triangles around each vertex.
VectorX areas_around(const std::vector<Triangle>& triangles, const Points& points)
{
    VectorX areas = VectorX::Zero(points.rows());
    for (const Triangle& t : triangles) {
        const Vector3 a = (points.row(t[1]) - points.row(t[0])).transpose(),
                      b = (points.row(t[2]) - points.row(t[0])).transpose();
        for (const int v : t)
            areas[v] += 0.5 * a.cross(b).norm();
    }
    return areas;
}

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

DetailBands::DetailBands(const SurfaceMesh& rest, const Regions& handles, const Regions& faired,
                         const MultiresolutionOptions& options,
                         const std::shared_ptr<const RingRotations>& rings, const Progress& progress)
    : asked_(static_cast<std::size_t>(options.bands))
{
    double wavelength = options.wavelength * mean_edge(rest);
    levels_ = {rest.points()};
    const VectorX areas = least_area_left * areas_around(rest.triangles(), rest.points());
    for (int k = 0; k < options.bands; ++k, wavelength *= 2) {
        progress.tick(static_cast<double>(k) / options.bands, "fairing the base");
        auto fairing = std::make_unique<Fairing>(rest, faired, wavelength, &handles);
        Points smoothed;
        fairing->smooth(view(levels_[k]), smoothed);
        if ((areas_around(rest.triangles(), smoothed).array() < areas.array()).any())
            break;
        fairings_.push_back(std::move(fairing));
        levels_.push_back(std::move(smoothed));
    }
    for (std::size_t k = 0; k < fairings_.size(); ++k) {
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
    if (codings_.empty())
        detailed = moved.back();
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
    if (codings_.size() < asked_)
        report.remarks.push_back("only " + std::to_string(codings_.size()) + " of " + std::to_string(asked_) +
                                 " bands are used: more would shrink the base to threads");
}

} // namespace sinew

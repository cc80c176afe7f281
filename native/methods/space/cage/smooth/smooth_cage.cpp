// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/smooth/smooth_cage.h"

#include "native/core/report.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

constexpr double close_enough = 1e-3; ///< of the size of the cage
constexpr int most_automatic = 5;
constexpr std::int64_t most_quads = 20000; ///< for CageSmooth::automatic

SubdivisionOptions at(SubdivisionOptions options, int level)
{
    options.level = level;
    return options;
}

SubdivisionOptions limit_of(const CageSmoothing& smoothing)
{
    SubdivisionOptions options;
    options.limit = true;
    options.boundary_smooth = smoothing.boundary_smooth;
    options.crease_edges = smoothing.crease_edges;
    options.crease_sharpness = smoothing.crease_sharpness;
    options.corner_vertices = smoothing.corner_vertices;
    options.corner_sharpness = smoothing.corner_sharpness;
    return options;
}

Points refine(const SubdivisionSurface& surface, PointsView control)
{
    Points refined(surface.vertex_count(), 3);
    surface.refine(control.data(), refined.data());
    return refined;
}

/// How far the middles and sides of the quads of a level are from those of the next one, in which each of
/// them is four: a corner of its own, the middle of a side, its middle, and that of another side.
double distance_from(const SubdivisionSurface& finer, const Points& points, int coarse_vertices)
{
    Points means = Points::Zero(points.rows(), 3);
    VectorX counts = VectorX::Zero(points.rows());
    const std::vector<int>& corners = finer.face_corners();
    for (std::size_t c = 0; c + 3 < corners.size(); c += 4)
        for (std::size_t k = 0; k < 4; ++k) {
            const int own = corners[c + k];
            if (own >= coarse_vertices)
                continue;
            for (std::size_t other = 1; other < 4; ++other) {
                const int v = corners[c + (k + other) % 4];
                means.row(v) += points.row(own);
                counts[v] += 1.0;
            }
        }
    double most = 0.0;
    for (Eigen::Index v = coarse_vertices; v < points.rows(); ++v)
        if (counts[v] > 0.0)
            most = std::max(most, (points.row(v) - means.row(v) / counts[v]).norm());
    return most;
}

double error_at(const SurfaceMesh& control, const SubdivisionOptions& options, int level, int vertices)
{
    const SubdivisionSurface finer(control, at(options, level + 1));
    return 4.0 / 3.0 * distance_from(finer, refine(finer, view(control.points())), vertices);
}

int chosen_level(const SurfaceMesh& control, const CageSmoothing& smoothing)
{
    if (smoothing.smooth == CageSmooth::levels)
        return smoothing.levels;
    const SubdivisionOptions options = limit_of(smoothing);
    const double size =
        (control.points().colwise().maxCoeff() - control.points().colwise().minCoeff()).norm();
    int level = 1;
    for (; level < most_automatic; ++level) {
        const SubdivisionSurface surface(control, at(options, level));
        const auto quads = static_cast<std::int64_t>(surface.face_counts().size());
        if (4 * quads > most_quads ||
            error_at(control, options, level, surface.vertex_count()) <= close_enough * size)
            break;
    }
    return level;
}

} // namespace

std::vector<std::string> CageSmoothing::changed_from(const CageSmoothing& other) const
{
    return names_of(
        {{"creases", crease_edges != other.crease_edges || crease_sharpness != other.crease_sharpness},
         {"corners", corner_vertices != other.corner_vertices || corner_sharpness != other.corner_sharpness}},
        changed(*this, other));
}

SmoothCage::SmoothCage(const SurfaceMesh& control, const CageSmoothing& smoothing)
    : control_(control), options_(at(limit_of(smoothing), chosen_level(control, smoothing))),
      surface_(control, options_), places_([&] {
          SubdivisionOptions plain;
          plain.scheme = SubdivisionScheme::bilinear;
          plain.level = options_.level;
          return SubdivisionSurface(control, plain).matrix();
      }())
{
    // Each corner of a face of the cage makes a quad at level 1, and each quad four at each further level.
    const int parts = 1 << 2 * (level() - 1);
    for (int f = 0; f < control.face_count(); ++f)
        control_faces_.insert(control_faces_.end(), parts * control.face(f).size(), f);
}

double SmoothCage::error() const { return error_at(control_, options_, level(), surface_.vertex_count()); }

Points SmoothCage::refined(PointsView control) const { return refine(surface_, control); }

SurfaceMesh SmoothCage::mesh(PointsView control) const
{
    return {refined(control), surface_.face_counts(), surface_.face_corners()};
}

void SmoothCage::fold(RowMatrix& rows) const
{
    const Eigen::Index vertices = matrix().rows(), controls = matrix().cols(),
                       others = rows.cols() - vertices;
    RowMatrix folded = RowMatrix::Zero(rows.rows(), controls + others);
    add_product(rows, 0, matrix(), folded.leftCols(controls));
    folded.rightCols(others) = rows.rightCols(others);
    rows.swap(folded);
}

void add_product(const RowMatrix& rows, Eigen::Index first, const SparseRows& matrix,
                 Eigen::Ref<RowMatrix> sums)
{
    // Some rows at a time, so that each entry of the matrix meets numbers that lie side by side.
    constexpr Eigen::Index together = 8;
    Eigen::Array<double, together, 1> factors;
    Eigen::Array<double, together, Eigen::Dynamic> part(together, sums.cols());
    for (Eigen::Index i = 0; i < rows.rows(); i += together) {
        const Eigen::Index some = std::min(together, rows.rows() - i);
        part.setZero();
        factors.setZero();
        for (Eigen::Index k = 0; k < matrix.rows(); ++k) {
            factors.head(some) = rows.col(first + k).segment(i, some).array();
            if ((factors == 0.0).all())
                continue;
            for (SparseRows::InnerIterator entry(matrix, k); entry; ++entry)
                part.col(entry.col()) += factors * entry.value();
        }
        sums.middleRows(i, some) += part.topRows(some).matrix();
    }
}

} // namespace sinew

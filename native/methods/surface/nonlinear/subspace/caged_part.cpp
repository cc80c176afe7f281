// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/subspace/caged_part.h"

#include "native/caging/automatic_cage.h"
#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/core/progress_part.h"
#include "native/mesh/frames/surface_frame.h"
#include "native/methods/surface/substeps.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

constexpr double most_open = 0.1;      ///< area of the fans that close a part, as a share of its own
constexpr double least_volume = 0.01; ///< volume / area^1.5; a ball has 0.094
constexpr double cage_margin = 0.04;   ///< of an automatic cage, as a share of the size
constexpr int usual_faces = 160;       ///< of an automatic cage, without those beside details
constexpr int coarse_points = 500;     ///< of the surface whose volume is kept while iterating

/// A box around points, of 98 vertices.
SurfaceMesh box_around(const Points& points)
{
    constexpr int across = 4;
    const Vector3 low = points.colwise().minCoeff().transpose(),
                  high = points.colwise().maxCoeff().transpose();
    const double margin = 2 * cage_margin * (high - low).norm();
    std::map<std::array<int, 3>, int> numbers;
    std::vector<Vector3> corners;
    const auto corner = [&](const std::array<int, 3>& at) {
        const auto [it, is_new] = numbers.emplace(at, static_cast<int>(corners.size()));
        if (is_new) {
            const Vector3 share = Vector3(at[0], at[1], at[2]) / across;
            corners.emplace_back((low.array() - margin) +
                                 share.array() * ((high - low).array() + 2 * margin));
        }
        return it->second;
    };
    std::vector<int> faces;
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side)
            for (int a = 0; a < across; ++a)
                for (int b = 0; b < across; ++b) {
                    int ring[4];
                    for (int k = 0; k < 4; ++k) {
                        std::array<int, 3> at{};
                        at[axis] = side * across;
                        at[(axis + 1) % 3] = a + (k == 1 || k == 2);
                        at[(axis + 2) % 3] = b + (k >= 2);
                        ring[side == 1 ? k : 3 - k] = corner(at);
                    }
                    faces.insert(faces.end(), {ring[0], ring[1], ring[2], ring[0], ring[2], ring[3]});
                }
    Points all(static_cast<Eigen::Index>(corners.size()), 3);
    for (std::size_t k = 0; k < corners.size(); ++k)
        all.row(static_cast<Eigen::Index>(k)) = corners[k].transpose();
    return {all, std::vector<int>(faces.size() / 3, 3), faces};
}

/// A cage around a part, made in the frame of the part and of size 1, so that the axes do not choose it.
SurfaceMesh cage_around(const SurfaceMesh& part, const SurfaceFrame& frame, int faces,
                        std::vector<Detail> details, const Progress& progress)
{
    const auto in = [&](const Points& points) -> Points {
        return ((points.rowwise() - frame.centre.transpose()) / frame.size) * frame.axes;
    };
    const auto out = [&](const SurfaceMesh& cage) {
        return with_points(cage, (frame.size * cage.points() * frame.axes.transpose()).rowwise() +
                                     frame.centre.transpose());
    };
    const SurfaceMesh upright = with_points(part, in(part.points()));
    for (auto& [centre, radius] : details) {
        centre = frame.in(centre) / frame.size;
        radius /= frame.size;
    }
    try {
        AutomaticCage made = automatic_cage(
            upright, {.faces = faces, .margin = cage_margin, .details = std::move(details)}, progress);
        return out({std::move(made.points), std::move(made.counts), std::move(made.corners)});
    } catch (const InvalidMesh&) { // no good cage was found
        return out(box_around(upright.points()));
    }
}

} // namespace

Clusters clusters_of(const GraphEdges& edges, const Points& rest, std::vector<int> hard, int wanted)
{
    GraphHandles handles;
    handles.hard = std::move(hard);
    handles.idle.assign(handles.hard.size(), 0);
    return {HandleGraph(edges, std::move(handles)), rest, wanted};
}

RowMatrix CagedPart::exact_weights() const
{
    RowMatrix B = weights().dense();
    parallel_for(static_cast<int>(B.rows()), [&](int i) { B.row(i) /= B.row(i).sum(); });
    return B;
}

Points CagedPart::means(const Points& points) const
{
    Points sums = Points::Zero(coarse.rows(), 3);
    VectorX counts = VectorX::Zero(coarse.rows());
    for (std::size_t v = 0; v < groups.size(); ++v) {
        sums.row(groups[v]) += points.row(static_cast<Eigen::Index>(v));
        counts[groups[v]] += 1.0;
    }
    return counts.cwiseInverse().asDiagonal() * sums;
}

CagedPart::CagedPart(const SurfaceMesh& mesh, const std::vector<int>& members, const GraphEdges& edges,
                     const std::optional<SurfaceMesh>& given, int cage_faces,
                     const std::vector<Detail>& details, const Progress& progress)
    : vertices(members), rest(mesh.points()(members, Eigen::all))
{
    for (const Triangle& t : mesh.triangles())
        if (const auto first = std::ranges::lower_bound(members, t[0]);
            first != members.end() && *first == t[0]) {
            Triangle own;
            for (int k = 0; k < 3; ++k)
                own[k] = static_cast<int>(std::ranges::lower_bound(members, t[k]) - members.begin());
            triangles.push_back(own);
        }
    const auto n = static_cast<int>(vertices.size());
    std::vector<int> corners;
    for (const Triangle& t : triangles)
        corners.insert(corners.end(), t.begin(), t.end());
    const SurfaceMesh part(rest, std::vector<int>(triangles.size(), 3), std::move(corners));
    const SurfaceFrame frame = surface_frame(part);
    size = frame.size;
    cage = given;
    const bool chosen = cage_faces > 0;
    const int faces = chosen ? cage_faces : usual_faces;
    if (!given && n > faces / 2 + 2) {
        cage = cage_around(part, frame, faces, chosen ? std::vector<Detail>() : details,
                           part_of(progress, 0.0, 0.5));
        if (!chosen && cage->vertex_count() >= n)
            cage.reset();
    }
    if (!cage) {
        y = rest;
        own_weights = PointWeights(n, rest, n, {.precision = WeightPrecision::double_precision});
        const RowMatrix one = RowMatrix::Identity(n, n);
        for (int i = 0; i < n; i += PointWeights::part)
            own_weights.set_rows(i, one.middleRows(i, std::min(PointWeights::part, n - i)));
    } else {
        coordinates = std::make_unique<MeanValue>(Cage(*cage));
        coordinates->bind(view(rest), part_of(progress, 0.5, 1.0));
        y = cage->points();
    }
    const RowMatrix B = exact_weights();
    const Clusters grouped = clusters_of(edges, rest, std::vector<int>(n, -1), coarse_points);
    groups = grouped.label;
    coarse = RowMatrix::Zero(static_cast<Eigen::Index>(grouped.seeds.size()), B.cols());
    VectorX counts = VectorX::Zero(coarse.rows());
    for (int v = 0; v < n; ++v) {
        coarse.row(groups[v]) += B.row(v);
        counts[groups[v]] += 1.0;
    }
    coarse = (counts.cwiseInverse().asDiagonal() * coarse).eval();
    coarse_rest = means(rest);
    MatrixX normal = transposed_product(coarse, coarse);
    normal.diagonal().array() += 1e-8 * normal.diagonal().mean();
    if (!projection.factorize(normal))
        throw FactorizationFailed("the coarse shape of the surface has no unique solution");

    volume = EnclosedVolume(triangles, n);
    double twice = 0.0;
    for (const Triangle& t : triangles)
        twice += (rest.row(t[1]) - rest.row(t[0])).cross(rest.row(t[2]) - rest.row(t[0])).norm();
    const double own = rest_volume = volume.of(view(rest));
    has_volume = std::abs(own) > least_volume * std::pow(0.5 * twice, 1.5) &&
                 volume.share_of_fans(view(rest)) < most_open;
    std::map<Triangle, int> kept; // turned so that the lowest comes first -> how often, less its reverses
    for (const Triangle& t : triangles) {
        Triangle of{groups[t[0]], groups[t[1]], groups[t[2]]};
        if (of[0] == of[1] || of[1] == of[2] || of[2] == of[0])
            continue;
        std::rotate(of.begin(), std::ranges::min_element(of), of.end());
        const bool reversed = of[1] > of[2];
        if (reversed)
            std::swap(of[1], of[2]);
        kept[of] += reversed ? -1 : 1;
    }
    std::vector<Triangle> triangles;
    for (const auto& [t, times] : kept)
        for (int k = 0; k < std::abs(times); ++k)
            triangles.push_back(times > 0 ? t : Triangle{t[0], t[2], t[1]});
    coarse_volume = {coarse, EnclosedVolume(std::move(triangles), static_cast<int>(counts.size()))};
}

} // namespace sinew

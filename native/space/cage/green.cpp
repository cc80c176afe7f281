// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/green.h"

#include "native/core/errors.h"
#include "native/core/simd/aligned.h"
#include "native/core/simd/kernel_set.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace sinew {

namespace {

/// Squares of distances. A point on the cage touches all triangles within `touched`; a distance below
/// `rounding` may be due to rounding alone.
constexpr double touched = 1e-25, rounding = 1e-29;

/// s n' of a triangle with the rest sides u and v, by the paper's equation 9.
Vector3 stretched_normal(const Vector3& u, const Vector3& v, Vector3 to_u, Vector3 to_v)
{
    const double scale = std::max(to_u.cwiseAbs().maxCoeff(), to_v.cwiseAbs().maxCoeff());
    if (!(scale > 0.0))
        return Vector3::Zero();
    to_u /= scale, to_v /= scale; // what follows has fourth powers, which could overflow
    const Vector3 area = to_u.cross(to_v);
    const double double_area = area.norm();
    if (!(double_area > 1e-14))
        return Vector3::Zero();
    const double square = to_u.squaredNorm() * v.squaredNorm() - 2.0 * to_u.dot(to_v) * u.dot(v) +
                          to_v.squaredNorm() * u.squaredNorm();
    const double stretch = std::sqrt(std::max(0.0, 0.5 * square)) / u.cross(v).norm();
    return (scale * stretch / double_area) * area;
}

} // namespace

Green::Green(Cage cage, const GreenOptions& options)
    : CageCoordinates(std::move(cage), options.weights), geometry_(this->cage()), options_(options)
{
    if (options.outside != GreenOutside::face)
        return;
    const std::vector<int>& faces = this->cage().rest().triangle_faces();
    const int count = geometry_.tables().triangle_count;
    for (int t = 0; t < count && exit_ < 0; ++t)
        if (faces[static_cast<std::size_t>(geometry_.cage_triangle(t))] == options.exit_face)
            exit_ = t;
    if (exit_ < 0)
        throw InvalidOption("exit face " + std::to_string(options.exit_face) +
                            " is no face of the cage that has an area");
}

std::vector<std::string> Green::changed_settings(const SpaceMethod& former) const
{
    const GreenOptions& other = static_cast<const Green&>(former).options_;
    return names_of({{"outside", options_.outside != other.outside},
                     {"exit_face", options_.exit_face != other.exit_face}},
                    CageCoordinates::changed_settings(former));
}

int Green::columns() const { return cage().vertex_count() + static_cast<int>(cage().triangles().size()); }

RowMatrix Green::face_weights() const
{
    const RowMatrix all = weights().dense();
    return cage().frame().unit() * cage().size() *
           all.rightCols(all.cols() - std::min<Eigen::Index>(all.cols(), cage().vertex_count()));
}

void Green::controls(PointsView vertices, Points& controls) const
{
    const CageTables tables = geometry_.tables();
    controls.setZero(columns(), 3);
    controls.topRows(cage().vertex_count()) = vertices;
    for (int t = 0; t < tables.triangle_count; ++t) {
        const int* const v = tables.triangles[t].corners;
        const auto side = [&](int k) -> Vector3 {
            return Vector3::Map(tables.vertices + 3 * v[k]) - Vector3::Map(tables.vertices + 3 * v[0]);
        };
        const auto to_side = [&](int k) -> Vector3 { return vertices.row(v[k]) - vertices.row(v[0]); };
        controls.row(cage().vertex_count() + geometry_.cage_triangle(t)) =
            stretched_normal(side(1), side(2), to_side(1), to_side(2)).transpose();
    }
}

/// The results of the kernels for one vector of points.
struct Green::KernelResults
{
    const std::size_t lanes = static_cast<std::size_t>(widest_kernels<CageKernels>().lanes);
    AlignedVector<double> scratch, phi, psi;
    std::array<double, most_cage_lanes> winding;
    int touching = 0;

    explicit KernelResults(const CageGeometry& geometry)
        : scratch(geometry.scratch_size(widest_kernels<CageKernels>())),
          phi(lanes * static_cast<std::size_t>(geometry.tables().vertex_count)),
          psi(lanes * static_cast<std::size_t>(geometry.tables().triangle_count))
    {
    }
    void run(const CageTables& tables, const PointLanes& points)
    {
        touching = widest_kernels<CageKernels>().green(tables, points.lanes, scratch.data(), phi.data(),
                                                       psi.data(), winding.data());
    }
};

void Green::evaluate(int, PointsView block, RowMatrix& rows, std::vector<char>& outside) const
{
    const CageTables tables = geometry_.tables();
    const int vertices = cage().vertex_count(), count = static_cast<int>(block.rows());
    const int lanes = widest_kernels<CageKernels>().lanes;
    KernelResults together(geometry_), alone(geometry_);
    rows.setZero(count, columns());
    outside.assign(static_cast<std::size_t>(count), 0);
    for (int first = 0; first < count; first += lanes) {
        std::array<Vector3, most_cage_lanes> x;
        PointLanes points(widest_kernels<CageKernels>());
        for (int lane = 0; lane < lanes; ++lane) {
            x[lane] =
                geometry_.within_reach(geometry_.normalized(block.row(std::min(first + lane, count - 1))));
            points.set(lane, x[lane]);
        }
        together.run(tables, points);
        for (int lane = 0; lane < std::min(lanes, count - first); ++lane) {
            const KernelResults* from = &together;
            // For a point on a face, rounding decides on which side it seems to lie. It counts as inside.
            const bool touches = (together.touching >> lane & 1) ||
                                 (std::round(together.winding[lane]) == 0.0 && is_on_cage(x[lane]));
            if (touches) {
                PointLanes same(widest_kernels<CageKernels>());
                for (int k = 0; k < lanes; ++k)
                    same.set(k, moved_in(x[lane]));
                alone.run(tables, same);
                from = &alone;
            }
            auto row = rows.row(first + lane);
            const double times = std::round(from->winding[lane]);
            const double factor = times == 0.0 ? 1.0 : 1.0 / times;
            for (int v = 0; v < vertices; ++v)
                row[v] = factor * from->phi[from->lanes * static_cast<std::size_t>(v) + lane];
            for (int t = 0; t < tables.triangle_count; ++t)
                row[vertices + geometry_.cage_triangle(t)] =
                    factor * from->psi[from->lanes * static_cast<std::size_t>(t) + lane];
            outside[static_cast<std::size_t>(first + lane)] = times < 1.0;
            if (times == 0.0)
                continue_through(x[lane], row);
        }
    }
}

template <class Row>
void Green::continue_through(const Vector3& x, Row&& row) const
{
    const int exit = exit_ >= 0 ? exit_ : geometry_.nearest(x);
    const Vector3 alpha = geometry_.barycentric(exit, x);
    for (int k = 0; k < 3; ++k)
        row[geometry_.tables().triangles[exit].corners[k]] += alpha[k];
    row[cage().vertex_count() + geometry_.cage_triangle(exit)] -= geometry_.depth(exit, x);
}

bool Green::is_on_cage(const Vector3& x) const
{
    return geometry_.square_distance(geometry_.nearest(x), x) <= rounding;
}

Vector3 Green::moved_in(const Vector3& x) const
{
    const CageTables tables = geometry_.tables();
    Vector3 outwards = Vector3::Zero();
    for (int t = 0; t < tables.triangle_count; ++t)
        if (geometry_.square_distance(t, x) <= touched)
            outwards += Vector3::Map(tables.triangles[t].normal);
    return x - 1e-12 * outwards.stableNormalized();
}

} // namespace sinew

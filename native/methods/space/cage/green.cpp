// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/green.h"

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
/// A distance at which a point touches a patch, and how far it is moved in then.
constexpr double touched_patch = 1e-10, into_patch = 1e-9;

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
    : CageCoordinates(std::move(cage), options.weights),
      patch_faces_(options.faces == GreenFaces::quads && !this->cage().is_flat()
                       ? QuadPatches::faces(this->cage())
                       : std::vector<char>{}),
      geometry_(this->cage(), patch_faces_), patches_(this->cage(), geometry_, patch_faces_),
      options_(options)
{
    if (this->cage().is_flat()) {
        flat_.emplace(this->cage(), geometry_);
        if (options.outside == GreenOutside::face)
            throw InvalidOption("a flat cage has no face through which the outside could be reached");
        return;
    }
    const std::vector<int>& faces = this->cage().rest().triangle_faces();
    for (const int face : faces) {
        const bool is_patch = !patch_faces_.empty() && patch_faces_[static_cast<std::size_t>(face)];
        columns_.push_back(is_patch ? -1 : this->cage().vertex_count() + triangle_columns_++);
    }
    const CageTables tables = geometry_.tables();
    if (patches_.count() > 0) {
        rest_.setZero(wide(), 3);
        for (int v = 0; v < tables.vertex_count; ++v)
            rest_.row(v) = Vector3::Map(tables.vertices + 3 * v).transpose();
        for (int t = 0; t < tables.triangle_count; ++t)
            rest_.row(columns_[static_cast<std::size_t>(geometry_.cage_triangle(t))]) =
                Vector3::Map(tables.triangles[t].normal).transpose();
        for (int q = 0; q < patches_.count(); ++q)
            for (int k = 0; k < 3; ++k)
                rest_.row(first_of_patches() + 3 * q + k) = patches_.rest_normal(q, k).transpose();
    }
    if (this->cage().smooth() && options.normals == GreenNormals::control_points)
        normals_.emplace(this->cage(), normal_columns());
    if (options.outside != GreenOutside::face)
        return;
    for (int t = 0; t < tables.triangle_count && exit_ < 0; ++t)
        if (this->cage().given_face(faces[static_cast<std::size_t>(geometry_.cage_triangle(t))]) ==
            options.exit_face)
            exit_ = t;
    for (int q = 0; q < patches_.count(); ++q)
        if (exit_patch_ < 0 && this->cage().given_face(patches_.face(q)) == options.exit_face)
            exit_patch_ = q;
    if (exit_ < 0 && exit_patch_ < 0)
        throw InvalidOption("exit face " + std::to_string(options.exit_face) +
                            " is no face of the cage that has an area");
}

std::vector<std::string> Green::changed_settings(const SpaceMethod& former) const
{
    return changed(options_, static_cast<const Green&>(former).options_,
                   CageCoordinates::changed_settings(former));
}

int Green::columns() const
{
    if (flat_)
        return cage().control_count() + flat_->edge_count() + 1;
    return cage().control_count() + (normals_ ? normals_->columns() : wide() - cage().vertex_count());
}

std::vector<SmoothNormals::Column> Green::normal_columns() const
{
    std::vector<SmoothNormals::Column> all(static_cast<std::size_t>(wide() - cage().vertex_count()),
                                           {0, Vector3::Zero()});
    const auto place = [&](int column) -> SmoothNormals::Column& {
        return all[static_cast<std::size_t>(column - cage().vertex_count())];
    };
    const CageTables tables = geometry_.tables();
    for (int t = 0; t < tables.triangle_count; ++t) {
        const auto triangle = static_cast<std::size_t>(geometry_.cage_triangle(t));
        place(columns_[triangle]) = {cage().rest().triangle_faces()[triangle],
                                     Vector3::Map(tables.triangles[t].normal),
                                     0.5 * tables.triangles[t].double_area};
    }
    for (int q = 0; q < patches_.count(); ++q)
        for (int k = 0; k < 3; ++k) {
            // The first part is the normal in the middle, with a quarter of the area as its length.
            const Vector3 part = patches_.rest_normal(q, k);
            place(first_of_patches() + 3 * q + k) = {patches_.face(q), part,
                                                     k == 0 ? 4.0 / part.norm() : 0.0};
        }
    return all;
}

RowMatrix Green::face_weights() const
{
    const RowMatrix all = weights().dense();
    const double unit = cage().frame().unit() * cage().size();
    RowMatrix faces = all.rightCols(all.cols() - std::min<Eigen::Index>(all.cols(), cage().control_count()));
    if (normals_)
        return unit * faces;
    if (flat_)
        return unit * faces.leftCols(std::max<Eigen::Index>(0, faces.cols() - 1));
    const Eigen::Index triangles = std::min<Eigen::Index>(faces.cols(), triangle_columns_);
    faces.leftCols(triangles) *= unit;
    faces.rightCols(faces.cols() - triangles) /= unit;
    return faces;
}

void Green::controls(PointsView control, Points& controls) const
{
    const CageTables tables = geometry_.tables();
    Points storage;
    const PointsView vertices = cage().refined(control, storage);
    controls.setZero(columns(), 3);
    controls.topRows(cage().control_count()) = control;
    if (flat_) {
        flat_->controls(vertices, true, controls.bottomRows(flat_->edge_count() + 1));
        return;
    }
    Points normals = Points::Zero(wide() - cage().vertex_count(), 3);
    for (int t = 0; t < tables.triangle_count; ++t) {
        const int* const v = tables.triangles[t].corners;
        const auto side = [&](int k) -> Vector3 {
            return Vector3::Map(tables.vertices + 3 * v[k]) - Vector3::Map(tables.vertices + 3 * v[0]);
        };
        const auto to_side = [&](int k) -> Vector3 { return vertices.row(v[k]) - vertices.row(v[0]); };
        normals.row(columns_[static_cast<std::size_t>(geometry_.cage_triangle(t))] - cage().vertex_count()) =
            stretched_normal(side(1), side(2), to_side(1), to_side(2)).transpose();
    }
    patches_.controls(vertices, normals.bottomRows(3 * patches_.count()));
    if (normals_)
        normals_->controls(normals, control, controls.bottomRows(normals_->columns()));
    else
        controls.bottomRows(normals.rows()) = normals;
}

/// The results of the kernels for one vector of points.
struct Green::KernelResults
{
    const std::size_t lanes = static_cast<std::size_t>(widest_kernels<CageKernels>().lanes);
    AlignedVector<double> scratch, phi, psi;
    std::vector<int> near_edge;
    std::array<double, most_cage_lanes> winding;
    int touching = 0;

    explicit KernelResults(const CageGeometry& geometry)
        : scratch(geometry.scratch_size(widest_kernels<CageKernels>())),
          phi(lanes * static_cast<std::size_t>(geometry.tables().vertex_count)),
          psi(lanes * static_cast<std::size_t>(geometry.tables().triangle_count)),
          near_edge(static_cast<std::size_t>(geometry.tables().edge_count))
    {
    }
    void run(const CageTables& tables, const PointLanes& points)
    {
        touching = widest_kernels<CageKernels>().green(tables, points.lanes, scratch.data(), near_edge.data(),
                                                       phi.data(), psi.data(), winding.data());
    }
};

struct Green::Integrals
{
    MatrixX weights; ///< (points, columns)
    VectorX winding;
    std::vector<char> touching;
    std::vector<QuadPatches::Place> near; ///< the closest place of the patches near each point
    MatrixX rest; ///< (points, 4) the sum of phi, and the point that the weights give at rest
};

void Green::integrate(const std::vector<Vector3>& points, Integrals& found) const
{
    const CageTables tables = geometry_.tables();
    const int vertices = cage().vertex_count(), count = static_cast<int>(points.size());
    const int lanes = widest_kernels<CageKernels>().lanes;
    found.weights.setZero(count, wide());
    found.winding.setZero(count);
    found.touching.assign(points.size(), 0);
    found.near.assign(points.size(), {});
    KernelResults results(geometry_);
    for (int first = 0; first < count && tables.triangle_count > 0; first += lanes) {
        PointLanes some(widest_kernels<CageKernels>());
        for (int lane = 0; lane < lanes; ++lane)
            some.set(lane, points[static_cast<std::size_t>(std::min(first + lane, count - 1))]);
        results.run(tables, some);
        const int used = std::min(lanes, count - first);
        const auto lanes_at = [&](const AlignedVector<double>& from, int i) {
            return Eigen::Map<const VectorX>(from.data() + results.lanes * static_cast<std::size_t>(i), used);
        };
        for (int v = 0; v < vertices; ++v)
            found.weights.col(v).segment(first, used) = lanes_at(results.phi, v);
        for (int t = 0; t < tables.triangle_count; ++t)
            found.weights.col(columns_[static_cast<std::size_t>(geometry_.cage_triangle(t))])
                .segment(first, used) = lanes_at(results.psi, t);
        found.winding.segment(first, used) = Eigen::Map<const VectorX>(results.winding.data(), used);
        for (int lane = 0; lane < used; ++lane)
            found.touching[static_cast<std::size_t>(first + lane)] = results.touching >> lane & 1;
    }
    if (patches_.count() == 0)
        return;
    patches_.add(points, first_of_patches(), found.weights, found.winding, found.near);
    found.rest.setZero(count, 4);
    for (int c = 0; c < wide(); ++c) {
        if (c < vertices)
            found.rest.col(0) += found.weights.col(c);
        for (int axis = 0; axis < 3; ++axis)
            found.rest.col(1 + axis) += rest_(c, axis) * found.weights.col(c);
    }
}

void Green::evaluate(int, PointsView block, RowMatrix& rows, std::vector<char>& outside) const
{
    if (flat_) {
        flat_->green(block, rows, outside);
        cage().fold(rows);
        return;
    }
    std::vector<Vector3> x, moved;
    for (Eigen::Index i = 0; i < block.rows(); ++i)
        x.push_back(geometry_.within_reach(geometry_.normalized(block.row(i))));
    Integrals found, again;
    integrate(x, found);
    // For a point on a face, rounding decides on which side it seems to lie. It counts as inside.
    std::vector<Eigen::Index> touching;
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Eigen::Index row = static_cast<Eigen::Index>(i);
        if (found.touching[i] || (found.near[i].q >= 0 && found.near[i].distance <= touched_patch) ||
            (std::round(found.winding[row]) == 0.0 && is_on_cage(x[i]))) {
            touching.push_back(row);
            moved.push_back(moved_in(x[i]));
        }
    }
    constexpr Eigen::Index strip = 16; // columns whose transpose fits into the nearest cache
    rows.resize(found.weights.rows(), wide());
    for (Eigen::Index c = 0; c < rows.cols(); c += strip) {
        const Eigen::Index some = std::min(strip, rows.cols() - c);
        rows.middleCols(c, some) = found.weights.middleCols(c, some);
    }
    if (!moved.empty()) {
        integrate(moved, again);
        for (std::size_t k = 0; k < touching.size(); ++k) {
            rows.row(touching[k]) = again.weights.row(static_cast<Eigen::Index>(k));
            found.winding[touching[k]] = again.winding[static_cast<Eigen::Index>(k)];
            if (patches_.count() > 0)
                found.rest.row(touching[k]) = again.rest.row(static_cast<Eigen::Index>(k));
        }
    }
    outside.assign(x.size(), 0);
    for (std::size_t i = 0; i < x.size(); ++i) {
        const Eigen::Index point = static_cast<Eigen::Index>(i);
        auto row = rows.row(point);
        const double times = std::round(found.winding[point]), factor = times == 0.0 ? 1.0 : 1.0 / times;
        if (factor != 1.0)
            row *= factor;
        outside[i] = times < 1.0;
        if (patches_.count() == 0) {
            if (times == 0.0)
                represent(place_near(x[i]), 1.0, x[i], row);
            continue;
        }
        // What the weights lack at rest: outside it is all but for the errors of the integrals.
        const double sum = 1.0 - factor * found.rest(point, 0);
        const Vector3 left = x[i] - factor * found.rest.row(point).tail<3>().transpose();
        const QuadPatches::Place& near = found.near[i];
        represent(times == 0.0 ? place_near(x[i]) : Exit{near.q >= 0 ? -1 : geometry_.nearest(x[i]), near},
                  sum, left, row);
    }
    cage().fold(rows);
    if (normals_)
        normals_->fold(rows);
}

Green::Exit Green::place_near(const Vector3& x) const
{
    if (exit_ >= 0)
        return {exit_, {}};
    if (exit_patch_ >= 0)
        return {-1, patches_.closest(exit_patch_, x)};
    const int nearest = geometry_.nearest(x);
    if (patches_.count() == 0)
        return {nearest, {}};
    const QuadPatches::Place place = patches_.closest(x);
    const bool by_triangle =
        nearest >= 0 && geometry_.square_distance(nearest, x) < place.distance * place.distance;
    return {by_triangle ? nearest : -1, place};
}

void Green::represent(const Exit& exit, double sum, const Vector3& vector,
                      Eigen::Ref<Eigen::RowVectorXd> row) const
{
    if (exit.triangle < 0) {
        if (exit.place.q >= 0)
            patches_.represent(exit.place, sum, vector, first_of_patches(), row);
        return;
    }
    const Vector3 middle = Vector3::Zero();
    Vector3 alpha = geometry_.barycentric(exit.triangle, vector);
    double depth = geometry_.depth(exit.triangle, vector);
    if (sum != 1.0) {
        alpha += (sum - 1.0) * geometry_.barycentric(exit.triangle, middle);
        depth += (sum - 1.0) * geometry_.depth(exit.triangle, middle);
    }
    for (int k = 0; k < 3; ++k)
        row[geometry_.tables().triangles[exit.triangle].corners[k]] += alpha[k];
    row[columns_[static_cast<std::size_t>(geometry_.cage_triangle(exit.triangle))]] -= depth;
}

bool Green::is_on_cage(const Vector3& x) const
{
    const int nearest = geometry_.nearest(x);
    return nearest >= 0 && geometry_.square_distance(nearest, x) <= rounding;
}

Vector3 Green::moved_in(const Vector3& x) const
{
    const CageTables tables = geometry_.tables();
    const double reach = patches_.count() > 0 ? touched_patch * touched_patch : touched;
    Vector3 outwards = Vector3::Zero();
    for (int t = 0; t < tables.triangle_count; ++t)
        if (geometry_.square_distance(t, x) <= reach)
            outwards += Vector3::Map(tables.triangles[t].normal);
    for (int q = 0; q < patches_.count(); ++q)
        if (const QuadPatches::Place place = patches_.closest(q, x); place.distance <= touched_patch)
            outwards += patches_.normal(place);
    return x - (patches_.count() > 0 ? into_patch : 1e-12) * outwards.stableNormalized();
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/grid/rest_grid.h"

#include "native/core/errors.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>

namespace sinew {

namespace {

/// Shares of the lattice's size. Blender stores points in single precision, so that the cells of a lattice
/// nobody has touched differ by 1e-7.
constexpr double equal_cells = 1e-6;
constexpr double flat = 1e-9;
constexpr int most_steps = 40, most_halves = 14;

void refuse(const char* what, std::vector<int> points)
{
    std::sort(points.begin(), points.end());
    points.erase(std::unique(points.begin(), points.end()), points.end());
    const std::string text = std::string(what) + " at points " + list_some(points);
    throw InvalidMesh(text, Error::Element::vertex, std::move(points));
}

} // namespace

RestGrid::RestGrid(const PointsView& points, const std::array<int, 3>& resolution,
                   const RestGridOptions& options)
    : points_(points), resolution_(resolution), options_(options)
{
    const auto count = std::accumulate(resolution.begin(), resolution.end(), std::int64_t{1},
                                       [](std::int64_t all, int n) { return all * std::max(n, 0); });
    if (count != points.rows() || count == 0)
        throw InvalidOption("resolution: " + std::to_string(resolution[0]) + " x " +
                            std::to_string(resolution[1]) + " x " + std::to_string(resolution[2]) +
                            " are not " + std::to_string(points.rows()) + " points");
    std::vector<int> bad;
    for (int i = 0; i < points_.rows(); ++i)
        if (!points_.row(i).allFinite())
            bad.push_back(i);
    if (!bad.empty())
        refuse("the lattice is not finite", std::move(bad));
    for (int axis = 0; axis < 3; ++axis) {
        axes_.emplace_back(options.basis[axis], resolution[axis], options.degree, options.outside);
        const bool is_place = axes_.back().is_place();
        map_.emplace_back(is_place ? LatticeBasis::bspline : options.basis[axis], resolution[axis],
                          is_place ? 1 : options.degree, LatticeOutside::follow);
    }
    size_ = (points_.colwise().maxCoeff() - points_.colwise().minCoeff()).maxCoeff();
    find_frame();
    if (!is_affine_)
        refuse_folds();
    find_frozen();
}

void RestGrid::find_frame()
{
    origin_ = corner(0, 0, 0);
    std::vector<int> all(static_cast<std::size_t>(point_count()));
    std::iota(all.begin(), all.end(), 0);
    std::vector<int> single;
    for (int axis = 0; axis < 3; ++axis) {
        Vector3 sum = Vector3::Zero();
        int steps = 0;
        std::array<int, 3> at;
        for (at[2] = 0; at[2] < resolution_[2]; ++at[2])
            for (at[1] = 0; at[1] < resolution_[1]; ++at[1])
                for (at[0] = 0; at[0] < resolution_[0]; ++at[0])
                    if (at[axis] == 0 && resolution_[axis] > 1) {
                        std::array<int, 3> end = at;
                        end[axis] = resolution_[axis] - 1;
                        sum += corner(end[0], end[1], end[2]) - corner(at[0], at[1], at[2]);
                        steps += resolution_[axis] - 1;
                    }
        frame_.col(axis) = steps ? Vector3(sum / steps) : Vector3::Zero();
        if (resolution_[axis] == 1 && options_.axes)
            frame_.col(axis) = options_.axes->col(axis);
        else if (resolution_[axis] == 1)
            single.push_back(axis);
    }
    for (std::size_t k = 0; k < single.size(); ++k) {
        const Vector3 a = frame_.col((single[k] + 1) % 3), b = frame_.col((single[k] + 2) % 3);
        Vector3 across = a.cross(b);
        if (single.size() - k > 1) { // another one is open
            const Vector3 known = a.isZero(0.0) ? b : a;
            across = known.isZero(0.0) ? Vector3(Vector3::Unit(single[k])) : known.unitOrthogonal();
        }
        if (across.norm() > 0.0)
            frame_.col(single[k]) = (size_ > 0.0 ? size_ : 1.0) * across.normalized();
    }
    const double length = std::max({frame_.col(0).norm(), frame_.col(1).norm(), frame_.col(2).norm()});
    double scale = 1.0;
    for (int axis = 0; axis < 3; ++axis)
        scale *= frame_.col(axis).norm();
    if (!(std::abs(frame_.determinant()) > flat * scale) || !(length > 0.0))
        refuse("the lattice is flat at rest", all);
    inverse_ = frame_.inverse();
    double most = 0.0;
    for (int k = 0; k < resolution_[2]; ++k)
        for (int j = 0; j < resolution_[1]; ++j)
            for (int i = 0; i < resolution_[0]; ++i)
                most = std::max(most, (corner(i, j, k) - origin_ - frame_ * Vector3(i, j, k)).norm());
    is_affine_ = most <= equal_cells * size_;
}

void RestGrid::refuse_folds() const
{
    const double sign = frame_.determinant() < 0.0 ? -1.0 : 1.0;
    const double least = flat * std::abs(frame_.determinant());
    std::vector<int> folded;
    const auto cells = [&](int axis) { return std::max(resolution_[axis] - 1, 1); };
    for (int k = 0; k < cells(2); ++k)
        for (int j = 0; j < cells(1); ++j)
            for (int i = 0; i < cells(0); ++i)
                for (int c = 0; c < 8; ++c) {
                    const std::array<int, 3> low{i, j, k}, high{c & 1, c >> 1 & 1, c >> 2};
                    Matrix3 edges = frame_;
                    std::array<int, 3> at;
                    for (int axis = 0; axis < 3; ++axis)
                        at[axis] = std::min(low[axis] + high[axis], resolution_[axis] - 1);
                    for (int axis = 0; axis < 3; ++axis) {
                        if (resolution_[axis] == 1)
                            continue;
                        std::array<int, 3> begin = at, end = at;
                        begin[axis] = low[axis];
                        end[axis] = low[axis] + 1;
                        edges.col(axis) =
                            corner(end[0], end[1], end[2]) - corner(begin[0], begin[1], begin[2]);
                    }
                    if (!(sign * edges.determinant() > least))
                        folded.push_back(at[0] + resolution_[0] * (at[1] + resolution_[1] * at[2]));
                }
    if (!folded.empty())
        refuse("the lattice is folded at rest", std::move(folded));
}

void RestGrid::find_frozen()
{
    frozen_.assign(static_cast<std::size_t>(point_count()), 0);
    if (options_.continuity < 0 || options_.continuity > 4)
        throw InvalidOption("continuity: " + std::to_string(options_.continuity) + " is not between 0 and 4");
    if (options_.outside != LatticeOutside::freeze)
        return;
    const int planes = options_.continuity + 1;
    for (int n = 0; n < point_count(); ++n) {
        const std::array<int, 3> at{n % resolution_[0], n / resolution_[0] % resolution_[1],
                                    n / (resolution_[0] * resolution_[1])};
        for (int axis = 0; axis < 3; ++axis)
            if (!axes_[axis].is_place() && resolution_[axis] > 1)
                frozen_[n] |= at[axis] < planes || at[axis] >= resolution_[axis] - planes;
    }
    if (std::all_of(frozen_.begin(), frozen_.end(), [](char is) { return is != 0; }))
        throw InvalidOption("continuity: " + std::to_string(planes) +
                            " planes of points stay beside each border, and the lattice has no others: it "
                            "needs " +
                            std::to_string(2 * planes + 1) + " points along each axis");
}

Vector3 RestGrid::mapped(const Vector3& parameter, Matrix3& jacobian) const
{
    std::array<std::array<double, AxisBasis::most_bezier_points>, 3> B, D;
    std::array<int, 3> first;
    for (int axis = 0; axis < 3; ++axis)
        first[axis] = map_[axis].values(parameter[axis], B[axis].data(), D[axis].data());
    Vector3 x = Vector3::Zero();
    jacobian.setZero();
    for (int k = 0; k < map_[2].width(); ++k)
        for (int j = 0; j < map_[1].width(); ++j)
            for (int i = 0; i < map_[0].width(); ++i) {
                const Vector3 p = corner(first[0] + i, first[1] + j, first[2] + k) - origin_;
                x += B[0][i] * B[1][j] * B[2][k] * p;
                jacobian.col(0) += D[0][i] * B[1][j] * B[2][k] * p;
                jacobian.col(1) += B[0][i] * D[1][j] * B[2][k] * p;
                jacobian.col(2) += B[0][i] * B[1][j] * D[2][k] * p;
            }
    for (int axis = 0; axis < 3; ++axis)
        if (resolution_[axis] == 1) {
            x += parameter[axis] * frame_.col(axis);
            jacobian.col(axis) = frame_.col(axis);
        }
    return x + origin_;
}

Vector3 RestGrid::parameters_of(const Vector3& point) const
{
    Vector3 s;
    const Vector3 place = inverse_ * (point - origin_);
    for (int axis = 0; axis < 3; ++axis)
        s[axis] = map_[axis].parameter(place[axis]);
    if (is_affine_)
        return s;
    const double enough = 1e-14 * size_;
    // Newton's method from a few starts: the place in the frame that fits best, and the middles of cells.
    Vector3 best = s;
    double least = std::numeric_limits<double>::infinity();
    for (int start = 0; start < 9; ++start) {
        if (start > 0)
            for (int axis = 0; axis < 3; ++axis)
                s[axis] = map_[axis].end() * ((start - 1) >> axis & 1 ? 0.75 : 0.25);
        Matrix3 J;
        Vector3 error = mapped(s, J) - point;
        for (int step = 0; step < most_steps && error.norm() > enough; ++step) {
            const Vector3 by = J.fullPivLu().solve(error);
            double share = 1.0;
            bool fell = false;
            for (int half = 0; half < most_halves && !fell; ++half, share *= 0.5) {
                Matrix3 next_J;
                const Vector3 next = s - share * by, left = mapped(next, next_J) - point;
                if (left.norm() < error.norm()) {
                    s = next;
                    J = next_J;
                    error = left;
                    fell = true;
                }
            }
            if (!fell)
                break;
        }
        if (error.norm() < least) {
            least = error.norm();
            best = s;
        }
        if (least < 1e-10 * size_)
            break;
    }
    return best;
}

LatticePlace RestGrid::place(const Vector3& point) const
{
    const Vector3 s = parameters_of(point);
    LatticePlace found;
    std::array<int, 3> piece;
    for (int axis = 0; axis < 3; ++axis) {
        piece[axis] = axes_[axis].piece(s[axis], found.local[axis]);
        found.outside |= resolution_[axis] > 1 && map_[axis].is_outside(s[axis]);
    }
    found.cell = piece[0] + axes_[0].pieces() * (piece[1] + axes_[1].pieces() * piece[2]);
    return found;
}

BlendCell RestGrid::cell(int index, const double* moves) const
{
    const std::array<int, 3> piece{index % axes_[0].pieces(), index / axes_[0].pieces() % axes_[1].pieces(),
                                   index / (axes_[0].pieces() * axes_[1].pieces())};
    BlendCell found{};
    std::ptrdiff_t first = 0, stride = 3;
    for (int axis = 0; axis < 3; ++axis) {
        const AxisBasis& basis = axes_[axis];
        found.axes[axis] = {basis.coefficients(piece[axis]), basis.width(), basis.degree()};
        first += stride * basis.first(piece[axis]);
        if (axis > 0)
            found.strides[axis - 1] = static_cast<int>(stride);
        stride *= resolution_[axis];
    }
    found.moves = moves + first;
    return found;
}

void RestGrid::moves(PointsView posed, Points& moves) const
{
    moves = posed - points_;
    for (int n = 0; n < point_count(); ++n)
        if (frozen_[n])
            moves.row(n).setZero();
}

VectorX RestGrid::weights(const LatticePlace& place) const
{
    VectorX found = VectorX::Zero(point_count());
    const BlendCell part = cell(place.cell, points_.data());
    std::array<std::array<double, BlendKernels::most_width>, 3> B;
    for (int axis = 0; axis < 3; ++axis) {
        const double* row = part.axes[axis].coefficients;
        const int degree = part.axes[axis].degree;
        for (int i = 0; i < part.axes[axis].width; ++i, row += degree + 1) {
            B[axis][i] = row[degree];
            for (int k = degree - 1; k >= 0; --k)
                B[axis][i] = B[axis][i] * place.local[axis] + row[k];
        }
    }
    const auto first = (part.moves - points_.data()) / 3;
    for (int k = 0; k < part.axes[2].width; ++k)
        for (int j = 0; j < part.axes[1].width; ++j)
            for (int i = 0; i < part.axes[0].width; ++i) {
                const auto n = first + i + (j * part.strides[0] + k * part.strides[1]) / 3;
                if (!frozen_[static_cast<std::size_t>(n)])
                    found[n] += B[0][i] * B[1][j] * B[2][k];
            }
    return found;
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/grid/hexahedra.h"

#include "native/core/errors.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>

namespace sinew {

namespace {

/// Shares of the size of the lattice, or of the cube of a cell's size.
constexpr double flat = 1e-9;
constexpr double on_border = 1e-9;
constexpr double touching = 1e-5; ///< more than single precision leaves of one place
constexpr int most_smooth = 4;
constexpr int most_steps = 60;

std::array<double, 8> corner_weights(const Vector3& t)
{
    std::array<double, 8> N;
    for (int k = 0; k < 8; ++k)
        N[k] = (k & 1 ? t[0] : 1.0 - t[0]) * (k & 2 ? t[1] : 1.0 - t[1]) * (k & 4 ? t[2] : 1.0 - t[2]);
    return N;
}

Vector3 corner_gradient(int k, const Vector3& t)
{
    Vector3 value, slope;
    for (int axis = 0; axis < 3; ++axis) {
        const bool high = (k >> axis & 1) != 0;
        value[axis] = high ? t[axis] : 1.0 - t[axis];
        slope[axis] = high ? 1.0 : -1.0;
    }
    return {slope[0] * value[1] * value[2], value[0] * slope[1] * value[2], value[0] * value[1] * slope[2]};
}

void refuse(const std::string& what, std::vector<int> vertices)
{
    std::sort(vertices.begin(), vertices.end());
    vertices.erase(std::unique(vertices.begin(), vertices.end()), vertices.end());
    throw InvalidMesh(what + " at vertices " + list_some(vertices), Error::Element::vertex, vertices);
}

} // namespace

Hexahedra::Hexahedra(const SurfaceMesh& mesh, int smooth) : mesh_(mesh), smooth_(smooth)
{
    if (smooth < 0 || smooth > most_smooth)
        throw InvalidOption("smooth: " + std::to_string(smooth) + " is not between 0 and " +
                            std::to_string(most_smooth));
    cells_ = find_hexahedra(mesh);
    if (cells_.empty())
        throw InvalidMesh("the lattice has no hexahedra: cells of eight vertices with six quads as sides");
    size_ = (mesh.points().colwise().maxCoeff() - mesh.points().colwise().minCoeff()).maxCoeff();
    std::vector<char> used(static_cast<std::size_t>(mesh.vertex_count()), 0);
    for (const Hexahedron& cell : cells_)
        for (int v : cell)
            used[static_cast<std::size_t>(v)] = 1;
    std::vector<int> loose;
    for (int v = 0; v < mesh.vertex_count(); ++v)
        if (!used[static_cast<std::size_t>(v)])
            loose.push_back(v);
    if (!loose.empty())
        refuse("the lattice is open: no hexahedron has the corners", loose);
    refined_ = mesh.points();
    refuse_folds(cells_);
    grow_tree();
    find_hanging();
    weights_.resize(mesh.vertex_count(), mesh.vertex_count());
    weights_.setIdentity();
    for (int step = 0; step < smooth; ++step) {
        RefinedCells finer = refined(cells_, static_cast<int>(weights_.rows()));
        weights_ = (finer.weights * weights_).eval();
        cells_ = std::move(finer.cells);
    }
    if (smooth > 0) {
        refined_ = weights_ * mesh.points();
        grow_tree();
    }
}

void Hexahedra::grow_tree()
{
    std::vector<BoxTree::Box> boxes;
    for (const Hexahedron& cell : cells_) {
        BoxTree::Box box;
        for (int k = 0; k < 8; ++k)
            box.extend(corner(cell, k));
        boxes.push_back(box);
    }
    tree_ = std::make_unique<BoxTree>(boxes);
}

void Hexahedra::refuse_folds(const std::vector<Hexahedron>& cells) const
{
    std::vector<int> folded;
    for (const Hexahedron& cell : cells)
        for (int k = 0; k < 8; ++k) {
            Matrix3 J;
            mapped(cell, {k & 1 ? 1.0 : 0.0, k & 2 ? 1.0 : 0.0, k & 4 ? 1.0 : 0.0}, J);
            const double room = J.col(0).norm() * J.col(1).norm() * J.col(2).norm();
            if (!(J.determinant() > flat * room))
                folded.push_back(cell[k]);
        }
    if (!folded.empty())
        refuse("the lattice is folded at rest", std::move(folded));
}

void Hexahedra::find_hanging()
{
    const double near = touching * size_;
    for (int v = 0; v < mesh_.vertex_count(); ++v) {
        bool hangs = false;
        tree_->visit_by_bound(
            cell_count(), near * near,
            [&](const BoxTree::Box& box, bool) { return box.squaredExteriorDistance(mesh_.point(v)); },
            [&](int index) {
                const Hexahedron& cell = cells_[static_cast<std::size_t>(index)];
                if (std::find(cell.begin(), cell.end(), v) == cell.end()) {
                    double distance;
                    nearest_in(cell, mesh_.point(v), distance);
                    hangs |= distance < near;
                }
                return hangs ? 0.0 : near * near;
            });
        if (hangs)
            hanging_.push_back(v);
    }
}

Vector3 Hexahedra::mapped(const Hexahedron& cell, const Vector3& local, Matrix3& jacobian) const
{
    const std::array<double, 8> N = corner_weights(local);
    Vector3 x = Vector3::Zero();
    jacobian.setZero();
    for (int k = 0; k < 8; ++k) {
        x += N[k] * corner(cell, k);
        jacobian += corner(cell, k) * corner_gradient(k, local).transpose();
    }
    return x;
}

/// The place in the unit cube whose image is nearest to a point: damped Gauss-Newton steps of the coordinates
/// that the border of the cube does not hold.
Vector3 Hexahedra::nearest_in(const Hexahedron& cell, const Vector3& point, double& distance) const
{
    Vector3 t = Vector3::Constant(0.5);
    Matrix3 J;
    Vector3 error = mapped(cell, t, J) - point;
    double damping = 1e-12;
    for (int step = 0; step < most_steps; ++step) {
        if (error.norm() < 1e-15 * size_)
            break;
        const Vector3 gradient = J.transpose() * error;
        Matrix3 H = J.transpose() * J;
        const double trace = H.trace();
        Vector3 g = gradient;
        bool moves = false;
        for (int axis = 0; axis < 3; ++axis) {
            const bool held =
                (t[axis] <= 0.0 && gradient[axis] > 0.0) || (t[axis] >= 1.0 && gradient[axis] < 0.0);
            if (held) {
                H.row(axis).setZero();
                H.col(axis).setZero();
                g[axis] = 0.0;
            }
            H(axis, axis) += held ? trace : damping * trace;
            moves |= !held && std::abs(gradient[axis]) > 0.0;
        }
        if (!moves)
            break;
        const Vector3 next = (t - H.fullPivLu().solve(g)).cwiseMax(0.0).cwiseMin(1.0);
        Matrix3 next_J;
        const Vector3 left = mapped(cell, next, next_J) - point;
        if (left.squaredNorm() < error.squaredNorm()) {
            const bool is_still = (next - t).cwiseAbs().maxCoeff() < 1e-15;
            t = next;
            J = next_J;
            error = left;
            damping = std::max(1e-12, 0.1 * damping);
            if (is_still)
                break;
        } else if (damping > 1.0) {
            break;
        } else {
            damping = std::max(1e-6, 10.0 * damping);
        }
    }
    distance = error.norm();
    return t;
}

LatticePlace Hexahedra::place(const Vector3& point) const
{
    LatticePlace found;
    double least = std::numeric_limits<double>::infinity();
    tree_->visit_by_bound(
        cell_count(), least,
        [&](const BoxTree::Box& box, bool) { return box.squaredExteriorDistance(point); },
        [&](int index) {
            double distance;
            const Vector3 local = nearest_in(cells_[static_cast<std::size_t>(index)], point, distance);
            if (distance < least) {
                least = distance;
                found.cell = index;
                found.local = local;
            }
            return least < 1e-13 * size_ ? 0.0 : least * least;
        });
    found.outside = least > on_border * size_;
    if (!found.outside)
        return found;
    const Hexahedron& cell = cells_[static_cast<std::size_t>(found.cell)];
    Matrix3 J;
    const Vector3 away = point - mapped(cell, found.local, J);
    const Vector3 by = J.fullPivLu().solve(away);
    found.weighted = true;
    found.weights = corner_weights(found.local);
    for (int k = 0; k < 8; ++k)
        found.weights[k] += corner_gradient(k, found.local).dot(by);
    return found;
}

void Hexahedra::moves(PointsView posed, std::vector<double>& moves) const
{
    const Points all = weights_ * Points(posed - mesh_.points());
    moves.resize(cells_.size() * 24);
    double* to = moves.data();
    for (const Hexahedron& cell : cells_)
        for (int v : cell)
            for (int axis = 0; axis < 3; ++axis)
                *to++ = all(v, axis);
}

BlendCell Hexahedra::cell(int index, const double* moves)
{
    static constexpr double line[4] = {1.0, -1.0, 0.0, 1.0};
    const BlendAxis axis{line, 2, 1};
    return {{axis, axis, axis}, moves + 24 * static_cast<std::size_t>(index), {6, 12}};
}

} // namespace sinew

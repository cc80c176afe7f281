// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/responses/implicit_response.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/mesh/half_edges.h"
#include "native/operators/fits/rotation_fit.h"
#include "native/solvers/sparse_columns.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <string>
#include <utility>

namespace sinew {

namespace {

constexpr int most_basis_handles = 16; ///< of a part; each takes 36 numbers per vertex
constexpr int numbers = 12;            ///< of a motion
constexpr double least_bending = 1e-7; ///< e in the header
/// How much the turn of a part counts in that of a handle, as a share of its points: it decides where they
/// leave the turn open.
constexpr double least_turn = 1e-9;

/// The residual, and below it M^-1 L of each coordinate.
SparseMatrix stacked(const SparseMatrix& residual, const SparseMatrix& L, const VectorX& mass)
{
    const int rows = static_cast<int>(residual.rows());
    return sparse_by_columns(2 * rows, rows, [&](int c, SparseColumn& column) {
        for (SparseMatrix::InnerIterator it(residual, c); it; ++it)
            column.add(static_cast<int>(it.row()), it.value());
        for (SparseMatrix::InnerIterator it(L, c / 3); it; ++it)
            column.add(rows + 3 * static_cast<int>(it.row()) + c % 3, it.value() / mass[it.row()]);
    });
}

/// H of E(x) = 1/2 (x - rest)^T H (x - rest).
SparseMatrix hessian(const SparseMatrix& residual, const SparseMatrix& L, const VectorX& mass)
{
    const auto n = mass.size();
    VectorX weights(6 * n);
    for (Eigen::Index row = 0; row < 6 * n; ++row)
        weights[row] = mass[row % (3 * n) / 3] * (row < 3 * n ? 1.0 : least_bending);
    const SparseMatrix A = stacked(residual, L, mass);
    return sparse_product(A.transpose(), weights, A);
}

} // namespace

SparseMatrix implicit_residual(const SurfaceMesh& rest, const SparseMatrix& L, const VectorX& mass,
                               std::span<const Ring> rings, const Points& delta)
{
    const std::vector<bool> border = border_vertices(rest);
    const int n = rest.vertex_count();
    return sparse_by_columns(3 * n, 3 * n, [&](int c, SparseColumn& column) {
        const int vertex = c / 3, axis = c % 3;
        for (SparseMatrix::InnerIterator it(L, vertex); it; ++it) {
            const int i = static_cast<int>(it.row());
            const Vector3 r = rest.point(vertex) - rings[i].mean, own = delta.row(i).transpose();
            Vector3 value = -rings[i].inverse_square * r[axis] * own;
            if (!border[i]) {
                const Vector3 turn = rings[i].inverse * r.cross(Vector3::Unit(axis));
                value -= turn.cross(own);
            }
            value[axis] += it.value() / mass[i];
            for (int row = 0; row < 3; ++row)
                column.add(3 * i + row, value[row]);
        }
    });
}

ImplicitResponse::ImplicitResponse(const SurfaceMesh& rest, const SparseMatrix& L, const VectorX& mass,
                                   std::span<const Ring> rings, const Points& delta, const Regions& regions,
                                   HandleGroups groups)
    : groups_(std::move(groups)), centres_(groups_.part_handle_count(), Vector3::Zero()),
      soft_(!regions.soft().empty())
{
    const int n = rest.vertex_count();
    auto H = std::make_shared<SparseMatrix>(hessian(implicit_residual(rest, L, mass, rings, delta), L, mass));

    const std::vector<Constraint> constraints = regions.constraints();
    std::vector<int> counts(groups_.part_handle_count(), 0);
    for (const Constraint& at : constraints) {
        const int part_handle = groups_.part_handle(at);
        centres_[part_handle] += rest.point(at.vertex);
        ++counts[part_handle];
    }
    for (int part_handle = 0; part_handle < groups_.part_handle_count(); ++part_handle)
        centres_[part_handle] /= counts[part_handle];
    const VectorX diagonal = H->diagonal();
    const double mean = diagonal.mean();
    const std::size_t hard = constraints.size() - regions.soft().size();
    for (std::size_t row = 0; row < constraints.size(); ++row) {
        const int v = constraints[row].vertex, part_handle = groups_.part_handle(constraints[row]);
        const double unit = diagonal.segment<3>(3 * static_cast<Eigen::Index>(v)).mean();
        pulls_.push_back(
            {v, part_handle,
             row < hard ? 0.0 : regions.soft()[row - hard].stiffness() * (unit > 0 ? unit : mean),
             rest.point(v) - centres_[part_handle]});
    }
    for (const Pull& pull : pulls_)
        for (int axis = 0; axis < 3 && pull.stiffness > 0; ++axis)
            H->coeffRef(3 * pull.vertex + axis, 3 * pull.vertex + axis) += pull.stiffness;
    H->makeCompressed();
    std::vector<bool> free(3 * static_cast<std::size_t>(n));
    for (int v = 0; v < n; ++v)
        std::fill_n(free.begin() + 3 * static_cast<std::ptrdiff_t>(v), 3, regions.is_free(v));

    system_ = std::make_unique<ConstrainedQuadratic>();
    try {
        system_->factorize(std::move(H), free);
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        if (failure.elements().empty())
            throw;
        const int vertex = failure.elements().front() / 3;
        throw FactorizationFailed("the system is singular; it broke down at vertex " + std::to_string(vertex),
                                  Error::Element::vertex, {vertex});
    }
    analyses_ = system_->factor().analyses();
    if (groups_.width() > most_basis_handles)
        return;

    const Eigen::Index columns = static_cast<Eigen::Index>(numbers) * groups_.width();
    require_memory(static_cast<std::int64_t>(sizeof(double)) * 3 * n * columns,
                   "the basis of the implicit transformations");
    basis_ = RowMatrix::Zero(3 * static_cast<Eigen::Index>(n), columns);
    RowMatrix b = RowMatrix::Zero(soft_ ? basis_.rows() : 0, columns);
    for (const Pull& pull : pulls_) {
        const bool held = pull.stiffness == 0;
        RowMatrix& into = held ? basis_ : b;
        const int slot = pull.part_handle - groups_.offsets[groups_.group[pull.vertex]];
        const Eigen::RowVector4d place(pull.from_centre.x(), pull.from_centre.y(), pull.from_centre.z(), 1.0);
        for (int axis = 0; axis < 3; ++axis)
            into.block<1, 4>(3 * pull.vertex + axis, numbers * slot + 4 * axis) +=
                (held ? 1.0 : pull.stiffness) * place;
    }
    system_->solve(basis_, soft_ ? &b : nullptr);
    system_.reset();
}

std::vector<Matrix3> ImplicitResponse::turns(const PointsView& rest, const PointsView& shape) const
{
    std::vector<Vector3> before(groups_.count(), Vector3::Zero()), after = before;
    std::vector<Matrix3> sums(groups_.count(), Matrix3::Zero());
    std::vector<int> counts(groups_.count(), 0);
    const auto for_each = [&](auto&& body) {
        for (Eigen::Index v = 0; v < rest.rows(); ++v)
            if (const int g = groups_.group[v]; g >= 0)
                body(g, rest.row(v).transpose(), shape.row(v).transpose());
    };
    for_each([&](int g, const Vector3& x, const Vector3& y) {
        before[g] += x;
        after[g] += y;
        ++counts[g];
    });
    for (int g = 0; g < groups_.count(); ++g) {
        before[g] /= counts[g];
        after[g] /= counts[g];
    }
    for_each([&](int g, const Vector3& x, const Vector3& y) {
        sums[g] += (y - after[g]) * (x - before[g]).transpose();
    });
    for (Matrix3& sum : sums)
        sum = fit_rotation(sum);
    return sums;
}

std::vector<Pose> ImplicitResponse::moves(const Targets& targets, const std::vector<Matrix3>& frames,
                                          const std::vector<Matrix3>& turns) const
{
    std::vector<Vector3> centres = centres_; // of the shape that enters
    std::vector<Matrix3> own(groups_.part_handle_count(), Matrix3::Identity()); // turns of the handles
    if (targets.incoming) {
        std::vector<double> squares(groups_.part_handle_count(), 0.0), counts = squares;
        std::fill(centres.begin(), centres.end(), Vector3::Zero());
        std::fill(own.begin(), own.end(), Matrix3::Zero());
        for (const Pull& pull : pulls_) { // the points from their centres sum to zero at rest
            const Vector3 y = targets.incoming->row(pull.vertex).transpose();
            centres[pull.part_handle] += y;
            own[pull.part_handle] += y * pull.from_centre.transpose();
            squares[pull.part_handle] += pull.from_centre.squaredNorm();
            ++counts[pull.part_handle];
        }
        for (int g = 0; g < groups_.count(); ++g)
            for (int part_handle = groups_.offsets[g]; part_handle < groups_.offsets[g + 1]; ++part_handle) {
                centres[part_handle] /= counts[part_handle];
                own[part_handle] = fit_rotation(
                    own[part_handle] +
                    least_turn * (squares[part_handle] > 0 ? squares[part_handle] : 1.0) * turns[g]);
            }
    }
    std::vector<Pose> moves(groups_.part_handle_count());
    for (int g = 0; g < groups_.count(); ++g) {
        const int begin = groups_.offsets[g], end = groups_.offsets[g + 1];
        const Matrix3 back = frames[g].transpose(), to_rest = turns[g].transpose();
        Vector3 sum = Vector3::Zero();
        for (int part_handle = begin; part_handle < end; ++part_handle) {
            const int h = groups_.handles[part_handle];
            const bool from_rest = targets.from_rest && (*targets.from_rest)[h];
            const Matrix3 map = targets.poses[h].leftCols<3>();
            moves[part_handle].leftCols<3>() =
                to_rest * (back * (from_rest ? map : Matrix3(map * own[part_handle])) - own[part_handle]);
            moves[part_handle].col(3) =
                to_rest *
                (back * apply(targets.poses[h], from_rest ? centres_[part_handle] : centres[part_handle]) -
                 centres[part_handle]);
            sum += moves[part_handle].col(3);
        }
        for (int part_handle = begin; part_handle < end; ++part_handle)
            moves[part_handle].col(3) -= sum / (end - begin);
    }
    return moves;
}

void ImplicitResponse::displace(const Targets& targets, const std::vector<Matrix3>& frames,
                                RowMatrix& displacements) const
{
    const int n = static_cast<int>(groups_.group.size());
    const std::vector<Matrix3> whole = targets.incoming
                                           ? turns(targets.rest, *targets.incoming)
                                           : std::vector<Matrix3>(groups_.count(), Matrix3::Identity());
    const std::vector<Pose> handles = moves(targets, frames, whole);
    displacements.resize(3 * static_cast<Eigen::Index>(n), 1);
    if (system_) {
        const auto frame = workspaces_.take([] { return std::make_unique<Workspace>(); });
        displacements.setZero();
        if (soft_)
            frame->pulls.setZero(displacements.rows(), 1);
        for (const Pull& pull : pulls_) {
            const Vector3 wanted = apply(handles[pull.part_handle], pull.from_centre);
            const auto row = 3 * static_cast<Eigen::Index>(pull.vertex);
            if (pull.stiffness == 0)
                displacements.block<3, 1>(row, 0) = wanted;
            else
                frame->pulls.block<3, 1>(row, 0) += pull.stiffness * wanted;
        }
        system_->solve(displacements, soft_ ? &frame->pulls : nullptr, frame->work);
    }
    parallel_for(n, [&](int v) {
        const int g = groups_.group[v];
        Eigen::Map<Vector3> own(displacements.data() + 3 * static_cast<std::ptrdiff_t>(v));
        if (g < 0) {
            own.setZero();
            return;
        }
        if (!system_) {
            const Eigen::Index count = numbers * (groups_.offsets[g + 1] - groups_.offsets[g]);
            const Eigen::Map<const VectorX> move(handles[groups_.offsets[g]].data(), count);
            const double* const rows = basis_.data() + basis_.cols() * 3 * static_cast<Eigen::Index>(v);
            for (int axis = 0; axis < 3; ++axis)
                own[axis] = Eigen::Map<const VectorX>(rows + axis * basis_.cols(), count).dot(move);
        }
        if (targets.incoming)
            own = (whole[g] * own).eval();
    });
}

std::int64_t ImplicitResponse::bytes() const
{
    return static_cast<std::int64_t>(sizeof(double)) * basis_.size() +
           (system_ ? system_->factor().bytes() : 0);
}

} // namespace sinew

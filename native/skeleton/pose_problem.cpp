// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/pose_problem.h"

#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/operators/fits/rotation_fit.h"
#include "native/skeleton/hinges.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>

namespace sinew {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
/// Sides of the support are moved inward by this share of the skeleton's size, so that the centre of mass
/// is inside in spite of rounding.
constexpr double margin = 1e-6;
constexpr double aside = 0.1; ///< how much each bone leans outward at the start, beside the pole

/// (sin a / a, (1 - cos a) / a^2, (a - sin a) / a^3), also for small a.
Vector3 series(double a)
{
    if (a < 1e-4) // the next terms are below rounding
        return {1 - a * a / 6, 0.5 - a * a / 24, 1.0 / 6 - a * a / 120};
    return {std::sin(a) / a, (1 - std::cos(a)) / (a * a), (a - std::sin(a)) / (a * a * a)};
}

Matrix3 cross_matrix(const Vector3& v)
{
    Matrix3 K;
    K << 0, -v.z(), v.y(), v.z(), 0, -v.x(), -v.y(), v.x(), 0;
    return K;
}

/// How the rotation of a rotation vector turns further, seen from outside, if the vector changes.
Matrix3 left_jacobian(const Vector3& turn)
{
    const Matrix3 K = cross_matrix(turn);
    const Vector3 factors = series(turn.norm());
    return Matrix3::Identity() + factors[1] * K + factors[2] * K * K;
}

/// How a column of left_jacobian() changes if an entry of the vector does.
Vector3 jacobian_change(const Vector3& turn, int column, int entry)
{
    const double a = turn.norm();
    // The derivatives of the second and the third of series(), divided by a.
    double second = -1.0 / 12 + a * a / 180, third = -1.0 / 60 + a * a / 1260;
    if (a > 1e-2) {
        const double sine = std::sin(a), rest = 1 - std::cos(a), a2 = a * a;
        second = (a * sine - 2 * rest) / (a2 * a2);
        third = (a * rest - 3 * (a - sine)) / (a2 * a2 * a);
    }
    const Vector3 factors = series(a), e = Vector3::Unit(column), v = Vector3::Unit(entry),
                  once = turn.cross(e), twice = turn.cross(once);
    return turn[entry] * (second * once + third * twice) + factors[1] * v.cross(e) +
           factors[2] * (v.cross(once) + turn.cross(v.cross(e)));
}

void check(const PoseRequest& request, int bones)
{
    for (std::size_t t = 0; t < request.targets.size(); ++t) {
        const BoneTarget& target = request.targets[t];
        const std::string name = "target " + std::to_string(t);
        if (target.bone < 0 || target.bone >= bones)
            throw InvalidConstraint(name + ": there is no bone " + std::to_string(target.bone));
        if (!all_finite(target.point) || !all_finite(target.goal))
            throw InvalidConstraint(name + ": its point or its goal is not finite");
        if (!(target.weight > 0 && std::isfinite(target.weight)))
            throw InvalidConstraint(name + ": its weight is not a positive number");
    }
    const auto fits = [&](const std::vector<bool>& flags, const char* name) {
        if (!flags.empty() && static_cast<int>(flags.size()) != bones)
            throw InvalidConstraint(std::string(name) + ": " + std::to_string(flags.size()) + " flags for " +
                                    std::to_string(bones) + " bones");
    };
    fits(request.moving_roots, "moving roots");
    fits(request.locked, "locked");
}

} // namespace

PoseProblem::PoseProblem(const Skeleton& skeleton, const PoseRequest& request,
                         const PoseSolverOptions& options, Posture base)
    : skeleton_(skeleton), request_(request), options_(options), base_(std::move(base)), rest_(options.rest)
{
    check(request, skeleton.bone_count());
    skeleton.check(base_);
    set_up_balance();
    std::vector<double> lower, upper, base_x, stiffness;
    const std::vector<Hinge> hinge = hinges(skeleton);
    const auto add = [&](int bone, int axis, bool moves, double least, double most, double value, double k) {
        unknowns_.push_back({bone, axis, moves});
        lower.push_back(least);
        upper.push_back(most);
        base_x.push_back(value);
        stiffness.push_back(k);
    };
    for (int b = 0; b < skeleton.bone_count(); ++b) {
        first_.push_back(size());
        hinges_.push_back(hinge[b].value_or(Matrix3::Identity()));
        const Joint& joint = skeleton.joint(b);
        const bool locked = !request.locked.empty() && request.locked[b],
                   moves = skeleton.parent(b) < 0 && !request.moving_roots.empty() && request.moving_roots[b];
        const double k = moves ? 0.0 : joint.stiffness;
        if (moves)
            for (int axis = 0; axis < 3; ++axis)
                add(b, axis, true, -infinite, infinite, base_.moves(b, axis) / skeleton.size(), 0.0);
        if (locked)
            continue;
        Vector3 turn = base_.turns.row(b).transpose();
        if (joint.kind == Joint::Kind::angles) {
            turn = turn.cwiseMax(joint.lower).cwiseMin(joint.upper);
            for (int axis = 0; axis < 3; ++axis)
                if (joint.lower[axis] < joint.upper[axis])
                    add(b, axis, false, joint.lower[axis], joint.upper[axis], turn[axis], k);
        } else {
            if (turn.norm() > joint.most)
                turn *= joint.most / turn.norm();
            if (joint.most > 0 && joint.most < infinite)
                limits_.balls.push_back({size(), joint.most});
            for (int axis = 0; axis < 3 && joint.most > 0; ++axis)
                add(b, axis, false, -infinite, infinite, counts_from_base(b) ? 0.0 : turn[axis],
                    hinge[b] && axis > 0 ? (1 + options.swing) * k : k);
        }
        base_.turns.row(b) = turn.transpose();
    }
    first_.push_back(size());
    const auto vector = [](const std::vector<double>& of) -> VectorX {
        return VectorX::Map(of.data(), static_cast<Eigen::Index>(of.size()));
    };
    limits_.lower = vector(lower);
    limits_.upper = vector(upper);
    base_x_ = vector(base_x);
    stiffness_ = vector(stiffness);
    base_turns_ = skeleton.rotations(base_);
    gaps_.resize(request.targets.size());
    before_.resize(skeleton.bone_count());
}

bool PoseProblem::counts_from_base(int bone) const
{
    const Joint& joint = skeleton_.joint(bone);
    return joint.kind == Joint::Kind::ball && joint.most == infinite;
}

void PoseProblem::set_up_balance()
{
    if (!request_.balance)
        return;
    const Balance& balance = *request_.balance;
    const int bones = skeleton_.bone_count();
    support_.emplace(balance.support, balance.up);
    masses_ = balance.masses;
    centres_ = balance.centres;
    if (masses_.empty())
        for (int b = 0; b < bones; ++b)
            masses_.push_back((skeleton_.tail(b) - skeleton_.head(b)).norm());
    if (centres_.rows() == 0) {
        centres_.resize(bones, 3);
        for (int b = 0; b < bones; ++b)
            centres_.row(b) = (0.5 * (skeleton_.tail(b) + skeleton_.head(b))).transpose();
    }
    if (static_cast<int>(masses_.size()) != bones || centres_.rows() != bones)
        throw InvalidConstraint("balance: there are not as many masses and centres as bones");
    if (!all_finite(centres_) ||
        !std::ranges::all_of(masses_, [](double mass) { return mass >= 0 && std::isfinite(mass); }))
        throw InvalidConstraint("balance: a mass is negative, or a mass or a centre is not finite");
    const double sum = std::accumulate(masses_.begin(), masses_.end(), 0.0);
    if (!(sum > 0))
        throw InvalidConstraint("balance: all masses are zero");
    for (double& mass : masses_)
        mass /= sum;
}

VectorX PoseProblem::start() const
{
    VectorX x = base_x_;
    const Poses poses = skeleton_.poses(base_);
    Vector3 middle = Vector3::Zero(); // of all that may turn
    int count = 0;
    for (int b = 0; b < skeleton_.bone_count(); ++b)
        if (first_[b] < first_[b + 1]) {
            middle += apply(poses[b], skeleton_.head(b));
            ++count;
        }
    middle /= std::max(count, 1);
    for (int u = 0; u < size(); ++u) {
        const auto [bone, axis, moves] = unknowns_[u];
        if (moves || stiffness_[u] == 0)
            continue;
        // About the hinge, or the first axis that is free, by which chains in Blender bend; and, so that
        // limbs find a way out of their plane, a little outward: that is the same for both sides of a figure.
        double bend = options_.pole;
        if (u > first_[bone]) {
            const Vector3 head = apply(poses[bone], skeleton_.head(bone)),
                          along = apply(poses[bone], skeleton_.tail(bone)) - head,
                          outward = along.normalized().cross(head - middle) / skeleton_.size();
            const Vector3 turn = poses[bone].leftCols<3>() * skeleton_.axes(bone) * hinges_[bone].col(axis);
            // Limits may close the plane of a chain that stands in the middle: no side is outward there.
            const bool central = !counts_from_base(bone) && outward.norm() < 1e-6;
            bend *= central ? std::pow(aside, u - first_[bone]) : aside * turn.dot(outward);
        }
        x[u] += x[u] + bend <= limits_.upper[u] ? bend : -bend;
    }
    std::vector<int> root(skeleton_.bone_count());
    for (int b = 0; b < skeleton_.bone_count(); ++b) {
        root[b] = skeleton_.parent(b) < 0 ? b : root[skeleton_.parent(b)];
        if (root[b] != b || first_[b] == first_[b + 1] || !unknowns_[first_[b]].moves)
            continue;
        const auto each = [&](auto&& use) {
            for (const BoneTarget& target : request_.targets) {
                int from = target.bone;
                while (skeleton_.parent(from) >= 0)
                    from = skeleton_.parent(from);
                if (from == b)
                    use(target.weight, apply(poses[target.bone], target.point), target.goal);
            }
        };
        double weight = 0.0;
        Vector3 from = Vector3::Zero(), to = Vector3::Zero();
        each([&](double w, const Vector3& point, const Vector3& goal) {
            weight += w;
            from += w * point;
            to += w * goal;
        });
        if (weight == 0)
            continue;
        from /= weight;
        to /= weight;
        Matrix3 covariance = Matrix3::Zero(), turn = Matrix3::Identity();
        each([&](double w, const Vector3& point, const Vector3& goal) {
            covariance += w / weight * (goal - to) * (point - from).transpose();
        });
        const double size = skeleton_.size();
        const Matrix3 axes = skeleton_.axes(b);
        if (counts_from_base(b) && first_[b + 1] - first_[b] == 6) {
            // The little of the identity keeps targets on one line from turning the bones about it.
            turn = fit_rotation(covariance + 1e-9 * size * size * Matrix3::Identity());
            const Matrix3 own = axes.transpose() * turn * axes * base_turns_[b];
            x.segment<3>(first_[b] + 3) = vector_of(base_turns_[b].transpose() * own);
        }
        const Vector3 head = apply(poses[b], skeleton_.head(b));
        x.segment<3>(first_[b]) = (turn * (head - from) + to - skeleton_.head(b)) / size;
    }
    return x;
}

bool PoseProblem::unwind(VectorX& x) const
{
    bool any = false;
    for (int b = 0; b < skeleton_.bone_count(); ++b) {
        const int first = first_[b + 1] - 3; // a ball has all three turns
        if (skeleton_.joint(b).kind != Joint::Kind::ball || first < first_[b] || unknowns_[first].moves)
            continue;
        const double angle = x.segment<3>(first).norm();
        if (angle > std::numbers::pi) {
            x.segment<3>(first) *= 1 - 2 * std::numbers::pi / angle;
            any = true;
        }
    }
    return any;
}

Posture PoseProblem::posture(const VectorX& x) const
{
    if (x == base_x_)
        return base_;
    Posture posture = base_;
    for (int b = 0; b < skeleton_.bone_count(); ++b) {
        Vector3 turn = Vector3::Zero();
        bool turns = false;
        for (int u = first_[b]; u < first_[b + 1]; ++u) {
            const auto [bone, axis, moves] = unknowns_[u];
            if (moves)
                posture.moves(b, axis) = x[u] * skeleton_.size();
            else if (turns = true; counts_from_base(b))
                turn[axis] = x[u];
            else
                posture.turns(b, axis) = x[u];
        }
        if (turns && counts_from_base(b))
            posture.turns.row(b) = vector_of(base_turns_[b] * rotation_of(hinges_[b] * turn)).transpose();
    }
    return posture;
}

/// The axes, seen from outside a joint, about which it turns if its unknowns change, by columns.
Matrix3 PoseProblem::joint_axes(int bone, const Vector3& turn) const
{
    const Joint& joint = skeleton_.joint(bone);
    if (joint.kind == Joint::Kind::ball)
        return before_[bone] * left_jacobian(turn);
    Matrix3 outer = before_[bone], axes;
    for (int k = 2; k >= 0; --k) {
        const int axis = joint.order[k];
        axes.col(axis) = outer.col(axis);
        outer = outer * Eigen::AngleAxisd(turn[axis], Vector3::Unit(axis)).toRotationMatrix();
    }
    return axes;
}

/// Turns the joints. The same as Skeleton::poses(), and what linearize() needs.
void PoseProblem::place(const VectorX& x)
{
    x_ = x;
    turns_ = base_.turns;
    poses_.resize(skeleton_.bone_count());
    for (int b = 0; b < skeleton_.bone_count(); ++b) {
        Vector3 turn = base_.turns.row(b).transpose(), move = base_.moves.row(b).transpose();
        const bool relative = counts_from_base(b);
        if (relative)
            turn.setZero();
        for (int u = first_[b]; u < first_[b + 1]; ++u)
            (unknowns_[u].moves ? move : turn)[unknowns_[u].axis] =
                unknowns_[u].moves ? x[u] * skeleton_.size() : x[u];
        turns_.row(b) = turn.transpose();
        const int parent = skeleton_.parent(b);
        const Joint& joint = skeleton_.joint(b);
        before_[b] = skeleton_.axes(b);
        if (parent >= 0)
            before_[b] = poses_[parent].leftCols<3>() * before_[b];
        if (relative)
            before_[b] = before_[b] * base_turns_[b] * hinges_[b];
        const Matrix3 own = joint.kind == Joint::Kind::ball ? rotation_of(turn) : rotation_of(joint, turn);
        const Vector3 head =
            parent < 0 ? Vector3(skeleton_.head(b) + move) : apply(poses_[parent], skeleton_.head(b));
        poses_[b].leftCols<3>() = before_[b] * own * (skeleton_.axes(b) * hinges_[b]).transpose();
        poses_[b].col(3) = head - poses_[b].leftCols<3>() * skeleton_.head(b);
    }
}

void PoseProblem::evaluate(const VectorX& x, Values& values)
{
    place(x);
    values.squares = 0.5 * rest_ * (stiffness_.array() * (x - base_x_).array().square()).sum();
    values.residuals.resize(static_cast<Eigen::Index>(3 * gaps_.size()));
    for (std::size_t t = 0; t < gaps_.size(); ++t) {
        const BoneTarget& target = request_.targets[t];
        const Vector3 gap = apply(poses_[target.bone], target.point) - target.goal;
        gaps_[t] = gap.norm();
        values.residuals.segment<3>(static_cast<Eigen::Index>(3 * t)) =
            std::sqrt(target.weight) / skeleton_.size() * gap;
    }
    values.squares += 0.5 * values.residuals.squaredNorm();
    values.sides.resize(support_ ? support_->side_count() : 0);
    if (!support_)
        return;
    centre_.setZero();
    for (int b = 0; b < skeleton_.bone_count(); ++b)
        centre_ += masses_[b] * apply(poses_[b], centres_.row(b).transpose());
    for (int side = 0; side < support_->side_count(); ++side)
        values.sides[side] = support_->outside(side, centre_) / skeleton_.size() + margin;
}

/// How a point beyond a joint moves as an unknown of it changes.
/// \param axis  of the unknown, from joint_axes().
Vector3 PoseProblem::column(const Unknown& unknown, const Vector3& axis, const Vector3& point) const
{
    if (unknown.moves)
        return skeleton_.size() * Vector3::Unit(unknown.axis);
    return axis.cross(point - apply(poses_[unknown.bone], skeleton_.head(unknown.bone)));
}

/// Whether a joint turns by unknown `v` before it turns by `u`: then `v` is nearer to what the bone carries.
bool PoseProblem::is_inner(int v, int u) const
{
    const std::array<int, 3>& order = skeleton_.joint(unknowns_[v].bone).order;
    return std::ranges::find(order, unknowns_[v].axis) <= std::ranges::find(order, unknowns_[u].axis);
}

void PoseProblem::linearize(const VectorX& multipliers, Slopes& slopes)
{
    const double size = skeleton_.size();
    std::vector<Vector3> axes(unknowns_.size());
    for (int b = 0; b < skeleton_.bone_count(); ++b) {
        const Matrix3 all = joint_axes(b, turns_.row(b).transpose());
        for (int u = first_[b]; u < first_[b + 1]; ++u)
            axes[u] = all.col(unknowns_[u].axis);
    }
    slopes.diagonal = rest_ * stiffness_;
    slopes.gradient = slopes.diagonal.cwiseProduct(x_ - base_x_);
    const auto count = static_cast<Eigen::Index>(request_.targets.size());
    MatrixX& rows = slopes.rows;
    rows.setZero(3 * count, this->size());
    VectorX residuals(3 * count);
    std::vector<Load> loads(skeleton_.bone_count());
    for (Eigen::Index t = 0; t < count; ++t) {
        const BoneTarget& target = request_.targets[t];
        const Vector3 point = apply(poses_[target.bone], target.point);
        const double scale = std::sqrt(target.weight) / size;
        residuals.segment<3>(3 * t) = scale * (point - target.goal);
        const Vector3 force = target.weight / (size * size) * (point - target.goal);
        loads[target.bone].force += force;
        loads[target.bone].moment += force * point.transpose();
        for (int b = target.bone; b >= 0; b = skeleton_.parent(b))
            for (int u = first_[b]; u < first_[b + 1]; ++u)
                rows.block<3, 1>(3 * t, u) = scale * column(unknowns_[u], axes[u], point);
    }
    slopes.gradient += transposed_times(rows, residuals);

    slopes.sides.setZero(multipliers.size(), this->size());
    if (support_) {
        // What is beyond each joint: its mass, and mass times centre.
        std::vector<double> mass = masses_;
        Points moment(skeleton_.bone_count(), 3);
        Vector3 push = Vector3::Zero();
        for (Eigen::Index side = 0; side < multipliers.size(); ++side)
            push += multipliers[side] / size * support_->normal(static_cast<int>(side));
        for (int b = 0; b < skeleton_.bone_count(); ++b) {
            const Vector3 point = apply(poses_[b], centres_.row(b).transpose());
            moment.row(b) = masses_[b] * point.transpose();
            loads[b].force += masses_[b] * push;
            loads[b].moment += masses_[b] * push * point.transpose();
        }
        for (int b = skeleton_.bone_count() - 1; b >= 0; --b) {
            for (int u = first_[b]; u < first_[b + 1]; ++u) {
                const Vector3 along = mass[b] > 0
                                          ? Vector3(mass[b] * column(unknowns_[u], axes[u],
                                                                     moment.row(b).transpose() / mass[b]))
                                          : Vector3(Vector3::Zero());
                for (Eigen::Index side = 0; side < multipliers.size(); ++side)
                    slopes.sides(side, u) = support_->normal(static_cast<int>(side)).dot(along) / size;
            }
            if (const int parent = skeleton_.parent(b); parent >= 0) {
                mass[parent] += mass[b];
                moment.row(parent) += moment.row(b);
            }
        }
    }
    for (int b = skeleton_.bone_count() - 1; b >= 0; --b) {
        const Vector3 head = apply(poses_[b], skeleton_.head(b));
        if (const int parent = skeleton_.parent(b); parent >= 0) {
            loads[parent].force += loads[b].force;
            loads[parent].moment += loads[b].moment;
        }
        loads[b].moment -= loads[b].force * head.transpose(); // about the joint, from here on
    }
    // The second derivative of a point p beyond joints i and j, j nearer to it, is a_i x (a_j x (p -
    // head_j)).
    slopes.curvature.setZero(this->size(), this->size());
    for (int j = 0; j < skeleton_.bone_count(); ++j) {
        const Matrix3& M = loads[j].moment;
        const double trace = M.trace();
        const Vector3 torque(M(2, 1) - M(1, 2), M(0, 2) - M(2, 0), M(1, 0) - M(0, 1));
        for (int v = first_[j]; v < first_[j + 1]; ++v) {
            if (unknowns_[v].moves)
                continue;
            const Vector3 inner = M.transpose() * axes[v] - trace * axes[v],
                          outer = M * axes[v] - trace * axes[v];
            const bool ball = skeleton_.joint(j).kind == Joint::Kind::ball;
            for (int i = j; i >= 0; i = skeleton_.parent(i))
                for (int u = first_[i]; u < (i == j ? v + 1 : first_[i + 1]); ++u) {
                    if (unknowns_[u].moves)
                        continue;
                    double value = inner.dot(axes[u]);
                    if (i == j && ball) // the axis of u turns as v changes
                        value +=
                            torque.dot(before_[j] * jacobian_change(turns_.row(j).transpose(),
                                                                    unknowns_[u].axis, unknowns_[v].axis));
                    else if (i == j && !is_inner(v, u))
                        value = outer.dot(axes[u]);
                    slopes.curvature(u, v) = slopes.curvature(v, u) = value;
                }
        }
    }
}

} // namespace sinew

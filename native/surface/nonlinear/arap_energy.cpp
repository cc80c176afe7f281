// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/nonlinear/arap_energy.h"

#include "native/core/parallel.h"
#include "native/operators/rotation_fit.h"

#include <Eigen/Geometry>

#include <algorithm>

namespace sinew {

namespace {

constexpr int grain = 512; ///< nodes a parallel chunk: some 50 us of work
/// A cell whose edges lie on one line leaves its turn about that line open. This share of the
/// rotation it had closes it; at the minimum, where rotations rest, it changes nothing.
constexpr double tie = 1e-8;

template <class Body>
void for_nodes(int count, Body&& body)
{
    parallel_for(count, body, grain);
}

/// Axial vector of the skew part: vee(Q)_k = e_kij Q_ji.
Vector3 vee(const Matrix3& Q) { return {Q(2, 1) - Q(1, 2), Q(0, 2) - Q(2, 0), Q(1, 0) - Q(0, 1)}; }

} // namespace

void ArapGraph::set_metric()
{
    metric.assign(weights.size(), 0.0);
    if (!has_rims()) {
        for (int i = 0; i < size; ++i)
            for (int a = offsets[i]; a < offsets[i + 1]; ++a)
                metric[a] = weights[a] * edge_rigidity(i, neighbours[a]);
        return;
    }
    for (int i = 0; i < size; ++i) {
        const auto first = neighbours.begin() + offsets[i];
        const auto last = neighbours.begin() + offsets[i + 1];
        const auto entry = [&](int j) -> double& {
            return metric[std::lower_bound(first, last, j) - neighbours.begin()];
        };
        for (int k = wing_offsets[i]; k < wing_offsets[i + 1]; ++k) {
            const ArapWing& t = wings[k];
            const double mean = (rigidity[i] + rigidity[t.b] + rigidity[t.c]) / 3.0;
            if (t.b != i) // a face may name a vertex twice
                entry(t.b) += mean * t.to_b;
            if (t.c != i)
                entry(t.c) += mean * t.to_c;
        }
    }
}

void ArapGraph::factorize(const Points& rest)
{
    place.assign(size, -1);
    free_nodes.clear();
    for (int i = 0; i < size; ++i)
        if (hard[i] < 0 && !idle[i]) {
            place[i] = static_cast<int>(free_nodes.size());
            free_nodes.push_back(i);
        }

    std::vector<Eigen::Triplet<double>> L, M;
    std::vector<double> moment(size, 0.0); // of each cell, 2/3 sum w |e|^2
    const auto square = [&](int i, int j) { return (rest.row(i) - rest.row(j)).squaredNorm(); };
    for (int i = 0; i < size; ++i) {
        double spread = 0.0;
        for (int a = offsets[i]; a < offsets[i + 1]; ++a) {
            const int j = neighbours[a];
            if (place[i] >= 0) {
                L.emplace_back(place[i], place[i], metric[a]);
                if (place[j] >= 0)
                    L.emplace_back(place[i], place[j], -metric[a]);
            }
            if (smoothing > 0) {
                M.emplace_back(i, j, -4 * smoothing * weights[a] * edge_rigidity(i, j));
                M.emplace_back(i, i, 4 * smoothing * weights[a] * edge_rigidity(i, j));
            }
            if (!has_rims())
                spread += weights[a] * square(i, j);
        }
        if (has_rims())
            for (int k = wing_offsets[i]; k < wing_offsets[i + 1]; ++k) {
                const ArapWing& t = wings[k];
                spread += t.to_b * square(i, t.b) + t.to_c * square(i, t.c) + t.across * square(t.b, t.c);
            }
        moment[i] = 2.0 / 3.0 * rigidity[i] * spread;
    }
    for (const ArapPull& pull : pulls)
        L.emplace_back(place[pull.node], place[pull.node], pull.stiffness);
    SparseMatrix matrix(free_nodes.size(), free_nodes.size());
    matrix.setFromTriplets(L.begin(), L.end());
    position_factor.factorize(matrix);

    if (smoothing > 0) {
        // A node without edges, or of a part shrunk to a point, still needs a pivot.
        const double least = 1e-12 * std::max(1e-280, *std::ranges::max_element(moment));
        for (int i = 0; i < size; ++i)
            M.emplace_back(i, i, moment[i] + least);
        SparseMatrix field(size, size);
        field.setFromTriplets(M.begin(), M.end());
        rotation_factor.factorize(field);
    }
}

ArapProblem::ArapProblem(const ArapGraph& graph, const PointsView& base, const Points& targets,
                         const Points& pulls)
    : rotations(graph.size, Matrix3::Identity()), graph_(graph), base_(base), pulls_(pulls), all_(targets)
{
    for (int i : graph.free_nodes)
        all_.row(i) = base.row(i);
    scale_ = parallel_sum(graph.size, [&](int i) {
        double sum = 0.0;
        for (int a = graph_.offsets[i]; a < graph_.offsets[i + 1]; ++a)
            sum += graph_.weights[a] * graph_.rigidity[i] * edge(i, graph_.neighbours[a]).squaredNorm();
        return sum;
    });
}

const Points& ArapProblem::place(const Points& x)
{
    for (std::size_t f = 0; f < graph_.free_nodes.size(); ++f)
        all_.row(graph_.free_nodes[f]) = x.row(f);
    return all_;
}

Points ArapProblem::free_rows(const PointsView& all) const
{
    Points x(graph_.free_nodes.size(), 3);
    for (std::size_t f = 0; f < graph_.free_nodes.size(); ++f)
        x.row(f) = all.row(graph_.free_nodes[f]);
    return x;
}

/// S_i = sum over the cell's edges of w p e^T, scaled by the cell's rigidity.
Matrix3 ArapProblem::covariance(int i) const
{
    Matrix3 S = Matrix3::Zero();
    if (graph_.has_rims()) {
        for (int k = graph_.wing_offsets[i]; k < graph_.wing_offsets[i + 1]; ++k) {
            const ArapWing& t = graph_.wings[k];
            S += t.to_b * span(i, t.b) * edge(i, t.b).transpose();
            S += t.to_c * span(i, t.c) * edge(i, t.c).transpose();
            S += t.across * span(t.b, t.c) * edge(t.b, t.c).transpose();
        }
    } else {
        for (int a = graph_.offsets[i]; a < graph_.offsets[i + 1]; ++a) {
            const int j = graph_.neighbours[a];
            S += graph_.weights[a] * span(i, j) * edge(i, j).transpose();
        }
    }
    return graph_.rigidity[i] * S;
}

/// 2 alpha A sum_j w_ij R_j
Matrix3 ArapProblem::neighbour_rotations(int i, const std::vector<Matrix3>& from) const
{
    Matrix3 N = Matrix3::Zero();
    for (int a = graph_.offsets[i]; a < graph_.offsets[i + 1]; ++a) {
        const int j = graph_.neighbours[a];
        N += graph_.weights[a] * graph_.edge_rigidity(i, j) * from[j];
    }
    return 2 * graph_.smoothing * N;
}

/// One linearised step of all rotations together: (moment + 4 alpha A L) omega = torque. The
/// cell-by-cell fit alone passes a turn on by one ring an iteration.
void ArapProblem::turn_rotation_field()
{
    MatrixX torque(graph_.size, 3);
    for_nodes(graph_.size, [&](int i) {
        const Matrix3 pull = covariances_[i] + neighbour_rotations(i, rotations);
        torque.row(i) = vee(pull * rotations[i].transpose()).transpose();
    });
    const MatrixX omega = graph_.rotation_factor.solve(torque);
    for_nodes(graph_.size, [&](int i) {
        Vector3 turn = omega.row(i).transpose();
        turn /= std::max(1.0, turn.norm());
        rotations[i] = rotation_from_vector(turn) * rotations[i];
    });
}

void ArapProblem::fit_rotations(const Points& x)
{
    place(x);
    for_nodes(graph_.size, [&](int i) {
        if (graph_.idle[i])
            return;
        const Matrix3 S = covariance(i);
        rotations[i] = fit_rotation(S + tie * S.norm() * rotations[i]);
    });
}

double ArapProblem::energy_and_gradient(Points& gradient) const
{
    gradient.resize(graph_.free_nodes.size(), 3);
    double energy = parallel_sum(
                        graph_.size,
                        [&](int i) {
                            if (graph_.idle[i])
                                return 0.0;
                            const Matrix3& R = rotations[i];
                            double cell = 0.0;
                            double bend = 0.0;
                            Vector3 force = Vector3::Zero();
                            for (int a = graph_.offsets[i]; a < graph_.offsets[i + 1]; ++a) {
                                const int j = graph_.neighbours[a];
                                const double w = graph_.weights[a];
                                if (!graph_.has_rims()) {
                                    const Vector3 e = edge(i, j);
                                    const Vector3 own = span(i, j) - R * e;
                                    cell += w * own.squaredNorm();
                                    force += 0.5 * w *
                                             (graph_.rigidity[i] * own +
                                              graph_.rigidity[j] * (span(i, j) - rotations[j] * e));
                                }
                                if (graph_.smoothing > 0)
                                    bend += w * graph_.edge_rigidity(i, j) * (R - rotations[j]).squaredNorm();
                            }
                            if (graph_.has_rims())
                                for (int k = graph_.wing_offsets[i]; k < graph_.wing_offsets[i + 1]; ++k) {
                                    const ArapWing& t = graph_.wings[k];
                                    cell += t.to_b * (span(i, t.b) - R * edge(i, t.b)).squaredNorm() +
                                            t.to_c * (span(i, t.c) - R * edge(i, t.c)).squaredNorm() +
                                            t.across * (span(t.b, t.c) - R * edge(t.b, t.c)).squaredNorm();
                                    for (int corner : {i, t.b, t.c})
                                        force += graph_.rigidity[corner] / 3.0 *
                                                 (t.to_b * (span(i, t.b) - rotations[corner] * edge(i, t.b)) +
                                                  t.to_c * (span(i, t.c) - rotations[corner] * edge(i, t.c)));
                                }
                            if (graph_.place[i] >= 0)
                                gradient.row(graph_.place[i]) = force.transpose();
                            return graph_.rigidity[i] * cell + graph_.smoothing * bend;
                        },
                        grain) /
                    graph_.energy_factor();

    for (std::size_t k = 0; k < graph_.pulls.size(); ++k) {
        const ArapPull& pull = graph_.pulls[k];
        const Eigen::RowVector3d gap = all_.row(pull.node) - pulls_.row(k);
        energy += 0.5 * pull.stiffness * gap.squaredNorm();
        gradient.row(graph_.place[pull.node]) += pull.stiffness * gap;
    }
    return energy;
}

double ArapProblem::evaluate(const Points& x, Points& gradient)
{
    if (graph_.smoothing > 0) {
        place(x);
        covariances_.resize(graph_.size);
        for_nodes(graph_.size, [&](int i) { covariances_[i] = covariance(i); });
        turn_rotation_field();
        previous_ = rotations;
        for_nodes(graph_.size, [&](int i) {
            if (!graph_.idle[i])
                rotations[i] = fit_rotation(covariances_[i] + neighbour_rotations(i, previous_));
        });
    } else {
        fit_rotations(x);
    }
    return energy_and_gradient(gradient);
}

void ArapProblem::precondition(const Points& gradient, Points& z) const
{
    z = graph_.position_factor.solve(gradient);
}

Points ArapProblem::positions_for_rotations()
{
    Points gradient, z;
    energy_and_gradient(gradient);
    precondition(gradient, z);
    return free_rows(view(all_)) - z;
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/surface/nonlinear/arap.h"
#include "tests/native/shapes.h"

#include <Eigen/LU>
#include <Eigen/SVD>

#include <algorithm>
#include <cmath>
#include <map>

namespace sinew {

/// The as-rigid-as-possible energy once more, written down term by term from arap.h with angles and
/// singular value decompositions: shares no code with the library but the mesh.
class ArapOracle
{
public:
    ArapOracle(const SurfaceMesh& mesh, const ArapOptions& options) : mesh_(mesh), options_(options)
    {
        const int n = mesh.vertex_count();
        rigidity_ =
            options.rigidity.size() == 1 ? std::vector<double>(n, options.rigidity[0]) : options.rigidity;
        double area = 0;
        for (const Triangle& t : mesh.triangles())
            for (int k = 0; k < 3; ++k) {
                const int i = t[k], a = t[(k + 1) % 3], b = t[(k + 2) % 3];
                const Vector3 u = mesh.point(a) - mesh.point(i), v = mesh.point(b) - mesh.point(i);
                const double weight = 0.5 / std::tan(std::acos(u.normalized().dot(v.normalized())));
                if (k == 0)
                    area += 0.5 * u.cross(v).norm();
                weights_[{a, b}] += weight;
                weights_[{b, a}] += weight;
                if (options.cells == ArapOptions::Cells::rims)
                    for (int cell : t)
                        terms_.push_back({cell, a, b, weight});
            }
        double mean = 0;
        for (const auto& [pair, weight] : weights_)
            mean += std::abs(weight) / static_cast<double>(weights_.size());
        const auto clamped = [&](double weight) { return std::clamp(weight, 1e-6 * mean, 1e4 * mean); };
        if (options.cells == ArapOptions::Cells::rims) {
            for (auto& [pair, weight] : weights_)
                weight = 0;
            for (Term& term : terms_) {
                term.weight = clamped(term.weight);
                // Three cells have this term; the edge's own weight counts it once.
                if (term.cell == term.a) {
                    weights_[{term.a, term.b}] += term.weight;
                    weights_[{term.b, term.a}] += term.weight;
                }
            }
        } else {
            for (auto& [pair, weight] : weights_) {
                weight = clamped(weight);
                terms_.push_back({pair.first, pair.first, pair.second, weight});
            }
        }
        smoothing_ = options.smoothness * area;
    }

    /// E with the best rotations: cell by cell, and with smoothness until they no longer move.
    double energy(const Points& q) const
    {
        const int n = mesh_.vertex_count();
        std::vector<Matrix3> S(n, Matrix3::Zero()), R(n);
        for (const Term& term : terms_)
            S[term.cell] += rigidity_[term.cell] * term.weight * (q.row(term.a) - q.row(term.b)).transpose() *
                            (mesh_.points().row(term.a) - mesh_.points().row(term.b));
        for (int i = 0; i < n; ++i)
            R[i] = rotation(S[i]);
        double now = energy(q, R);
        for (int sweep = 0; smoothing_ > 0 && sweep < 5000; ++sweep) {
            for (int i = 0; i < n; ++i) {
                Matrix3 pull = S[i];
                for (auto at = weights_.lower_bound({i, 0}); at != weights_.end() && at->first.first == i;
                     ++at)
                    pull += 2 * smoothing_ * pair_rigidity(at->first) * at->second * R[at->first.second];
                R[i] = rotation(pull);
            }
            const double next = energy(q, R);
            if (next > now * (1 - 1e-13))
                break;
            now = next;
        }
        return now;
    }

    /// Norm of dE/dq at vertex v by central differences.
    double slope_at(const Points& q, int v, double step) const
    {
        Vector3 gradient;
        for (int axis = 0; axis < 3; ++axis) {
            Points moved = q;
            moved(v, axis) += step;
            const double up = energy(moved);
            moved(v, axis) -= 2 * step;
            gradient[axis] = (up - energy(moved)) / (2 * step);
        }
        return gradient.norm();
    }

private:
    struct Term
    {
        int cell, a, b;
        double weight;
    };

    static Matrix3 rotation(const Matrix3& S)
    {
        const Eigen::JacobiSVD<Matrix3> svd(S, Eigen::ComputeFullU | Eigen::ComputeFullV);
        const double sign = (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0 ? -1 : 1;
        return svd.matrixU() * Vector3(1, 1, sign).asDiagonal() * svd.matrixV().transpose();
    }

    double pair_rigidity(const std::pair<int, int>& pair) const
    {
        return 0.5 * (rigidity_[pair.first] + rigidity_[pair.second]);
    }

    double energy(const Points& q, const std::vector<Matrix3>& R) const
    {
        double sum = 0;
        for (const Term& t : terms_) {
            const Vector3 after = (q.row(t.a) - q.row(t.b)).transpose();
            sum += rigidity_[t.cell] * t.weight *
                   (after - R[t.cell] * (mesh_.point(t.a) - mesh_.point(t.b))).squaredNorm();
        }
        for (const auto& [pair, weight] : weights_)
            sum += smoothing_ * pair_rigidity(pair) * weight * (R[pair.first] - R[pair.second]).squaredNorm();
        return sum;
    }

    const SurfaceMesh& mesh_;
    ArapOptions options_;
    std::vector<double> rigidity_;
    std::map<std::pair<int, int>, double> weights_; ///< both directions
    std::vector<Term> terms_;
    double smoothing_ = 0;
};

} // namespace sinew

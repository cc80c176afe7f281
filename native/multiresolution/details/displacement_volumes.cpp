// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/multiresolution/details/displacement_volumes.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/operators/laplacian.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

constexpr double tolerance = 1e-6;     ///< of volumes, as a share of their mean
constexpr double softness = 1e-8;      ///< on the diagonal of K, as a share of its mean
constexpr double area_change = 0.1;    ///< of the base, beyond which the chord diverges
constexpr double least_detail = 1e-3; ///< as a share of an edge: smaller ones are kept less exactly
constexpr int most_solves = 150;      ///< of one frame
constexpr double least_independence = 1e-10; ///< of steps that are mixed

double det(const Vector3& a, const Vector3& b, const Vector3& c) { return a.dot(b.cross(c)); }

} // namespace

Prism prism_between(const PointsView& coarse, const PointsView& fine, const Triangle& triangle)
{
    std::array<Vector3, 3> b, x;
    Vector3 centre = Vector3::Zero();
    for (int k = 0; k < 3; ++k) {
        b[k] = coarse.row(triangle[k]).transpose();
        x[k] = fine.row(triangle[k]).transpose();
        centre += b[k] / 3;
    }
    for (int k = 0; k < 3; ++k) {
        b[k] -= centre;
        x[k] -= centre;
    }
    Prism prism{(det(x[0], x[1], x[2]) - det(b[0], b[1], b[2])) / 6, {}};
    for (int k = 0; k < 3; ++k)
        prism.gradient[k] = x[(k + 1) % 3].cross(x[(k + 2) % 3]) / 6;
    for (int k = 0; k < 3; ++k) { // the wall b_k b_l x_l x_k
        const int l = (k + 1) % 3;
        prism.volume +=
            (det(b[k], b[l], x[l]) + det(b[k], x[l], x[k]) + det(b[k], b[l], x[k]) + det(b[l], x[l], x[k])) /
            12;
        prism.gradient[l] += (b[k].cross(b[l]) + x[k].cross(b[k]) + x[k].cross(b[l])) / 12;
        prism.gradient[k] += (b[k].cross(x[l]) + b[k].cross(b[l]) + b[l].cross(x[l])) / 12;
    }
    return prism;
}

DisplacementVolumes::DisplacementVolumes(const SurfaceMesh& rest, const Regions& regions,
                                         const PointsView& fine, const PointsView& coarse,
                                         std::shared_ptr<const RingRotations> rings)
    : rings_(std::move(rings)), vectors_(rings_, coarse), is_free_(rest.vertex_count(), 0),
      mass_(divisible_mass(rest, Discretization::cotan_voronoi))
{
    const int n = rest.vertex_count();
    for (int v = 0; v < n; ++v)
        if (regions.is_free(v)) {
            is_free_[v] = 1;
            free_.push_back(v);
        }
    std::vector<Prism> prisms;
    VectorX volumes;
    evaluate(fine, coarse, prisms, volumes);
    std::vector<int> number(n, -1);
    for (std::size_t k = 0; k < free_.size(); ++k)
        number[free_[k]] = static_cast<int>(k);
    std::vector<Eigen::Triplet<double>> entries; // of M^-1/2 J^T
    for (std::size_t t = 0; t < prisms.size(); ++t)
        for (int i : rings_->triangles()[t])
            for (int corner = 0; corner < 3; ++corner)
                if (const int j = rings_->triangles()[t][corner]; is_free_[i] && is_free_[j])
                    for (int axis = 0; axis < 3; ++axis)
                        entries.emplace_back(3 * number[j] + axis, number[i],
                                             prisms[t].gradient[corner][axis] / (3 * std::sqrt(mass_[j])));
    const auto unknowns = static_cast<Eigen::Index>(free_.size());
    SparseMatrix J(3 * unknowns, unknowns);
    J.setFromTriplets(entries.begin(), entries.end());
    SparseMatrix K = J.transpose() * J;
    softness_ = unknowns > 0 ? softness * K.diagonal().mean() : 0.0;
    if (!(softness_ > 0)) {
        free_.clear(); // without area, no vertex has a volume
        std::ranges::fill(is_free_, 0);
        return;
    }
    for (Eigen::Index k = 0; k < unknowns; ++k)
        K.coeffRef(k, k) += softness_;
    K.makeCompressed();
    try {
        factor_.factorize(K);
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        std::vector<int> vertices;
        for (int k : failure.elements())
            vertices.push_back(free_[k]);
        throw FactorizationFailed("the volumes of the details have no unique solution",
                                  Error::Element::vertex, std::move(vertices));
    }
}

void DisplacementVolumes::evaluate(const PointsView& fine, const PointsView& coarse,
                                   std::vector<Prism>& prisms, VectorX& volumes) const
{
    prisms.resize(rings_->triangles().size());
    parallel_for(static_cast<int>(prisms.size()),
                 [&](int t) { prisms[t] = prism_between(coarse, fine, rings_->triangles()[t]); });
    volumes.resize(fine.rows());
    parallel_for(static_cast<int>(fine.rows()), [&](int v) {
        double sum = 0.0;
        if (is_free_[v])
            for (int t : rings_->around(v))
                sum += prisms[t].volume;
        volumes[v] = sum / 3;
    });
}

VectorX DisplacementVolumes::volumes(const PointsView& fine, const PointsView& coarse) const
{
    std::vector<Prism> prisms;
    VectorX found;
    evaluate(fine, coarse, prisms, found);
    return found;
}

void DisplacementVolumes::pull(const std::vector<Prism>& prisms, const VectorX& multipliers,
                               Points& move) const
{
    move.resize(multipliers.size(), 3);
    parallel_for(static_cast<int>(move.rows()), [&](int v) {
        Vector3 sum = Vector3::Zero();
        if (is_free_[v])
            for (int t : rings_->around(v)) {
                const Triangle& corners = rings_->triangles()[t];
                const int at = corners[0] == v ? 0 : corners[1] == v ? 1 : 2;
                sum += (multipliers[corners[0]] + multipliers[corners[1]] + multipliers[corners[2]]) *
                       prisms[t].gradient[at];
            }
        move.row(v) = sum.transpose() / (3 * mass_[v]);
    });
}

void DisplacementVolumes::push(const std::vector<Prism>& prisms, const Points& move, VectorX& change) const
{
    change.resize(move.rows());
    parallel_for(static_cast<int>(move.rows()), [&](int v) {
        double sum = 0.0;
        if (is_free_[v])
            for (int t : rings_->around(v))
                for (int corner = 0; corner < 3; ++corner)
                    sum +=
                        prisms[t].gradient[corner].dot(move.row(rings_->triangles()[t][corner]).transpose());
        change[v] = sum / 3;
    });
}

VectorX DisplacementVolumes::precondition(const VectorX& r) const
{
    const VectorX solved = factor_.solve(r(free_));
    VectorX found = VectorX::Zero(r.size());
    found(free_) = solved;
    return found;
}

int DisplacementVolumes::newton(const std::vector<Prism>& prisms, const VectorX& r, double least, int most,
                                VectorX& multipliers) const
{
    multipliers = VectorX::Zero(r.size());
    VectorX left = r, z = precondition(r), p = z, product;
    Points move;
    double slope = left.dot(z);
    int solves = 1;
    for (; solves < most && slope > 0; ++solves) {
        pull(prisms, p, move);
        push(prisms, move, product);
        product += softness_ * p;
        const double length = slope / p.dot(product);
        multipliers += length * p;
        left -= length * product;
        if (left.cwiseAbs().maxCoeff() < least)
            break;
        z = precondition(left);
        const double next = left.dot(z);
        p = z + next / slope * p;
        slope = next;
    }
    return solves;
}

double DisplacementVolumes::area(const PointsView& points) const
{
    const std::vector<Triangle>& triangles = rings_->triangles();
    return parallel_sum(static_cast<int>(triangles.size()), [&](int t) {
        const auto [i, j, k] = triangles[t];
        const Vector3 a = (points.row(j) - points.row(i)).transpose(),
                      b = (points.row(k) - points.row(i)).transpose();
        return 0.5 * a.cross(b).norm();
    });
}

void DisplacementVolumes::mix(Workspace& work, int count)
{
    const auto slots = work.steps.size();
    const int kept = std::min(count, kept_steps);
    const auto step = [&](int back) -> Step& { return work.steps[(count - back) % slots]; };
    if (kept > 0) { // what was the start of this step becomes its change
        Step& last = step(1);
        last.left = work.left - last.left;
        last.multipliers = work.multipliers - last.multipliers;
        last.x = work.x - last.x;
    }
    Step& next = step(0);
    next.left = work.left;
    next.multipliers = work.multipliers;
    next.x = work.x;
    MatrixX products(kept, kept);
    VectorX shares(kept);
    for (int i = 0; i < kept; ++i) {
        for (int j = 0; j <= i; ++j)
            products(i, j) = products(j, i) = step(i + 1).left.dot(step(j + 1).multipliers);
        shares[i] = step(i + 1).left.dot(work.multipliers);
    }
    products.diagonal() *= 1 + least_independence;
    shares = products.ldlt().solve(shares).eval();
    if (!shares.allFinite())
        return;
    for (int i = 0; i < kept; ++i) {
        work.multipliers -= shares[i] * step(i + 1).multipliers;
        work.x -= shares[i] * step(i + 1).x;
    }
}

void DisplacementVolumes::apply(const Band& band, Points& detailed, SolveReport& report) const
{
    vectors_.apply(band, detailed, report);
    if (free_.empty())
        return;
    const auto work = workspaces_.take([] { return std::make_unique<Workspace>(); });
    evaluate(band.fine, band.coarse, work->prisms, work->goal);
    double scale = 0.0, cells = 0.0;
    for (int v : free_) {
        scale += std::abs(work->goal[v]) / static_cast<double>(free_.size());
        cells += std::pow(mass_[v], 1.5) / static_cast<double>(free_.size());
    }
    scale = std::max(scale, least_detail * cells); // a plate has volumes of rounding alone
    const double before = area(band.coarse), after = area(band.moved);
    bool chord = std::abs(after - before) <= area_change * before;
    report.fallbacks += !chord;
    work->x = detailed;
    double best = INFINITY, earlier[2] = {INFINITY, INFINITY};
    int steps = 0, own = 0, solves = 0; // own: steps of this kind
    for (;; ++steps, ++own) {
        evaluate(view(work->x), band.moved, work->prisms, work->left);
        work->left = work->goal - work->left;
        const double worst = work->left.cwiseAbs().maxCoeff() / scale;
        if (worst < best) {
            best = worst;
            work->best = work->x;
        }
        if (best < tolerance)
            break;
        const bool stalls = !(worst < 0.5 * earlier[1]);
        if (chord && own >= 2 && stalls) {
            chord = false; // from the start once more
            ++report.fallbacks;
            own = -1;
            work->x = detailed;
            earlier[0] = earlier[1] = INFINITY;
            continue;
        }
        if (solves >= most_solves || (!chord && !std::isfinite(worst)))
            break;
        if (chord) {
            work->multipliers = precondition(work->left);
            mix(*work, own);
            ++solves;
        } else {
            solves += newton(work->prisms, work->left, std::max(0.05 * worst, 0.3 * tolerance) * scale,
                             most_solves - solves, work->multipliers);
        }
        pull(work->prisms, work->multipliers, work->move);
        work->x += work->move;
        earlier[1] = earlier[0];
        earlier[0] = worst;
    }
    if (std::isfinite(best))
        detailed = work->best;
    report.iterations += steps;
    report.residual = best;
    report.converged = report.converged && best < tolerance;
}

void DisplacementVolumes::report(BindReport& report) const
{
    report.factorizations = factor_.factorizations();
    report.analyses = factor_.analyses();
    report.factor_bytes = factor_.size() ? factor_.bytes() : 0;
}

} // namespace sinew

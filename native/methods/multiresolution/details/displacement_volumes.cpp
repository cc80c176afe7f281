// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/displacement_volumes.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/methods/multiresolution/details/detail_kernels.h"
#include "native/operators/laplacian.h"
#include "native/solvers/constrained_quadratic.h"
#include "native/solvers/sparse_columns.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

constexpr double tolerance = 1e-6;    ///< of volumes, as a share of their mean
constexpr double softness = 1e-8;     ///< on the diagonal of K, as a share of its mean
constexpr double area_change = 0.1;   ///< of the base, beyond which the chord diverges
constexpr double least_detail = 1e-3; ///< as a share of an edge: smaller ones are kept less exactly
constexpr int most_solves = 150;      ///< of one frame
constexpr double most_stretch = 0.8;  ///< of an edge by one of Newton's steps, as a share of its length
constexpr double most_chord_stretch = 0.4; ///< by the first step of the chord; beyond it, Newton is as fast
constexpr double least_independence = 1e-10; ///< of steps that are mixed
constexpr double least_scale = 0.1, most_scale = 10.0; ///< of det F, so that flattened rings do no harm

int corner_of(const Triangle& triangle, int vertex)
{
    return triangle[0] == vertex ? 0 : triangle[1] == vertex ? 1 : 2;
}

/// The products of a with some b, added up in an order that does not depend on the number of threads.
template <int count>
std::array<double, count> products_with(const VectorX& a, const std::array<VectorX, count>& b, int used)
{
    constexpr int grain = 4096;
    const int n = static_cast<int>(a.size());
    std::vector<std::array<double, count>> parts((n + grain - 1) / grain);
    parallel_chunks(n, grain, [&](int begin, int end) {
        for (int k = 0; k < used; ++k)
            parts[begin / grain][k] = a.segment(begin, end - begin).dot(b[k].segment(begin, end - begin));
    });
    std::array<double, count> sums{};
    for (const auto& part : parts)
        for (int k = 0; k < used; ++k)
            sums[k] += part[k];
    return sums;
}

} // namespace

Prism prism_between(const PointsView& coarse, const PointsView& fine, const Triangle& triangle)
{
    const auto at = [&](const PointsView& points, int corner) -> Vector3 {
        return points.row(triangle[corner]).transpose();
    };
    const Vector3 e1 = at(coarse, 1) - at(coarse, 0), e2 = at(coarse, 2) - at(coarse, 0),
                  g1 = at(fine, 1) - at(fine, 0) + 0.5 * e1, g2 = at(fine, 2) - at(fine, 0) + 0.5 * e2;
    const Vector3 N = (g1.cross(g2) + 0.75 * e1.cross(e2)) / 18; // a sixth of that in the header
    const Vector3 c[3] = {(g1 - g2) / 18, g2 / 18, -g1 / 18};
    Vector3 d = Vector3::Zero();
    for (int k = 0; k < 3; ++k)
        d += at(fine, k) - at(coarse, k);
    Prism prism;
    for (int i = 0; i < 3; ++i) {
        const Vector3 moment = share_of_others * d + share_of_own * (at(fine, i) - at(coarse, i));
        prism.volumes[i] = N.dot(moment);
        for (int corner = 0; corner < 3; ++corner)
            prism.slopes[i].col(corner) =
                (share_of_others + (corner == i ? share_of_own : 0.0)) * N + c[corner].cross(moment);
    }
    return prism;
}

DisplacementVolumes::DisplacementVolumes(const SurfaceMesh& rest, const Regions& regions,
                                         const PointsView& fine, const PointsView& coarse,
                                         std::shared_ptr<const RingRotations> rings, const Regions* wider)
    : rings_(std::move(rings)), vectors_(rings_, coarse), duals_(rings_->duals(coarse)),
      ring_area_(rest.vertex_count(), 0.0), is_free_(rest.vertex_count(), 0),
      mass_(divisible_mass(rest, Discretization::cotan_voronoi)), area_(area(coarse))
{
    const int n = rest.vertex_count();
    for (int v = 0; v < n; ++v) {
        for (int t : rings_->around(v))
            ring_area_[v] += duals_[t].normal.norm();
        if (regions.is_free(v)) {
            is_free_[v] = 1;
            free_.push_back(v);
        }
    }
    SparseMatrix K = stiffness(fine, coarse);
    double diagonal = 0.0;
    for (int v : free_)
        diagonal += K.coeff(v, v) / static_cast<double>(free_.size());
    softness_ = softness * diagonal;
    if (!(softness_ > 0)) {
        free_.clear(); // without area, no vertex has a volume
        std::ranges::fill(is_free_, 0);
        return;
    }
    for (int v : free_)
        K.coeffRef(v, v) += softness_;
    const std::vector<bool> free = regions.free_vertices();
    unknowns_ = ConstrainedQuadratic::unknowns_of(free, wider ? wider->free_vertices() : std::vector<bool>{});
    auto factor = std::make_unique<SpdFactor>();
    try {
        factor->factorize(PrincipalBlock(K, unknowns_, free));
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        std::vector<int> vertices;
        for (int unknown : failure.elements())
            vertices.push_back(unknowns_[unknown]);
        throw FactorizationFailed("the volumes of the details have no unique solution",
                                  Error::Element::vertex, std::move(vertices));
    }
    factor_.adopt(std::move(factor)); // a step of the chord is no exact one anyway
    volumes_ = volumes(fine, coarse);
}

SparseMatrix DisplacementVolumes::stiffness(const PointsView& fine, const PointsView& coarse) const
{
    struct Entry
    {
        int row;
        Vector3 slope;
    };
    const int n = static_cast<int>(is_free_.size());
    const std::vector<Triangle>& triangles = rings_->triangles();
    std::vector<Prism> prisms(triangles.size());
    parallel_for(static_cast<int>(triangles.size()),
                 [&](int t) { prisms[t] = prism_between(coarse, fine, triangles[t]); });
    std::vector<int> begin(n + 1, 0), end(n);
    for (int v = 0; v < n; ++v)
        begin[v + 1] = begin[v] + 1 + 2 * static_cast<int>(rings_->around(v).size()); // at most
    // (column v, row i) dV_i/dx_v / sqrt(m_v), or zero where v is not free.
    std::vector<Entry> entries(begin[n]);
    parallel_for(n, [&](int v) {
        end[v] = begin[v];
        const double scale = is_free_[v] ? 1 / std::sqrt(mass_[v]) : 0.0;
        for (int t : rings_->around(v)) {
            const int corner = corner_of(triangles[t], v);
            for (int k = 0; k < 3; ++k) {
                const Vector3 slope = scale * prisms[t].slopes[k].col(corner);
                const auto first = entries.begin() + begin[v], last = entries.begin() + end[v];
                const auto at = std::find_if(
                    first, last, [i = triangles[t][k]](const Entry& entry) { return entry.row == i; });
                if (at != last)
                    at->slope += slope;
                else
                    entries[end[v]++] = {triangles[t][k], slope};
            }
        }
    });
    return sparse_by_columns(n, n, [&](int c, SparseColumn& column) {
        for (int k = begin[c]; k < end[c]; ++k) { // who is near whom is mutual
            const int v = entries[k].row;
            const auto first = entries.begin() + begin[v], last = entries.begin() + end[v];
            const Vector3 own =
                std::find_if(first, last, [c](const Entry& entry) { return entry.row == c; })->slope;
            for (auto at = first; at != last; ++at)
                column.add(at->row, own.dot(at->slope));
        }
    });
}

void DisplacementVolumes::evaluate(const PointsView& fine, const PointsView& coarse, Workspace& work,
                                   VectorX& volumes) const
{
    const std::vector<Triangle>& triangles = rings_->triangles();
    const DetailKernels& kernels = widest_kernels<DetailKernels>();
    work.cells.resize(triangles.size());
    parallel_chunks(static_cast<int>(triangles.size()), 2048, [&](int begin, int end) {
        kernels.volumes(coarse.data(), fine.data(), triangles[begin].data(), end - begin,
                        work.cells[begin].data());
    });
    volumes.resize(fine.rows());
    parallel_for(static_cast<int>(fine.rows()), [&](int v) {
        double sum = 0.0;
        if (is_free_[v])
            for (int t : rings_->around(v))
                sum += work.cells[t][corner_of(triangles[t], v)];
        volumes[v] = sum;
    });
}

VectorX DisplacementVolumes::volumes(const PointsView& fine, const PointsView& coarse) const
{
    const auto work = workspaces_.take([] { return std::make_unique<Workspace>(); });
    VectorX found;
    evaluate(fine, coarse, *work, found);
    return found;
}

void DisplacementVolumes::pull(const PointsView& x, const PointsView& coarse, const VectorX& multipliers,
                               Workspace& work, Points& move) const
{
    const std::vector<Triangle>& triangles = rings_->triangles();
    const DetailKernels& kernels = widest_kernels<DetailKernels>();
    work.forces.resize(triangles.size());
    parallel_chunks(static_cast<int>(triangles.size()), 2048, [&](int begin, int end) {
        kernels.forces(coarse.data(), x.data(), multipliers.data(), triangles[begin].data(), end - begin,
                       work.forces[begin].data());
    });
    move.resize(multipliers.size(), 3);
    parallel_for(static_cast<int>(move.rows()), [&](int v) {
        Vector3 sum = Vector3::Zero();
        if (is_free_[v]) {
            for (int t : rings_->around(v))
                sum += work.forces[t].col(corner_of(triangles[t], v));
            sum = (work.metric[v] * sum).eval();
        }
        move.row(v) = sum.transpose();
    });
}

void DisplacementVolumes::push(const PointsView& x, const PointsView& coarse, const Points& move,
                               Workspace& work, VectorX& change) const
{
    const std::vector<Triangle>& triangles = rings_->triangles();
    const DetailKernels& kernels = widest_kernels<DetailKernels>();
    parallel_chunks(static_cast<int>(triangles.size()), 2048, [&](int begin, int end) {
        kernels.changes(coarse.data(), x.data(), move.data(), triangles[begin].data(), end - begin,
                        work.cells[begin].data());
    });
    change.resize(move.rows());
    parallel_for(static_cast<int>(move.rows()), [&](int v) {
        double sum = 0.0;
        if (is_free_[v])
            for (int t : rings_->around(v))
                sum += work.cells[t][corner_of(triangles[t], v)];
        change[v] = sum;
    });
}

void DisplacementVolumes::precondition(const VectorX& r, Workspace& work, VectorX& solved) const
{
    const int count = static_cast<int>(unknowns_.size());
    MatrixX& x = work.unknowns;
    x.resize(count, 1);
    parallel_for(count, [&](int u) { x(u, 0) = work.inverse[unknowns_[u]] * r[unknowns_[u]]; });
    factor_.solve(x, x);
    if (solved.size() != r.size())
        solved = VectorX::Zero(r.size());
    parallel_for(count, [&](int u) { solved[unknowns_[u]] = work.inverse[unknowns_[u]] * x(u, 0); });
}

int DisplacementVolumes::newton(const PointsView& x, const PointsView& coarse, const VectorX& r, double least,
                                int most, Workspace& work) const
{
    work.multipliers = VectorX::Zero(r.size());
    VectorX left = r, z, product;
    precondition(left, work, z);
    VectorX p = z;
    double slope = left.dot(z);
    int solves = 1;
    for (; solves < most && slope > 0; ++solves) {
        pull(x, coarse, p, work, work.move);
        push(x, coarse, work.move, work, product);
        product += softness_ * p;
        const double length = slope / p.dot(product);
        work.multipliers += length * p;
        left -= length * product;
        if (left.cwiseAbs().maxCoeff() < least)
            break;
        precondition(left, work, z);
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

double DisplacementVolumes::stretch(const PointsView& shape, const Points& move) const
{
    const std::vector<Triangle>& triangles = rings_->triangles();
    constexpr int grain = 2048;
    const int count = static_cast<int>(triangles.size());
    std::vector<double> parts((count + grain - 1) / grain, 0.0);
    parallel_chunks(count, grain, [&](int begin, int end) {
        double most = 0.0;
        for (int t = begin; t < end; ++t)
            for (int corner = 0; corner < 3; ++corner) {
                const int i = triangles[t][corner], j = triangles[t][(corner + 1) % 3];
                const double before = (shape.row(i) - shape.row(j)).squaredNorm(),
                             change = (move.row(i) - move.row(j)).squaredNorm();
                if (change > most * before && before > 0)
                    most = change / before;
            }
        parts[begin / grain] = most;
    });
    return std::sqrt(parts.empty() ? 0.0 : *std::ranges::max_element(parts));
}

std::array<double, DisplacementVolumes::kept_steps> DisplacementVolumes::mix(Workspace& work, int count)
{
    Steps& steps = work.steps;
    const int used = std::min(count, kept_steps), newest = (count + kept_steps - 1) % kept_steps;
    std::array<double, kept_steps> shares{};
    if (used > 0) {
        steps.left[newest] = work.left - steps.last_left;
        steps.multipliers[newest] = work.multipliers - steps.last_multipliers;
        const auto row = products_with<kept_steps>(steps.left[newest], steps.multipliers, used),
                   side = products_with<kept_steps>(work.left, steps.multipliers, used);
        for (int k = 0; k < used; ++k)
            steps.products(newest, k) = steps.products(k, newest) = row[k];
        MatrixX products = steps.products.topLeftCorner(used, used);
        products.diagonal() *= 1 + least_independence;
        const VectorX found = products.ldlt().solve(Eigen::Map<const VectorX>(side.data(), used)).eval();
        if (found.allFinite())
            std::copy_n(found.data(), used, shares.begin());
    }
    steps.last_left = work.left;
    steps.last_multipliers = work.multipliers;
    for (int k = 0; k < used; ++k)
        work.multipliers -= shares[k] * steps.multipliers[k];
    return shares;
}

void DisplacementVolumes::take_map(int vertex, const Matrix3& rotation, const Matrix3& sum,
                                   Workspace& work) const
{
    const bool has_area = ring_area_[vertex] > 0;
    const Matrix3 F = has_area ? Matrix3(sum / ring_area_[vertex]) : rotation;
    work.metric[vertex] = F * F.transpose() / mass_[vertex];
    work.inverse[vertex] = 1 / std::clamp(std::abs(F.determinant()), least_scale, most_scale);
}

void DisplacementVolumes::begin(const Band& band, Workspace& work, Points& detailed,
                                SolveReport& report) const
{
    const auto n = static_cast<Eigen::Index>(is_free_.size());
    work.metric.resize(n);
    work.inverse.setOnes(n);
    const auto is_free = [&](int v) {
        if (is_free_[v])
            return true;
        if (band.at_rest)
            detailed.row(v) = band.moved.row(v) +
                              (band.fine.row(v) - band.coarse.row(v)); // where it is none but of rounding
        return false;
    };
    if (band.at_rest)
        detailed.resize(n, 3);
    else
        vectors_.apply(band, detailed, report);
    rings_->fit(duals_, band.moved, work.maps, is_free,
                [&](int v, const Matrix3& rotation, const Matrix3& sum) {
                    if (band.at_rest)
                        detailed.row(v) =
                            band.moved.row(v) +
                            (rotation * (band.fine.row(v) - band.coarse.row(v)).transpose()).transpose();
                    take_map(v, rotation, sum, work);
                });
}

void DisplacementVolumes::apply(const Band& band, Points& detailed, SolveReport& report) const
{
    if (free_.empty()) {
        vectors_.apply(band, detailed, report);
        return;
    }
    const auto work = workspaces_.take([] { return std::make_unique<Workspace>(); });
    begin(band, *work, detailed, report);
    if (band.at_rest)
        work->goal = volumes_;
    else
        evaluate(band.fine, band.coarse, *work, work->goal);
    double scale = 0.0, cells = 0.0;
    for (int v : free_) {
        scale += std::abs(work->goal[v]) / static_cast<double>(free_.size());
        cells += mass_[v] * std::sqrt(mass_[v]) / static_cast<double>(free_.size());
    }
    scale = std::max(scale, least_detail * cells); // a plate has volumes of rounding alone
    const double before = band.at_rest ? area_ : area(band.coarse), after = area(band.moved);
    bool chord = std::abs(after - before) <= area_change * before;
    report.fallbacks += !chord;
    work->x = detailed;
    const Points* at = &work->x;
    double best = INFINITY, earlier[2] = {INFINITY, INFINITY};
    int steps = 0, own = 0, solves = 0; // own: steps of this kind
    for (;; ++steps, ++own) {
        evaluate(view(work->x), band.moved, *work, work->left);
        work->left = work->goal - work->left;
        const double worst = work->left.cwiseAbs().maxCoeff() / scale;
        at = &work->x;
        if (worst < best) {
            best = worst;
            work->best.swap(work->x);
            at = &work->best;
        }
        if (best < tolerance)
            break;
        const bool stalls = own >= 2 && !(worst < 0.5 * earlier[1]),
                   is_steep = own == 1 && stretch(band.fine, work->move) > most_chord_stretch;
        if (chord && (stalls || is_steep)) {
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
            precondition(work->left, *work, work->multipliers);
            const auto shares = mix(*work, own);
            ++solves;
            Points& change = work->steps.x[own % kept_steps];
            const int used = std::min(own, kept_steps), n = static_cast<int>(is_free_.size());
            pull(view(*at), band.moved, work->multipliers, *work, work->move);
            parallel_for(n, [&](int v) {
                for (int k = 0; k < used; ++k)
                    work->move.row(v) -= shares[k] * work->steps.x[k].row(v);
            });
            change = work->move;
        } else {
            solves += newton(view(*at), band.moved, work->left,
                             std::max(0.05 * worst, 0.3 * tolerance) * scale, most_solves - solves, *work);
            pull(view(*at), band.moved, work->multipliers, *work, work->move);
            if (const double change = stretch(band.fine, work->move); change > most_stretch)
                work->move *= most_stretch / change;
        }
        if (at != &work->x)
            work->x.resize(at->rows(), 3);
        parallel_for(static_cast<int>(at->rows()),
                     [&](int v) { work->x.row(v) = at->row(v) + work->move.row(v); });
        earlier[1] = earlier[0];
        earlier[0] = worst;
    }
    if (std::isfinite(best))
        detailed.swap(work->best);
    report.iterations += steps;
    report.residual = best;
    report.converged = report.converged && best < tolerance;
}

void DisplacementVolumes::report(BindReport& report) const
{
    report.factorizations = report.analyses = factor_.size() > 0 ? 1 : 0;
    report.factor_bytes = factor_.bytes();
}

} // namespace sinew

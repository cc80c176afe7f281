// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/mls.h"

#include "native/core/dense.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/operators/fits/rotation_fit.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <utility>

namespace sinew {

namespace {

/// Points extend in a direction if they do so by this share of their largest extent.
constexpr double flat = 1e-6;

int dimensions_of(const Points& points)
{
    const Points around = points.rowwise() - points.colwise().mean();
    const Eigenvectors<3> eigen = eigenvectors(Matrix3(around.transpose() * around));
    const double largest = std::sqrt(std::max(0.0, eigen.values[2]));
    int found = 0;
    while (found < 3 && largest > 0.0 && (around * eigen.vectors.col(2 - found)).norm() > flat * largest)
        ++found;
    return found;
}

/// M - 1 where the kernels are not sure of it.
Matrix3 linear_part(MlsMaps kind, const Matrix3& spread, const Matrix3& together)
{
    const Eigenvectors<3> eigen = eigenvectors(spread);
    if (!(eigen.values[2] > 0.0))
        return Matrix3::Zero();
    const double least = 1e-12 * eigen.values[2];
    if (kind == MlsMaps::affine) {
        Vector3 inverse;
        for (int k = 0; k < 3; ++k)
            inverse[k] = eigen.values[k] > least ? 1.0 / eigen.values[k] : 0.0;
        return together * eigen.vectors * inverse.asDiagonal() * eigen.vectors.transpose();
    }
    const Matrix3 S = spread + together;
    Matrix3 R;
    if (eigen.values[1] > least) {
        R = fit_rotation_svd(S);
    } else { // all on a line: the smallest turn that takes it along
        const Vector3 line = eigen.vectors.col(2), turned = S * line;
        R = turned.norm() > 1e-12 * eigen.values[2] ? smallest_turn(line, turned).toRotationMatrix()
                                                    : Matrix3::Identity();
    }
    const double scale = kind == MlsMaps::similarity ? R.cwiseProduct(S).sum() / spread.trace() : 1.0;
    return scale * R - Matrix3::Identity();
}

Vector3 move_of(MlsMaps kind, const MlsSums& sums, int lane)
{
    Matrix3 spread, together;
    Vector3 places, moves;
    int k = 0;
    for (int a = 0; a < 3; ++a) {
        places[a] = sums.places[a][lane];
        moves[a] = sums.moves[a][lane];
        for (int b = a; b < 3; ++b, ++k)
            spread(a, b) = spread(b, a) = sums.spread[k][lane];
        for (int b = 0; b < 3; ++b)
            together(a, b) = sums.together[a][b][lane];
    }
    return (moves - linear_part(kind, spread, together) * places) / sums.total[lane];
}

} // namespace

Mls::Mls(HandlePoints handles, const MlsOptions& options)
    : SpaceMethodWith("handles"), handles_(std::move(handles)), options_(options), maps_(options.maps)
{
    require_valid(options);
    std::vector<char> in_segment(static_cast<std::size_t>(handles_.point_count()), 0);
    for (const auto& [a, b] : options.segments) {
        for (const int end : {a, b}) {
            if (end < 0 || end >= handles_.point_count() || !handles_.is_single(handles_.handle_of(end)))
                throw InvalidConstraint("segments: point " + std::to_string(end) +
                                        " is no handle of one point");
            in_segment[static_cast<std::size_t>(end)] = 1;
        }
        if (handles_.points().row(a) == handles_.points().row(b)) {
            const int one = handles_.handle_of(a), other = handles_.handle_of(b);
            throw InvalidConstraint("the segment between handle " + std::to_string(one) + " and handle " +
                                        std::to_string(other) + " has no length",
                                    Error::Element::handle, {std::min(one, other), std::max(one, other)});
        }
        elements_.segments.push_back({a, b});
    }
    for (int h = 0; h < handles_.handle_count(); ++h)
        if (!handles_.is_single(h))
            elements_.groups.push_back(h);
        else if (!in_segment[static_cast<std::size_t>(handles_.begin(h))])
            elements_.points.push_back(handles_.begin(h));
    if (maps_ == MlsMaps::affine && dimensions_of(handles_.points()) < 3) {
        maps_ = MlsMaps::rigid;
        remark_ = "affine maps need four handle points that lie in no plane: rigid maps are used instead";
    }
}

Mls::~Mls() = default;

template <class T>
void Mls::weigh(PointsView points, std::vector<T>& weights, const Progress& progress) const
{
    const int n = static_cast<int>(points.rows()), numbers = elements_.numbers();
    const int blocks = (n + 3) / 4;
    const auto size = 4 * static_cast<std::size_t>(blocks) * static_cast<std::size_t>(numbers);
    require_memory(static_cast<std::int64_t>(size * sizeof(T)), "the weights of the handles");
    weights.resize(size);
    const int slab = std::max(256, 4'000'000 / std::max(1, handles_.point_count()) / 4);
    for (int first = 0; first < blocks; first += slab) {
        progress.tick(static_cast<double>(first) / blocks, "computing weights");
        parallel_chunks(std::min(slab, blocks - first), 16, [&](int begin, int end) {
            std::vector<double> own(static_cast<std::size_t>(numbers));
            for (int b = first + begin; b < first + end; ++b)
                for (int lane = 0; lane < 4; ++lane) {
                    const Vector3 v = points.row(std::min(4 * b + lane, n - 1)).transpose();
                    mls_weights(handles_, elements_, options_.alpha, v, own.data());
                    T* const to = weights.data() + 4 * static_cast<std::size_t>(b) * numbers + lane;
                    for (int k = 0; k < numbers; ++k)
                        to[4 * static_cast<std::size_t>(k)] = static_cast<T>(own[k]);
                }
        });
    }
    progress.tick(1.0, "computing weights");
}

void Mls::compute(PointsView points, SpaceReport& report, const Progress& progress)
{
    progress.tick(0.0, "computing weights");
    std::vector<float> singles;
    std::vector<double> doubles;
    if (is_single())
        weigh(points, singles, progress);
    else
        weigh(points, doubles, progress);
    report.weight_bytes = static_cast<std::int64_t>(4 * singles.size() + 8 * doubles.size());
    if (!remark_.empty())
        report.remarks.push_back(remark_);
    weights_.singles = std::move(singles);
    weights_.doubles = std::move(doubles);
}

void Mls::displace(PointsView control, PointsView base, PositionsOut out) const
{
    handles_.check(control);
    if (control == view(handles_.control())) { // a fit would round
        std::visit(
            [&](auto* positions) {
                std::transform(base.data(), base.data() + base.size(), positions, [](double x) {
                    return static_cast<std::remove_reference_t<decltype(*positions)>>(x);
                });
            },
            out);
        return;
    }
    std::vector<double> points, maps;
    for (const int i : elements_.points) {
        const auto row = handles_.column(handles_.handle_of(i));
        for (int k = 0; k < 3; ++k)
            points.push_back(handles_.points()(i, k));
        for (int k = 0; k < 3; ++k)
            points.push_back(control(row, k) - handles_.points()(i, k));
    }
    const auto add_map = [&](const Matrix3& B, const Vector3& b) {
        for (int a = 0; a < 3; ++a) {
            for (int k = 0; k < 3; ++k)
                maps.push_back(B(a, k));
            maps.push_back(b[a]);
        }
    };
    for (const int h : elements_.groups) {
        const Pose pose = handles_.map(control, h);
        add_map(pose.leftCols<3>() - Matrix3::Identity(), pose.col(3));
    }
    for (const auto& [a, b] : elements_.segments) {
        const auto move = [&](int i) -> Vector3 {
            return (control.row(handles_.column(handles_.handle_of(i))) - handles_.points().row(i))
                .transpose();
        };
        const Vector3 along = (handles_.points().row(b) - handles_.points().row(a)).transpose();
        const Matrix3 B = (move(b) - move(a)) * along.transpose() / along.squaredNorm();
        add_map(B, move(a) - B * handles_.points().row(a).transpose());
    }
    const MlsFrame frame{points.data(), maps.data(), static_cast<int>(points.size() / 6),
                         static_cast<int>(maps.size() / 12), maps_};
    std::visit([&](auto* positions) { move(frame, base, positions); }, out);
}

template <class Real>
void Mls::move(const MlsFrame& frame, PointsView base, Real* out) const
{
    const MlsKernels& kernels = widest_kernels<MlsKernels>();
    const Points& bound = points();
    const int n = static_cast<int>(bound.rows()), numbers = elements_.numbers();
    parallel_chunks((n + 3) / 4, 128, [&](int begin, int end) {
        std::array<double, 12> places, moves;
        MlsSums sums;
        for (int b = begin; b < end; ++b) {
            for (int lane = 0; lane < 4; ++lane)
                for (int k = 0; k < 3; ++k)
                    places[3 * lane + k] = bound(std::min(4 * b + lane, n - 1), k);
            const auto first = 4 * static_cast<std::size_t>(b) * numbers;
            const int safe = is_single() ? kernels.move_singles(frame, weights_.singles.data() + first,
                                                                places.data(), sums, moves.data())
                                         : kernels.move_doubles(frame, weights_.doubles.data() + first,
                                                                places.data(), sums, moves.data());
            for (int lane = 0; lane < 4 && 4 * b + lane < n; ++lane) {
                const int i = 4 * b + lane;
                if (!(safe >> lane & 1))
                    Vector3::Map(moves.data() + 3 * lane) = move_of(frame.kind, sums, lane);
                for (int k = 0; k < 3; ++k)
                    out[3 * static_cast<std::size_t>(i) + k] =
                        static_cast<Real>(base(i, k) + moves[3 * lane + k]);
            }
        }
    });
}

std::vector<std::string> Mls::changed_settings(const SpaceMethod& former) const
{
    const auto& other = static_cast<const Mls&>(former);
    return changed(options_, other.options_, names_of({{"handles", !(handles_ == other.handles_)}}));
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/weights/point_weights.h"

#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/methods/space/weights/products.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <type_traits>

namespace sinew {

namespace {

template <class T>
constexpr int block_points = 64 / sizeof(T);

/// A mean move is taken out if it is so many times as long as the moves relative to it.
constexpr double much_longer = 8.0;
constexpr double one = 1e-9; ///< a sum of weights that is so close to 1 is 1

using Vector4 = Eigen::Vector4d;
using Matrix4 = Eigen::Matrix4d;

std::size_t blocks_of(int points, int block)
{
    return static_cast<std::size_t>((points + block - 1) / block);
}

/// M^-1 b on the range of M, which is positive semi-definite.
Vector4 solve_on_range(const Matrix4& M, const Vector4& b)
{
    const Eigenvectors<4> eigen = eigenvectors(M);
    Vector4 inner = eigen.vectors.transpose() * b;
    for (int i = 0; i < 4; ++i)
        inner[i] = eigen.values[i] > 1e-9 * eigen.values[3] ? inner[i] / eigen.values[i] : 0.0;
    return eigen.vectors * inner;
}

} // namespace

PointWeights::PointWeights(int points, const Points& rest_controls, int vertices,
                           const PointWeightOptions& options)
    : points_(points), vertices_(vertices), options_(options), controls_(rest_controls)
{
    if (!(options.threshold >= 0.0 && options.threshold < 1.0))
        throw InvalidOption("the threshold of the weights must lie in [0, 1)");
    const std::size_t parts = blocks_of(points, part);
    dropped_.assign(parts, 0.0);
    sums_.assign(is_single() ? static_cast<std::size_t>(points) : 0, 1.0);
    if (is_sparse()) {
        columns_.resize(parts);
        offsets_.resize(parts);
        singles_.values.resize(is_single() ? parts : 0);
        doubles_.values.resize(is_single() ? 0 : parts);
        // Moments are computed about the middle of the control, in units of its size.
        const Eigen::RowVector3d centre = controls_.topRows(vertices_).colwise().mean();
        controls_.topRows(vertices_).rowwise() -= centre;
        if (const double size = controls_.topRows(vertices_).cwiseAbs().maxCoeff(); size > 0.0)
            controls_ /= size;
        return;
    }
    const auto dense = [&](auto& store, auto number) {
        using T = decltype(number);
        dense_size_ =
            blocks_of(points, block_points<T>) * block_points<T> * static_cast<std::size_t>(column_count());
        check_memory();
        store.blocks = std::make_unique_for_overwrite<T[]>(dense_size_);
    };
    if (is_single())
        dense(singles_, 0.0f);
    else
        dense(doubles_, 0.0);
}

void PointWeights::set_rows(int first, const RowMatrix& rows)
{
    if (is_single())
        for (Eigen::Index i = 0; i < rows.rows(); ++i)
            if (const double sum = rows.row(i).head(vertices_).sum(); std::abs(sum - 1.0) > one)
                sums_[static_cast<std::size_t>(first + i)] = sum;
    if (is_sparse())
        is_single() ? keep_large(singles_, first, rows) : keep_large(doubles_, first, rows);
    else
        is_single() ? fill(singles_, first, rows) : fill(doubles_, first, rows);
}

template <class T>
void PointWeights::fill(Store<T>& store, int first, const RowMatrix& rows)
{
    constexpr int block = block_points<T>;
    const int columns = column_count(), count = static_cast<int>(rows.rows());
    for (int i = 0; i < count; i += block) {
        T* const to = store.blocks.get() + static_cast<std::size_t>(first + i) * columns;
        const int some = std::min(block, count - i);
        if (some < block)
            std::fill(to, to + static_cast<std::size_t>(block) * columns, T(0));
        for (int k = 0; k < some; ++k) {
            const double* const row = rows.data() + static_cast<std::size_t>(i + k) * columns;
            for (int c = 0; c < columns; ++c)
                to[static_cast<std::size_t>(c) * block + k] = static_cast<T>(row[c]);
        }
    }
}

/// The weights that a row keeps, and how they change.
struct PointWeights::Thinned
{
    std::vector<int> kept;
    Vector4 change = Vector4::Zero();
    double lost = 0.0; ///< sum of the magnitudes of the dropped weights
};

Eigen::Vector4d PointWeights::moment(int column) const
{
    Vector4 z;
    z << (column < vertices_ ? 1.0 : 0.0), controls_.row(column).transpose();
    return z;
}

/// Keeps the weights that are at least `least`.
/// \return false if those cannot make up for the others.
bool PointWeights::thin(const double* row, double least, Thinned& thinned) const
{
    thinned.kept.clear();
    thinned.lost = 0.0;
    thinned.change.setZero();
    Vector4 defect = Vector4::Zero();
    Matrix4 M = Matrix4::Zero();
    for (int c = 0; c < column_count(); ++c) {
        const Vector4 z = moment(c);
        if (std::abs(row[c]) >= least) {
            thinned.kept.push_back(c);
            M += std::abs(row[c]) * z * z.transpose();
        } else {
            defect += row[c] * z;
            thinned.lost += std::abs(row[c]);
        }
    }
    if (thinned.lost == 0.0)
        return true;
    thinned.change = solve_on_range(M, defect);
    double most = 0.0;
    for (int c : thinned.kept)
        most = std::max(most, std::abs(thinned.change.dot(moment(c))));
    if (most <= 0.1 && (M * thinned.change - defect).norm() <= 1e-10 * thinned.lost)
        return true;
    // M(0, 0) is the sum of the magnitudes of the weights kept.
    thinned.change << (defect[0] != 0.0 ? defect[0] / M(0, 0) : 0.0), 0.0, 0.0, 0.0;
    return std::abs(thinned.change[0]) <= 0.5;
}

template <class T>
void PointWeights::keep_large(Store<T>& store, int first, const RowMatrix& rows)
{
    Thinned thinned;
    const int count = static_cast<int>(rows.rows());
    for (int i = 0; i < count; ++i) {
        const std::size_t own = static_cast<std::size_t>((first + i) / part);
        std::vector<T>& values = store.values[own];
        std::vector<int>&indices = columns_[own], &offsets = offsets_[own];
        offsets.push_back(static_cast<int>(values.size()));
        const double* const row = rows.row(i).data();
        for (double least = options_.threshold; !thin(row, least, thinned);)
            least *= 0.5;
        double change = thinned.lost;
        for (int c : thinned.kept) {
            const double by = std::abs(row[c]) * thinned.change.dot(moment(c));
            values.push_back(static_cast<T>(row[c] + by));
            indices.push_back(c);
            change += std::abs(by);
        }
        dropped_[own] = std::max(dropped_[own], change);
        if (i + 1 == count || (first + i + 1) % part == 0) {
            offsets.push_back(static_cast<int>(values.size()));
            values.shrink_to_fit();
            indices.shrink_to_fit();
        }
    }
}

template <class Real>
void PointWeights::apply(const Points& moves, PointsView rest, Real* positions) const
{
    if (is_single())
        apply(singles_, moves, rest, positions);
    else
        apply(doubles_, moves, rest, positions);
}

template <class T, class Real>
void PointWeights::apply(const Store<T>& store, const Points& all_moves, PointsView rest,
                         Real* positions) const
{
    Eigen::RowVector3d mean = Eigen::RowVector3d::Zero();
    Points relative;
    if (is_single() && vertices_ > 0) {
        mean = all_moves.topRows(vertices_).colwise().mean();
        const double farthest = (all_moves.topRows(vertices_).rowwise() - mean).cwiseAbs().maxCoeff();
        if (mean.cwiseAbs().maxCoeff() > much_longer * farthest) {
            relative = all_moves;
            relative.topRows(vertices_).rowwise() -= mean;
        } else {
            mean.setZero();
        }
    }
    const Points& moves = relative.size() > 0 ? relative : all_moves;
    const double most = moves.size() > 0 ? moves.cwiseAbs().maxCoeff() : 0.0;
    // Moves are scaled so that they fit into single precision. A power of two causes no rounding.
    const double scale = most > 0.0 ? std::ldexp(1.0, std::ilogb(most)) : 1.0;
    const int columns = column_count(), stride = is_sparse() ? 4 : 3;
    std::vector<T> factors(static_cast<std::size_t>(columns) * stride, T(0));
    for (int c = 0; c < columns; ++c)
        for (int axis = 0; axis < 3; ++axis)
            factors[static_cast<std::size_t>(c) * stride + axis] = static_cast<T>(moves(c, axis) / scale);
    const ProductKernels& kernels = widest_kernels<ProductKernels>();
    const bool apart = relative.size() > 0;
    const auto place = [&](int i, const T* sum, int step) {
        for (int axis = 0; axis < 3; ++axis) {
            const double own = scale * static_cast<double>(sum[step * axis]);
            positions[3 * static_cast<std::size_t>(i) + axis] = static_cast<Real>(
                rest(i, axis) + (apart ? sums_[static_cast<std::size_t>(i)] * mean[axis] + own : own));
        }
    };
    constexpr int block = block_points<T>;
    const int grain = std::max(1, (1 << 16) / (std::max(columns, 1) * block));
    if (is_sparse()) {
        parallel_for(
            static_cast<int>(offsets_.size()),
            [&](int own) {
                std::array<T, 4 * part> sums;
                const auto index = static_cast<std::size_t>(own);
                const int count = static_cast<int>(offsets_[index].size()) - 1;
                if constexpr (std::is_same_v<T, float>)
                    kernels.sparse_product_of_floats(store.values[index].data(), columns_[index].data(),
                                                     offsets_[index].data(), count, factors.data(),
                                                     sums.data());
                else
                    kernels.sparse_product_of_doubles(store.values[index].data(), columns_[index].data(),
                                                      offsets_[index].data(), count, factors.data(),
                                                      sums.data());
                for (int i = 0; i < count; ++i)
                    place(part * own + i, sums.data() + 4 * i, 1);
            },
            16);
        return;
    }
    parallel_for(
        static_cast<int>(blocks_of(points_, block)),
        [&](int b) {
            std::array<T, 3 * block> sums;
            const T* const own = store.blocks.get() + static_cast<std::size_t>(b) * block * columns;
            if constexpr (std::is_same_v<T, float>)
                kernels.product_of_floats(own, columns, factors.data(), sums.data());
            else
                kernels.product_of_doubles(own, columns, factors.data(), sums.data());
            for (int i = 0; i < std::min(block, points_ - b * block); ++i)
                place(b * block + i, sums.data() + i, block);
        },
        grain);
}

template <class Visit>
void PointWeights::visit(Visit&& entry) const
{
    const auto each = [&](const auto& store, auto number) {
        constexpr int block = block_points<decltype(number)>;
        for (int i = 0; i < points_; ++i) {
            if (is_sparse()) {
                const auto own = static_cast<std::size_t>(i / part);
                for (int k = offsets_[own][i % part]; k < offsets_[own][i % part + 1]; ++k)
                    entry(i, columns_[own][k], static_cast<double>(store.values[own][k]));
            } else {
                const auto* const from = store.blocks.get() +
                                         static_cast<std::size_t>(i / block) * block * column_count() +
                                         i % block;
                for (int c = 0; c < column_count(); ++c)
                    entry(i, c, static_cast<double>(from[static_cast<std::size_t>(c) * block]));
            }
        }
    };
    if (is_single())
        each(singles_, 0.0f);
    else
        each(doubles_, 0.0);
}

VectorX PointWeights::sum(const std::vector<int>& columns) const
{
    VectorX total = VectorX::Zero(points_);
    if (is_sparse()) {
        std::vector<char> wanted(column_count(), 0);
        for (int c : columns)
            wanted[c] = 1;
        visit([&](int i, int c, double w) { total[i] += wanted[c] ? w : 0.0; });
        return total;
    }
    const auto add = [&](const auto& store, auto number) {
        constexpr int block = block_points<decltype(number)>;
        for (int i = 0; i < points_; ++i) {
            const auto* const from =
                store.blocks.get() + static_cast<std::size_t>(i / block) * block * column_count() + i % block;
            for (int c : columns)
                total[i] += static_cast<double>(from[static_cast<std::size_t>(c) * block]);
        }
    };
    if (is_single())
        add(singles_, 0.0f);
    else
        add(doubles_, 0.0);
    return total;
}

RowMatrix PointWeights::dense() const
{
    RowMatrix W = RowMatrix::Zero(points_, column_count());
    visit([&](int i, int c, double w) { W(i, c) = w; });
    return W;
}

Eigen::SparseMatrix<double, Eigen::RowMajor> PointWeights::sparse() const
{
    std::vector<Eigen::Triplet<double>> entries;
    visit([&](int i, int c, double w) {
        if (w != 0.0)
            entries.emplace_back(i, c, w);
    });
    Eigen::SparseMatrix<double, Eigen::RowMajor> W(points_, column_count());
    W.setFromTriplets(entries.begin(), entries.end());
    return W;
}

double PointWeights::dropped() const
{
    return dropped_.empty() ? 0.0 : *std::max_element(dropped_.begin(), dropped_.end());
}

void PointWeights::check_memory() const { require_memory(bytes(), "the matrix of weights"); }

std::int64_t PointWeights::bytes() const
{
    std::size_t kept = 0, indices = 0;
    for (const auto& own : columns_) {
        kept += own.size();
        indices += own.size() + part + 1;
    }
    const std::size_t numbers = is_sparse() ? kept : dense_size_;
    return static_cast<std::int64_t>(numbers * (is_single() ? sizeof(float) : sizeof(double)) +
                                     indices * sizeof(int));
}

template void PointWeights::apply(const Points&, PointsView, double*) const;
template void PointWeights::apply(const Points&, PointsView, float*) const;

} // namespace sinew

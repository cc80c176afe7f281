// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/types.h"

#include <Eigen/SparseCore>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace sinew {

enum class WeightPrecision {
    single_precision, ///< half the memory and time of a warp; its error is 1e-7 of the longest move
    double_precision
};
constexpr auto choices(WeightPrecision)
{
    return std::array{Choice{"single", WeightPrecision::single_precision},
                      Choice{"double", WeightPrecision::double_precision}};
}

struct PointWeightOptions
{
    WeightPrecision precision = WeightPrecision::single_precision;
    /// Weights of a smaller magnitude are dropped where the others can make up for them, and the others are
    /// stored as a sparse matrix. 0 keeps all weights, in a dense matrix. See PointWeights.
    double threshold = 0.0;
};

/// (n, k) weights that take the moves of k control columns to n points. They are computed once and applied in
/// every frame.
///
/// Where weights of a row are dropped, the others are changed in proportion to their magnitude, so that two
/// things stay the same: the sum of the row, which reproduces translations, and the rest point that it gives,
/// which reproduces affine maps (similarities with Green coordinates). If a weight would have to change by
/// more than a tenth for this, for example near faces, only the sum is kept. If that would take more than
/// half of a weight, the row also keeps smaller weights.
class PointWeights
{
public:
    PointWeights() = default;

    /// \param rest_controls  (k, 3) where the controls are at rest.
    /// \param vertices       how many of the columns are points. The others, behind them, are vectors, which
    ///                       a translation does not change.
    /// \throw InvalidOption  the threshold is outside [0, 1).
    /// \throw OutOfMemory    dense weights would take more than limit_memory() allows.
    PointWeights(int points, const Points& rest_controls, int vertices, const PointWeightOptions& options);

    int point_count() const { return points_; }
    int column_count() const { return static_cast<int>(controls_.rows()); }

    /// Number of points per part. Rows are set in whole parts, except for the last one.
    static constexpr int part = 64;
    /// Sets the rows of points [first, first + rows.rows()), where first is a multiple of `part`. Several
    /// threads may set different parts at once.
    void set_rows(int first, const RowMatrix& rows);

    /// positions = rest + W moves. Allocates no array of the size of the points. In single precision, a mean
    /// move that is much longer than the moves relative to it is not multiplied by single weights, but by the
    /// sum of each row: the error is 1e-7 of the relative moves.
    /// \param moves           (k, 3) how far each control has moved from its rest.
    /// \param rest            (n, 3)
    /// \param[out] positions  (n, 3), row-major
    template <class Real>
    void apply(const Points& moves, PointsView rest, Real* positions) const;

    /// (n, k) all weights, with zeros for dropped ones.
    RowMatrix dense() const;
    /// (n) the sums of some columns, each of which is named once.
    VectorX sum(const std::vector<int>& columns) const;
    Eigen::SparseMatrix<double, Eigen::RowMajor> sparse() const;

    /// How much the threshold changed the weights of a point, as a sum of magnitudes, for the point where
    /// this is largest. The error of a warped point is at most this times the longest move of a control.
    double dropped() const;
    std::int64_t bytes() const;
    /// \throw OutOfMemory  the sparse weights set so far take more than limit_memory() allows.
    void check_memory() const;

private:
    template <class T>
    struct Store
    {
        /// Dense weights in blocks of block_points<T> points, one column after the other. They are not
        /// cleared, so that the threads that set the rows are the first to touch the memory.
        std::unique_ptr<T[]> blocks;
        /// Sparse weights, one vector per part.
        std::vector<std::vector<T>> values;
    };
    template <class T>
    void fill(Store<T>& store, int first, const RowMatrix& rows);
    struct Thinned;
    /// What a weight of 1 in a column contributes to a row's sum and rest point.
    Eigen::Vector4d moment(int column) const;
    bool thin(const double* row, double least, Thinned& thinned) const;
    template <class T>
    void keep_large(Store<T>& store, int first, const RowMatrix& rows);
    template <class T, class Real>
    void apply(const Store<T>& store, const Points& moves, PointsView rest, Real* positions) const;
    template <class Visit>
    void visit(Visit&& entry) const;

    bool is_sparse() const { return options_.threshold > 0.0; }
    bool is_single() const { return options_.precision == WeightPrecision::single_precision; }

    int points_ = 0, vertices_ = 0;
    std::size_t dense_size_ = 0; ///< numbers in the blocks
    PointWeightOptions options_;
    Points controls_;
    Store<float> singles_;
    Store<double> doubles_;
    std::vector<std::vector<int>> columns_; ///< of sparse weights: the column of each entry of a part
    std::vector<std::vector<int>> offsets_; ///< of sparse weights: where each row of a part begins
    std::vector<double>
        sums_; ///< of single weights: the sum of the vertices' weights in each row, before rounding
    std::vector<double> dropped_;           ///< the largest change of each part, see dropped()
};

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <Eigen/SparseCore>

#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

namespace sinew {

enum class WeightPrecision {
    single_precision, ///< float32 weights: half the memory and time of a warp, 1e-7 of a cage vertex's move
                      ///< off
    double_precision
};

struct PointWeightOptions
{
    WeightPrecision precision = WeightPrecision::single_precision;
    /// Weights of a smaller magnitude are dropped where the others can make up for them, and the weights kept
    /// are stored sparsely; 0 keeps all, densely. See PointWeights.
    double threshold = 0.0;
};

/// (n, k) weights that take the moves of k control columns to n points, bound once and applied each frame.
///
/// Where weights are dropped, those kept are changed in proportion to their magnitude so that the row gives
/// its sum as before, which keeps translations, and its rest point, which keeps affine maps (of Green
/// coordinates: similarities). Where one would have to change by more than a tenth for that, near faces say,
/// they keep the sum alone; where it would take more than half for the sum, the row keeps smaller weights,
/// too.
class PointWeights
{
public:
    PointWeights() = default;

    /// \param rest_controls  (k, 3) where the controls are at rest.
    /// \param vertices       the first so many columns are points, the others vectors, which no translation
    /// moves.
    /// \throw InvalidOption  a threshold outside of [0, 1).
    /// \throw OutOfMemory  dense weights would take more than limit_memory() allows; both are named.
    PointWeights(int points, const Points& rest_controls, int vertices, const PointWeightOptions& options);

    int point_count() const { return points_; }
    int column_count() const { return static_cast<int>(controls_.rows()); }

    /// Points a part: rows are set by whole parts, but for the last.
    static constexpr int part = 64;
    /// Keep the rows of points [first, first + rows.rows()), first a multiple of `part`. Safe for disjoint
    /// rows at once.
    void set_rows(int first, const RowMatrix& rows);

    /// positions = rest + W moves. Allocates nothing of the size of the points.
    /// \param moves           (k, 3) how far each control is from its rest.
    /// \param rest            (n, 3)
    /// \param[out] positions  (n, 3), row-major
    template <class Real>
    void apply(const Points& moves, PointsView rest, Real* positions) const;

    /// (n, k), those dropped as 0.
    RowMatrix dense() const;
    /// (n) some columns, each named once, added up.
    VectorX sum(const std::vector<int>& columns) const;
    Eigen::SparseMatrix<double, Eigen::RowMajor> sparse() const;

    /// The largest sum, at a point, of how far its weights are from what they were without the threshold.
    /// A warped point is off by at most this times the longest move of a control.
    double dropped() const;
    std::int64_t bytes() const;
    /// \throw OutOfMemory  the sparse weights set so far take more than limit_memory() allows.
    void check_memory() const;

private:
    template <class T>
    struct Store
    {
        /// Dense: by blocks of block_points<T> points, one column after the other. Not cleared: whoever sets
        /// the rows touches the memory first.
        std::unique_ptr<T[]> blocks;
        /// Sparse: one of each a part.
        std::vector<std::vector<T>> values;
    };
    template <class T>
    void fill(Store<T>& store, int first, const RowMatrix& rows);
    struct Thinned;
    /// What a column gives to a row's sum and rest point.
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
    std::vector<std::vector<int>> columns_,
        offsets_; ///< sparse: a part's column indices, where its rows begin
    std::vector<double> dropped_;                     ///< a part's largest
};

} // namespace sinew

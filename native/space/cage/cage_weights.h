// SPDX-License-Identifier: GPL-3.0-or-later
// For every method of this room.
#pragma once

#include "native/core/types.h"
#include "native/solvers/factor_engine.h"

#include <Eigen/SparseCore>

#include <cstdint>
#include <vector>

namespace sinew {

enum class WeightPrecision {
    single_precision, ///< float32 weights: half the memory and time of a warp, 1e-7 of the cage's size off
    double_precision
};

struct CageWeightOptions
{
    WeightPrecision precision = WeightPrecision::single_precision;
    /// Weights of a smaller magnitude are dropped, and the weights kept are stored sparsely; 0 keeps all,
    /// densely.
    double threshold = 0.0;
};

/// (n, k) weights that take k control columns to n points, bound once and applied each frame.
class CageWeights
{
public:
    CageWeights() = default;

    /// \throw OutOfMemory  dense weights would take more than limit_memory() allows; both are named.
    CageWeights(int points, int columns, const CageWeightOptions& options);

    int point_count() const { return points_; }
    int column_count() const { return columns_; }

    /// Keep the rows of points [first, first + rows.rows()). Safe for disjoint rows at once.
    void set_rows(int first, const RowMatrix& rows);
    /// After the last set_rows().
    void finish();

    /// \param controls       (k, 3)
    /// \param[out] positions  (n, 3) W controls
    void apply(const Points& controls, Points& positions) const;

    /// (n, k), those dropped as 0.
    RowMatrix dense() const;
    Eigen::SparseMatrix<double, Eigen::RowMajor> sparse() const;

    /// The largest sum of the magnitudes dropped at a point.
    double dropped() const { return dropped_; }
    std::int64_t bytes() const;

private:
    int points_ = 0, columns_ = 0;
    CageWeightOptions options_;
    double dropped_ = 0.0;
    std::vector<float> singles_;
    std::vector<double> doubles_;
};

} // namespace sinew

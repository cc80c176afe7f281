// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/cage_weights.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"

namespace sinew {

CageWeights::CageWeights(int points, int columns, const CageWeightOptions& options)
    : points_(points), columns_(columns), options_(options)
{
    if (!(options.threshold >= 0.0 && options.threshold < 1.0))
        throw InvalidOption("the threshold of the weights must lie in [0, 1)");
    const std::size_t size = static_cast<std::size_t>(points) * static_cast<std::size_t>(columns);
    require_memory(static_cast<std::int64_t>(size) *
                   (options.precision == WeightPrecision::single_precision ? 4 : 8));
    if (options.precision == WeightPrecision::single_precision)
        singles_.resize(size);
    else
        doubles_.resize(size);
}

void CageWeights::set_rows(int first, const RowMatrix& rows)
{
    const std::size_t at = static_cast<std::size_t>(first) * static_cast<std::size_t>(columns_);
    for (Eigen::Index i = 0; i < rows.size(); ++i) {
        if (options_.precision == WeightPrecision::single_precision)
            singles_[at + static_cast<std::size_t>(i)] = static_cast<float>(rows.data()[i]);
        else
            doubles_[at + static_cast<std::size_t>(i)] = rows.data()[i];
    }
}

void CageWeights::finish() {}

void CageWeights::apply(const Points& controls, Points& positions) const { positions = dense() * controls; }

RowMatrix CageWeights::dense() const
{
    if (options_.precision == WeightPrecision::double_precision)
        return Eigen::Map<const RowMatrix>(doubles_.data(), points_, columns_);
    using Singles = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
    return Eigen::Map<const Singles>(singles_.data(), points_, columns_).cast<double>();
}

Eigen::SparseMatrix<double, Eigen::RowMajor> CageWeights::sparse() const { return dense().sparseView(); }

std::int64_t CageWeights::bytes() const
{
    return static_cast<std::int64_t>(singles_.size()) * 4 + static_cast<std::int64_t>(doubles_.size()) * 8;
}

} // namespace sinew

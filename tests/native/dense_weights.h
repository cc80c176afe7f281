// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

namespace sinew {

/// A Laplacian whose negative weights became positive ones of a millionth of their size.
inline MatrixX with_positive_weights(const MatrixX& L)
{
    MatrixX found = L.unaryExpr([](double entry) { return entry > 1e-9 ? -1e-6 * entry : entry; });
    found.diagonal().setZero();
    found.diagonal() = -found.rowwise().sum().eval();
    return found;
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <gtest/gtest.h>

namespace sinew {

/// The derivative of f(s) at 0, whose error is of the square of the step.
template <class F>
double central_difference(F&& f, double step)
{
    return (f(step) - f(-step)) / (2 * step);
}

/// A gradient is that of central differences of f(x), at each `stride`-th row.
template <class F>
void expect_gradient(F&& f, const Points& x, const Points& gradient, double step, double tolerance,
                     int stride = 1)
{
    for (int i = 0; i < x.rows(); i += stride)
        for (int axis = 0; axis < 3; ++axis) {
            const auto moved = [&](double by) {
                Points there = x;
                there(i, axis) += by;
                return f(there);
            };
            EXPECT_NEAR(gradient(i, axis), central_difference(moved, step), tolerance) << i << ", " << axis;
        }
}

} // namespace sinew

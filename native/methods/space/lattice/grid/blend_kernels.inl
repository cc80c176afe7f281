// SPDX-License-Identifier: GPL-3.0-or-later
// The body of BlendKernels, compiled once for each set of instructions.

#include "native/core/simd/lane_types.inl"

namespace {

/// `fixed` is the width along each axis, so that the loops unroll; 0 for any other.
template <int fixed>
void blend_with(const sinew::BlendCell& cell, const double* local, double* sums)
{
    constexpr int room = fixed ? fixed : sinew::BlendKernels::most_width;
    for (int from = 0; from < sinew::BlendKernels::lanes; from += lane_count) {
        Lanes<double> B[3][room];
        int widths[3];
        for (int axis = 0; axis < 3; ++axis) {
            const sinew::BlendAxis& piece = cell.axes[axis];
            widths[axis] = fixed ? fixed : piece.width;
            const Lanes<double> t = load(local + sinew::BlendKernels::lanes * axis + from);
            const double* row = piece.coefficients;
            for (int i = 0; i < widths[axis]; ++i, row += piece.degree + 1) {
                Lanes<double> sum = constant(row[piece.degree]);
                for (int k = piece.degree - 1; k >= 0; --k)
                    sum = sum * t + constant(row[k]);
                B[axis][i] = sum;
            }
        }
        Lanes<double> total[3] = {constant(0.0), constant(0.0), constant(0.0)};
        for (int k = 0; k < widths[2]; ++k) {
            Lanes<double> layer[3] = {constant(0.0), constant(0.0), constant(0.0)};
            for (int j = 0; j < widths[1]; ++j) {
                const double* move = cell.moves + k * cell.strides[1] + j * cell.strides[0];
                Lanes<double> x = move[0] * B[0][0], y = move[1] * B[0][0], z = move[2] * B[0][0];
                for (int i = 1; i < widths[0]; ++i) {
                    move += 3;
                    x = x + move[0] * B[0][i];
                    y = y + move[1] * B[0][i];
                    z = z + move[2] * B[0][i];
                }
                layer[0] = layer[0] + B[1][j] * x;
                layer[1] = layer[1] + B[1][j] * y;
                layer[2] = layer[2] + B[1][j] * z;
            }
            for (int axis = 0; axis < 3; ++axis)
                total[axis] = total[axis] + B[2][k] * layer[axis];
        }
        for (int axis = 0; axis < 3; ++axis)
            store(sums + sinew::BlendKernels::lanes * axis + from, total[axis]);
    }
}

void blend_any(const sinew::BlendCell& cell, const double* local, double* sums)
{
    const int width = cell.axes[0].width;
    const bool equal = cell.axes[1].width == width && cell.axes[2].width == width;
    if (equal && width == 4)
        blend_with<4>(cell, local, sums);
    else if (equal && width == 2)
        blend_with<2>(cell, local, sums);
    else
        blend_with<0>(cell, local, sums);
}

} // namespace

const sinew::BlendKernels sinew::BlendKernels::SINEW_INSTRUCTIONS{blend_any};

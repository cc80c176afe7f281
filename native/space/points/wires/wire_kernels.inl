// SPDX-License-Identifier: GPL-3.0-or-later
// The body of WireKernels, compiled once for each set of instructions.

#include "native/core/simd/lane_math.inl"

namespace sinew {

namespace {

using Wide = Lanes<double>;

constexpr int terms = 15; // of the series below, for angles up to pi

/// sin(a) / a and (1 - cos(a)) / a^2 for a^2 = square, by their series.
inline void turning(Wide square, Wide& sine, Wide& cosine)
{
    // 1 / (2 k + 1)! and 1 / (2 k + 2)! are made from the last term on, as products with the next one.
    sine = cosine = constant(1.0);
    for (int k = terms; k > 0; --k) {
        sine = constant(1.0) - (1.0 / (2.0 * k * (2.0 * k + 1.0))) * (square * sine);
        cosine = constant(1.0) - (1.0 / ((2.0 * k + 1.0) * (2.0 * k + 2.0))) * (square * cosine);
    }
    cosine = 0.5 * cosine;
}

void moves(const WireContacts& contacts, const double* table, int first, int blocks, double* out)
{
    for (int block = first; block < first + blocks; ++block, out += 16) {
        Wide sum[4], turn[4];
        for (int lane = 0; lane < 4; ++lane) {
            const int contact = 4 * block + lane;
            sum[lane] = turn[lane] = constant(0.0);
            for (int k = contacts.firsts[contact]; k < contacts.firsts[contact + 1]; ++k) {
                const double* row = table + 8 * static_cast<long long>(contacts.samples[k]);
                sum[lane] = sum[lane] + contacts.shares[k] * load(row);
                turn[lane] = turn[lane] + contacts.shares[k] * load(row + 4);
            }
        }
        transpose(sum[0], sum[1], sum[2], sum[3]);
        transpose(turn[0], turn[1], turn[2], turn[3]);
        const double* from = contacts.blocks + 20 * static_cast<long long>(block);
        const Wide x = load(from), y = load(from + 4), z = load(from + 8), F = load(from + 12);
        const Wide scale = constant(1.0) + load(from + 16);
        const Wide u = F * turn[0], v = F * turn[1], w = F * turn[2];
        Wide S, C;
        turning(u * u + v * v + w * w, S, C);
        const Wide a = scale * x, b = scale * y, c = scale * z;
        const Wide p = v * c - w * b, q = w * a - u * c, r = u * b - v * a;
        Wide dx = ((a + (S * p + C * (v * r - w * q))) - x) + F * sum[0];
        Wide dy = ((b + (S * q + C * (w * p - u * r))) - y) + F * sum[1];
        Wide dz = ((c + (S * r + C * (u * q - v * p))) - z) + F * sum[2];
        Wide none = constant(0.0);
        transpose(dx, dy, dz, none);
        store(out, dx), store(out + 4, dy), store(out + 8, dz), store(out + 12, none);
    }
}

} // namespace

const WireKernels WireKernels::SINEW_INSTRUCTIONS{sinew::moves};

} // namespace sinew

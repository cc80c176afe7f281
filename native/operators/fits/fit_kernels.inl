// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of FitKernels, compiled once for each set of instructions. One lane is one matrix.

#include "native/operators/fits/rotation_fit.inl"

namespace {

int fit(const double* S, double* R)
{
    Lanes<double> entries[9];
    for (int k = 0; k < 9; ++k)
        entries[k] = Lanes<double>{S[k], S[9 + k], S[18 + k], S[27 + k]};
    FourFits fits;
    fits.begin(entries, constant(0.0));
    for (int step = 0; step < most_newton_steps; ++step) {
        fits.step();
        if (fits.done())
            break;
    }
    const int safe = mask_bits(fits.finish(entries));
    for (int k = 0; k < 9; ++k)
        for (int lane = 0; lane < 4; ++lane)
            R[9 * lane + k] = entries[k][lane];
    return safe;
}

} // namespace

const sinew::FitKernels sinew::FitKernels::SINEW_INSTRUCTIONS{::fit};

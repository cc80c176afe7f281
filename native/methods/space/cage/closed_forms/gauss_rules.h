// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include <array>

namespace sinew {

constexpr int most_gauss_nodes = 12;

/// Gauss's rule over [-1, 1]: nodes and weights, one after the other.
struct GaussRule
{
    int count;
    double pairs[2 * most_gauss_nodes];
    double node(int k) const { return pairs[2 * k]; }
    double weight(int k) const { return pairs[2 * k + 1]; }
};

/// The nodes are roots of a Legendre polynomial, found with four operations alone, so that every machine has
/// the same bits. Each root is followed from the rule with one node less, whose nodes lie between.
constexpr GaussRule gauss_rule(int count)
{
    constexpr auto legendre = [](int n, double x, double& slope) {
        double before = 1.0, value = x;
        for (int k = 2; k <= n; ++k) {
            const double next = ((2 * k - 1) * x * value - (k - 1) * before) / k;
            before = value;
            value = next;
        }
        slope = n * (x * value - before) / (x * x - 1.0);
        return value;
    };
    GaussRule rule{1, {0.0, 2.0}};
    for (int n = 2; n <= count; ++n) {
        GaussRule next{n, {}};
        for (int k = 0; k < n; ++k) {
            double low = k == 0 ? -1.0 : rule.pairs[2 * (k - 1)];
            double high = k == n - 1 ? 1.0 : rule.pairs[2 * k];
            double slope = 0.0, x = 0.5 * (low + high);
            const bool rises = (n - k) % 2 == 1; // the polynomial at the root
            for (int step = 0; step < 60; ++step) {
                const double value = legendre(n, x, slope);
                ((value > 0.0) == rises ? high : low) = x;
                const double newton = x - value / slope;
                const double better = newton > low && newton < high ? newton : 0.5 * (low + high);
                if (better == x)
                    break;
                x = better;
            }
            if (2 * k + 1 == n)
                x = 0.0;
            legendre(n, x, slope);
            next.pairs[2 * k] = x;
            next.pairs[2 * k + 1] = 2.0 / ((1.0 - x * x) * slope * slope);
        }
        rule = next;
    }
    return rule;
}

} // namespace sinew

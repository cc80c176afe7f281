// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/graph/embedded_energy.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <vector>

namespace sinew::test_embedded_energy {

namespace {

/// Nodes anywhere, joined in a ring with chords, and points that two handles pull.
struct Small
{
    static constexpr int nodes = 7, count = 9;
    std::vector<std::array<int, 2>> edges;
    Points places, points;
    std::vector<EmbeddedEnergy::Pull> pulls;
    std::vector<HeldMotion> motions;
    EmbeddedWeights weights{1.3, 7.0, 40.0};

    Small()
    {
        shapes::Random random(3);
        for (int j = 0; j < nodes; ++j) {
            edges.push_back({std::min(j, (j + 1) % nodes), std::max(j, (j + 1) % nodes)});
            if (j % 2)
                edges.push_back({0, j});
        }
        places = random.dense(nodes, 3);
        points = random.dense(count, 3);
        for (int p = 0; p < count; ++p) {
            EmbeddedEnergy::Pull pull{p % 2, 0.5 + random.unit(), {}};
            for (int k = 0; k < 3; ++k)
                pull.shares.push_back({(p + 2 * k) % nodes, random.unit()});
            pulls.push_back(pull);
        }
        for (int h = 0; h < 2; ++h)
            motions.push_back({random.matrix(), random.vector()});
    }
    EmbeddedEnergy energy() const { return {edges, pulls, 2, weights, places, points}; }

    /// The sums of the paper, term by term, but for angles counted twice; weights of pulls here do not sum to
    /// 1, so that d_p is blended.
    double plain(const Points& x) const
    {
        double sum = 0.0;
        const auto U = [&](int j) -> Matrix3 { return x.middleRows<3>(4 * j).transpose(); };
        const auto t = [&](int j) -> Vector3 { return x.row(4 * j + 3).transpose(); };
        for (int j = 0; j < nodes; ++j) {
            const Matrix3 A = Matrix3::Identity() + U(j);
            for (int a = 0; a < 3; ++a)
                for (int b = 0; b < 3; ++b) {
                    const double departs = A.col(a).dot(A.col(b)) - (a == b ? 1.0 : 0.0);
                    sum += weights.rotation * departs * departs;
                }
        }
        for (const auto& [a, b] : edges)
            for (const auto& [j, k] : {std::array{a, b}, std::array{b, a}}) {
                const Vector3 g = places.row(j).transpose(), other = places.row(k).transpose();
                sum += weights.regularity *
                       ((other - g) + U(j) * (other - g) + g + t(j) - other - t(k)).squaredNorm();
            }
        for (int p = 0; p < count; ++p) {
            const Vector3 at = points.row(p).transpose();
            Vector3 apart = Vector3::Zero();
            for (const auto& share : pulls[p].shares)
                apart += share.weight * (U(share.map) * (at - places.row(share.map).transpose()) +
                                         t(share.map) - motions[pulls[p].handle](at));
            sum += weights.pulls * pulls[p].strength * apart.squaredNorm();
        }
        return sum;
    }
};

} // namespace

TEST(EmbeddedEnergy, is_the_sum_of_the_paper_and_its_gradient_that_of_differences)
{
    const Small small;
    const EmbeddedEnergy energy = small.energy();
    EmbeddedProblem problem(energy, energy.rest(), small.motions);
    shapes::Random random(9);
    const Points x = random.dense(4 * Small::nodes, 3);
    Points gradient;
    const double value = problem.evaluate(x, gradient);
    EXPECT_NEAR(value, small.plain(x), 1e-12 * value);
    Points other = x, unused;
    constexpr double step = 1e-5;
    for (Eigen::Index k = 0; k < x.size(); ++k) {
        other.data()[k] = x.data()[k] + step;
        const double above = small.plain(other);
        other.data()[k] = x.data()[k] - step;
        const double below = small.plain(other);
        other.data()[k] = x.data()[k];
        // Central differences of a quartic are wrong by step^2 of the third derivative, and by rounding /
        // step.
        EXPECT_NEAR(gradient.data()[k], (above - below) / (2 * step), 1e-7 * gradient.norm()) << k;
    }
}

TEST(EmbeddedEnergy, never_rises)
{
    const Small small;
    const EmbeddedEnergy energy = small.energy();
    double last = std::numeric_limits<double>::infinity();
    for (int steps = 1; steps < 30; ++steps) {
        EmbeddedProblem problem(energy, energy.rest(), small.motions);
        Points x = problem.start_without_rotations();
        const SolveReport report =
            minimize(problem, x, {.max_iterations = steps, .tolerance = 0.0, .plain_steps = 4});
        EXPECT_LE(report.energy, last) << steps;
        last = report.energy;
    }
}

TEST(EmbeddedEnergy, of_one_rigid_motion_is_nothing)
{
    Small small;
    for (auto& pull : small.pulls) { // shares that sum to 1
        double sum = 0.0;
        for (const auto& share : pull.shares)
            sum += share.weight;
        for (auto& share : pull.shares)
            share.weight /= sum;
    }
    const Matrix3 turn = shapes::rotation({1, 2, 3}, 170) - Matrix3::Identity();
    small.motions.assign(2, {turn, Vector3(1, -2, 3)});
    const EmbeddedEnergy energy = small.energy();
    EmbeddedProblem problem(energy, energy.rest(), small.motions);
    Points gradient;
    EXPECT_LT(problem.evaluate(problem.start(), gradient), 1e-24); // squares of rounding
}

} // namespace sinew::test_embedded_energy

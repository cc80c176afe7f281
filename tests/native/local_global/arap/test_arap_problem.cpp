// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/arap_problem.h"

#include "native/local_global/arap/multilevel_start.h"
#include "tests/native/differences.h"
#include "tests/native/local_global/arap/graphs.h"
#include "tests/native/shapes.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <cmath>

namespace sinew::test_arap_problem {

struct Variant
{
    double smoothness;
    bool rims, painted, soft;
};

const std::vector<Variant> variants{
    {0, false, false, false}, {0, true, false, false},     {0, false, true, false}, {0, true, true, false},
    {0, false, false, true},  {0.02, false, false, false}, {0.02, true, true, true}};

const Poses bent{shapes::still(), shapes::turn({1, 0, 0}, 30, {0, 0, 1}, {0.2, 0.4, 0.3})};

/// A sphere held by its poles, one of them softly on request; every angle is acute.
struct Setting
{
    SurfaceMesh mesh = shapes::sphere(2);
    ArapSystem graph;
    GraphGoals goals;

    explicit Setting(const Variant& variant)
        : graph(make(mesh, variant)), goals(graph, Targets{bent, view(mesh.points()), {}, nullptr})
    {
    }
    ArapProblem problem() const
    {
        return ArapProblem(graph, view(mesh.points()), goals.targets, goals.pulls);
    }

private:
    static ArapSystem make(SurfaceMesh& mesh, const Variant& variant)
    {
        std::vector<Handle> handles = graphs::poles(mesh);
        if (variant.soft)
            handles[1].weights.assign(handles[1].vertices.size(), 0.6);
        return graphs::of(mesh, handles, variant.smoothness, variant.rims, variant.painted);
    }
};

std::vector<Matrix3> rotations(const ArapProblem& problem, const ArapSystem& graph)
{
    std::vector<Matrix3> all;
    for (int i = 0; i < graph.size(); ++i)
        all.push_back(problem.rotation(i));
    return all;
}

/// F with rotations that no longer move.
double settled(ArapProblem& problem, const Points& x, Points& gradient)
{
    double F = problem.evaluate(x, gradient);
    for (int k = 0; k < 400; ++k) {
        const double next = problem.evaluate(x, gradient);
        EXPECT_LE(next, F * (1 + 1e-12)) << "settling raised it";
        if (next > F * (1 - 1e-15))
            break;
        F = next;
    }
    return F;
}

TEST(ArapProblem, its_gradient_is_that_of_differences_and_the_plain_step_never_raises_it)
{
    for (const Variant& variant : variants) {
        const Setting setting(variant);
        ArapProblem problem = setting.problem();
        Points x = shapes::Random(2).shaken(problem.free_rows(view(setting.mesh.points())), 0.1);
        Points gradient, unused, z;
        double before = settled(problem, x, gradient);
        const auto F = [&](const Points& there) {
            ArapProblem other = setting.problem();
            for (int i = 0; i < setting.graph.size(); ++i)
                other.set_rotation(i, problem.rotation(i));
            return settled(other, there, unused);
        };
        // Rounding: 1e-16 F / step = 1e-10; third derivatives: step^2 = 1e-10; with
        // smoothness the rotations settle to 1e-15 of F: 1e-9 / step.
        expect_gradient(F, x, gradient, 1e-5, variant.smoothness > 0 ? 1e-6 : 1e-8, 5);
        for (int k = 0; k < 20; ++k) {
            problem.precondition(gradient, z);
            x -= z;
            const double next = problem.evaluate(x, gradient);
            EXPECT_LE(next, before * (1 + 1e-14)) << "step " << k;
            before = next;
        }
    }
}

TEST(ArapProblem, a_rejected_step_brings_the_rotations_back)
{
    const Setting setting({0.02, false, false, false});
    ArapProblem problem = setting.problem();
    const Points x = problem.free_rows(view(setting.mesh.points()));
    Points gradient;
    problem.evaluate(x, gradient);
    const std::vector<Matrix3> before = rotations(problem, setting.graph);
    problem.keep_state();
    problem.evaluate(shapes::Random(6).shaken(x, 0.1), gradient);
    EXPECT_NE(rotations(problem, setting.graph), before);
    problem.restore_state();
    EXPECT_EQ(rotations(problem, setting.graph), before);
}

TEST(ArapProblem, motions_of_clusters_lower_the_energy_or_leave_all_as_it_was)
{
    for (const double smoothness : {0.0, 0.02}) {
        const Setting setting({smoothness, false, false, false});
        const HandleGraph& nodes = setting.graph.nodes();
        const Points& rest = setting.mesh.points();
        const RotationLevel level(nodes, setting.graph.cells(), rest, Clusters(nodes, rest, 20));
        const ClusterMotions motions(setting.graph, rest, level.map.label(), level.graph.nodes());
        ArapProblem problem = setting.problem();
        Points x = shapes::Random(2).shaken(problem.free_rows(view(rest)), 0.1), gradient;
        double F = settled(problem, x, gradient);
        const double F_before = F;
        const std::vector<Matrix3> before = rotations(problem, setting.graph);
        problem.improve_by(motions);

        Points to = x, uphill = -gradient;
        EXPECT_FALSE(problem.improve(to, uphill, F));
        problem.refresh(to);
        EXPECT_EQ(to, x);
        EXPECT_EQ(F, F_before);
        for (int i = 0; i < setting.graph.size(); ++i)
            EXPECT_LE((problem.rotation(i) - before[i]).norm(), smoothness > 0 ? 0.0 : 1e-7) << i;
        ASSERT_TRUE(problem.improve(to, gradient, F));
        EXPECT_LT(F, 0.9 * F_before);
        EXPECT_LE(problem.evaluate(to, gradient), F * (1 + 1e-12)) << "a fit raised it";
    }
}

TEST(ArapProblem, going_on_takes_points_and_rotations_along_unless_it_costs_all_that_was_gained)
{
    const Setting setting({0.02, false, false, false});
    ArapProblem problem = setting.problem();
    Points from = shapes::Random(2).shaken(problem.free_rows(view(setting.mesh.points())), 0.1), gradient, z;
    const double F_from = settled(problem, from, gradient);
    problem.keep_state();
    const std::vector<Matrix3> first = rotations(problem, setting.graph);
    problem.precondition(gradient, z);
    const Points to = from - 0.2 * z;
    Points x = to;
    double F = problem.evaluate(x, gradient);
    const std::vector<Matrix3> second = rotations(problem, setting.graph);
    const Points kept = gradient;

    EXPECT_FALSE(problem.go_on(from, F_from, 30.0, x, gradient, F)) << "much too far";
    EXPECT_EQ(x, to);
    EXPECT_EQ(gradient, kept);
    EXPECT_EQ(rotations(problem, setting.graph), second);

    ASSERT_TRUE(problem.go_on(from, F_from, 0.5, x, gradient, F));
    EXPECT_LT(F, F_from);
    EXPECT_LT(shapes::distance(x, Points(to + 0.5 * (to - from))), 1e-15);
    double most = 0.0;
    for (int i = 0; i < setting.graph.size(); ++i) {
        const Eigen::AngleAxisd turned(second[i] * first[i].transpose());
        const Matrix3 on = Eigen::AngleAxisd(0.5 * turned.angle(), turned.axis()) * second[i];
        EXPECT_LT((problem.rotation(i) - on).norm(), 0.2 * std::pow(turned.angle(), 3) + 1e-14) << i;
        most = std::max(most, turned.angle());
    }
    EXPECT_GT(most, 0.01);
}

} // namespace sinew::test_arap_problem

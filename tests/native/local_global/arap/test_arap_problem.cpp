// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/arap_problem.h"

#include "native/local_global/arap/multilevel_start.h"
#include "tests/native/differences.h"
#include "tests/native/local_global/arap/graphs.h"
#include "tests/native/shapes.h"

#include <Eigen/LU>

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
        std::vector<Handle> handles{{shapes::where(mesh, [](const Vector3& p) { return p.z() < -0.8; }), {}},
                                    {shapes::where(mesh, [](const Vector3& p) { return p.z() > 0.8; }), {}}};
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

void set_rotations(ArapProblem& problem, const std::vector<Matrix3>& rotations)
{
    for (std::size_t i = 0; i < rotations.size(); ++i)
        problem.set_rotation(static_cast<int>(i), rotations[i]);
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

TEST(ArapProblem, gradient_equals_finite_differences)
{
    for (const Variant& variant : variants) {
        const Setting setting(variant);
        ArapProblem problem = setting.problem();
        const Points x = shapes::Random(2).shaken(problem.free_rows(view(setting.mesh.points())), 0.1);
        Points gradient, unused;
        settled(problem, x, gradient);
        const auto F = [&](const Points& there) {
            ArapProblem other = setting.problem();
            set_rotations(other, rotations(problem, setting.graph));
            return settled(other, there, unused);
        };
        // Rounding: 1e-16 F / step = 1e-10; third derivatives: step^2 = 1e-10; with
        // smoothness the rotations settle to 1e-15 of F: 1e-9 / step.
        expect_gradient(F, x, gradient, 1e-5, variant.smoothness > 0 ? 1e-6 : 1e-8, 5);
    }
}

TEST(ArapProblem, the_plain_step_in_the_metric_never_raises_it)
{
    for (const Variant& variant : variants) {
        const Setting setting(variant);
        ArapProblem problem = setting.problem();
        Points x = shapes::Random(3).shaken(problem.free_rows(view(setting.mesh.points())), 0.1), gradient, z;
        double F = problem.evaluate(x, gradient);
        for (int k = 0; k < 20; ++k) {
            problem.precondition(gradient, z);
            x -= z;
            const double next = problem.evaluate(x, gradient);
            EXPECT_LE(next, F * (1 + 1e-14)) << "step " << k;
            F = next;
        }
    }
}

TEST(ArapProblem, the_global_step_is_stationary)
{
    for (const Variant& variant : variants) {
        if (variant.smoothness > 0)
            continue; // evaluate() turns the rotations on
        const Setting setting(variant);
        ArapProblem problem = setting.problem();
        shapes::Random random(4);
        for (int i = 0; i < setting.graph.size(); ++i)
            problem.set_rotation(i, random.rotation());
        const Matrix3 given = problem.rotation(5);
        const Points x = problem.global_step();
        // The solution solves: asking again from there changes nothing.
        EXPECT_LT(shapes::distance(problem.global_step(), x), 1e-11);
        EXPECT_EQ(problem.rotation(5), given);
    }
}

TEST(ArapProblem, rotations_stay_rotations_on_turned_over_cells)
{
    for (const Variant& variant : variants) {
        const Setting setting(variant);
        ArapProblem problem = setting.problem();
        Points x = problem.free_rows(view(setting.mesh.points()));
        x.col(0) *= -1; // every free cell is mirrored
        Points gradient;
        for (int k = 0; k < 10; ++k) {
            problem.evaluate(x, gradient);
            for (const Matrix3& R : rotations(problem, setting.graph)) {
                EXPECT_NEAR(R.determinant(), 1.0, 1e-12);
                EXPECT_LT((R * R.transpose() - Matrix3::Identity()).norm(), 1e-12);
            }
        }
        EXPECT_TRUE(gradient.allFinite());
    }
}

TEST(ArapProblem, a_rigid_motion_costs_nothing)
{
    for (const Variant& variant : variants) {
        const Setting setting(variant);
        const Pose pose = shapes::turn({1, 2, 3}, 130, {1, 0, 0}, {3, 4, 5});
        const GraphGoals goals(setting.graph,
                               Targets{{pose, pose}, view(setting.mesh.points()), {}, nullptr});
        ArapProblem problem(setting.graph, view(setting.mesh.points()), goals.targets, goals.pulls);
        set_rotations(problem, std::vector<Matrix3>(setting.graph.size(), pose.leftCols<3>()));
        Points gradient;
        const Points moved = shapes::transformed(setting.mesh.points(), pose);
        EXPECT_LT(problem.evaluate(problem.free_rows(view(moved)), gradient),
                  1e-25); // squares of rounding at size 8
        EXPECT_LT(gradient.cwiseAbs().maxCoeff(), 1e-12);
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

} // namespace sinew::test_arap_problem

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "tests/native/methods/surface/calls.h"
#include "tests/native/refusals.h"

namespace sinew {

/// The tests of one surface method. The fixture has the name of the method, which is `Method` in the tests:
///
///     class Arap : public SurfaceFixture<sinew::Arap, ArapOptions> {};
template <class M, class O>
class SurfaceFixture : public testing::Test
{
public:
    using Method = M;
    using Options = O;
    struct Solution
    {
        Points positions;
        SolveReport report;
    };

    static auto maker(const Options& options = {})
    {
        return [options](const SurfaceMesh& mesh) { return std::make_shared<Method>(mesh, options); };
    }
    static Method bound(const SurfaceMesh& mesh, const Options& options, const std::vector<Handle>& handles)
    {
        Method method(mesh, options);
        method.set_handles(handles);
        return method;
    }
    static Solution solve(const SurfaceMethod& method, const Poses& poses, SolveRequest request = {})
    {
        Solution solution;
        request.poses = poses;
        solution.report = method.solve(request, solution.positions);
        return solution;
    }
    static Points solved(const SurfaceMesh& mesh, const std::vector<Handle>& handles,
                         const SolveRequest& request, const Options& options = {},
                         SolveReport* report = nullptr)
    {
        Points positions;
        const SolveReport found = bound(mesh, options, handles).solve(request, positions);
        if (report)
            *report = found;
        return positions;
    }
    /// What a frame on the multigrid promises beside its shape, and binds from one solver to the other.
    static void on_the_multigrid(const Options& factor, const Options& multigrid)
    {
        const SurfaceMesh mesh = shapes::hill(90, 80);
        const std::vector<Handle> handles = shapes::ends(mesh, 3);
        const Poses moved{shapes::turn({0, 1, 0}, 40), shapes::shift(1, -2, 30)};
        Method exact = bound(mesh, factor, handles), method(mesh, multigrid), back(mesh, factor);
        const Solution truth = solve(exact, moved);
        double reached = 0.0;
        method.rebind(exact, handles, Progress([&](double share, const char*) {
                          EXPECT_GE(share, reached);
                          reached = share;
                          return true;
                      }));
        EXPECT_EQ(reached, 1.0);
        const Solution first = solve(method, moved);
        EXPECT_NEAR(first.report.energy, truth.report.energy, 1e-3 * truth.report.energy);
        for (const int stop : {1, 20, 30}) {
            int ticks = 0;
            const Progress stops([&](double, const char*) { return ++ticks < stop; });
            EXPECT_THROW(solve(method, moved, {.progress = stops}), Cancelled);
            EXPECT_EQ(ticks, stop);
        }
        EXPECT_EQ(solve(method, moved).positions, first.positions);
        const Solution again = solve(method, moved, {.start = view(first.positions)});
        EXPECT_NEAR(again.report.energy, first.report.energy, 1e-4 * first.report.energy);
        back.rebind(method, handles);
        const int by_factor = solve(back, moved, {.start = view(first.positions)}).report.iterations;
        EXPECT_LE(again.report.iterations, std::max(first.report.iterations / 2, by_factor));
        EXPECT_LT(shapes::distance(solve(back, moved).positions, truth.positions), 1e-9);
    }
    static SurfaceTraits linear(const std::string& name, const std::vector<SurfaceVariant>& variants)
    {
        return {.name = name,
                .variants = variants,
                .mesh = shapes::hill(8, 8),
                .large = shapes::hill(10, 9),
                .depth = 1.5,
                .bent = bent,
                .drag =
                    [](double t) {
                        const double angle = 2 * shapes::pi * t;
                        return Poses{shapes::still(),
                                     shapes::turn({0, 1, 0}, 60 * std::sin(angle), {9, 4, 0},
                                                  {2 * std::cos(angle) - 2, std::sin(angle), 0})};
                    },
                .drag_steps = 48,
                .follow = 2.0, // where the surface bends outwards, it goes farther than the handle
                .slack = 0.0,
                .many = shapes::hill(60, 60)};
    }
    static SurfaceTraits nonlinear(const std::string& name, const std::vector<SurfaceVariant>& variants,
                                   double degrees = 100)
    {
        return {.name = name,
                .variants = variants,
                .mesh = shapes::bar(12, 3),
                .large = shapes::bar(20, 5), // for a hierarchy of more than one level
                .depth = 2,
                .bent = calls::bend(60),
                .drag =
                    [degrees](double s) {
                        const double t = 0.5 - 0.5 * std::cos(2 * shapes::pi * s);
                        return Poses{shapes::still(),
                                     shapes::turn({0.2, 1, 0.5}, degrees * t, {18, 0, 0},
                                                  {-4 * t, 3 * t, 2 * std::sin(2 * shapes::pi * s)})};
                    },
                .drag_steps = 30,
                .follow = 1.5, // the surface between two handles follows the faster one;
                .slack = 0.02, // a buckle would jump by its size
                .rest = 1e-12, // one linear solve of condition 1e3 for positions of size 12
                .incoming = 1e-11, // edges are taken from what enters: nothing is strained
                .noise = 0.2,
                .translation = 1e-9,
                .rigid = 1e-11, // rounding of a solve at size 40
                .held = 2e-13,
                .alone = 1e-13,
                .similar = 0.01, // rounding may change the iteration at which it stops
                .apart = 0.05,
                .messy = 30.0,
                .all_soft = 1.0};
    }

    inline static const Poses bent{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};
    static constexpr double nan = std::numeric_limits<double>::quiet_NaN();
    static constexpr double infinity = std::numeric_limits<double>::infinity();
};

} // namespace sinew

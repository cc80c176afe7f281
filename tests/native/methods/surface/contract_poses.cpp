// SPDX-License-Identifier: GPL-3.0-or-later
// What every surface method makes of poses, frames of reference, starts and iterations.
#include "tests/native/methods/surface/calls.h"

#include "tests/native/allocations.h"

namespace sinew::contract_poses {

namespace {

using calls::bound, calls::Method, calls::softened, calls::solve;

/// The poses as they are where everything is moved by a rigid motion.
Poses seen_from(const Pose& motion, const Poses& poses)
{
    const Matrix3 R = motion.leftCols<3>();
    Poses seen;
    for (const Pose& pose : poses) {
        const Matrix3 A = R * pose.leftCols<3>() * R.transpose();
        seen.push_back(shapes::affine(A, R * pose.col(3) + motion.col(3) - A * motion.col(3)));
    }
    return seen;
}

} // namespace

TEST_P(SurfaceContract, turns_with_the_coordinate_system)
{
    const Pose motion = shapes::turn({1, 2, 3}, 70, {0, 0, 0}, {5, -1, 2});
    const SurfaceVariant& variant = traits().variants.front();
    const SurfaceMesh elsewhere = shapes::moved(mesh(), shapes::transformed(mesh().points(), motion));
    const Points there = solve(*bound(variant, elsewhere, ends()), seen_from(motion, traits().bent));
    const Points here = solve(*bound(variant, mesh(), ends()), traits().bent);
    EXPECT_LT(shapes::distance(there, shapes::transformed(here, motion)), traits().similar);
}

TEST_P(SurfaceContract, turns_with_a_rigid_incoming_pose)
{
    if (!traits().turns_incoming)
        GTEST_SKIP() << "not asked of this method";
    const Pose motion = shapes::turn({1, 2, -0.5}, 120, {3, 7, 1}, {3, -2, 1});
    const Points incoming = shapes::transformed(mesh().points(), motion);
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, mesh(), ends());
        const Points q = solve(*method, seen_from(motion, traits().bent), {.incoming = view(incoming)});
        EXPECT_LT(shapes::distance(q, shapes::transformed(solve(*method, traits().bent), motion)),
                  traits().similar);
    }
}

TEST_P(SurfaceContract, a_handle_that_moves_with_the_incoming_shape_does_not_turn_it_twice)
{
    if (traits().rides == 0)
        GTEST_SKIP() << "not asked of this method";
    const Pose pose = shapes::turn({1, 2, -0.5}, 120, {3, 7, 1}, {3, -2, 1});
    const Points incoming = shapes::transformed(mesh().points(), pose);
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        EXPECT_LT(
            shapes::distance(solve(*bound(variant, mesh(), ends()), {shapes::still(), pose},
                                   {.incoming = view(incoming), .from_rest = std::vector<bool>{false, true}}),
                             incoming),
            traits().rides);
    }
}

TEST_P(SurfaceContract, one_affine_map_of_all_handles_is_exact_where_it_is_reproduced)
{
    Matrix3 A;
    A << 1.2, 0.3, 0, -0.4, 0.8, 0.1, 0.5, 0.2, -2; // it reflects
    const Pose pose = shapes::affine(A, {1, 2, 3});
    const Points expected = shapes::transformed(mesh().points(), pose);
    for (const SurfaceVariant& variant : traits().variants) {
        if (variant.affine == 0)
            continue;
        SCOPED_TRACE(variant.name);
        for (double weight : {1.0, 0.3}) {
            std::vector<Handle> handles = softened(ends(), weight);
            handles.push_back({{mesh().vertex_count() / 2}, {}});
            EXPECT_LT(shapes::distance(solve(*bound(variant, mesh(), handles), Poses(3, pose)), expected),
                      variant.affine);
        }
    }
}

TEST_P(SurfaceContract, says_where_a_rule_chose_the_way_of_half_a_turn)
{
    if (traits().half_turns == 0)
        GTEST_SKIP() << "no turns are interpolated";
    const SurfaceMesh both = shapes::joined(mesh(), shapes::sphere(1), {0, 20, 0});
    std::vector<Handle> handles = ends();
    handles.push_back({{mesh().vertex_count()}, {}}); // alone in its part
    for (const SurfaceVariant& variant : traits().variants)
        for (const auto& [degrees, count] : {std::pair{179.0, 0}, {180.0, traits().half_turns}}) {
            Points q;
            EXPECT_EQ(bound(variant, both, handles)
                          ->solve({{shapes::still(), shapes::turn({1, 2, 0}, degrees), shapes::still()}}, q)
                          .half_turns,
                      count)
                << variant.name << ", " << degrees;
        }
}

TEST_P(SurfaceContract, handles_of_other_parts_do_not_count)
{
    if (!traits().parts_apart)
        GTEST_SKIP() << "not asked of this method";
    const SurfaceMesh both = shapes::joined(mesh(), mesh(), {0, 20, 0});
    const int n = mesh().vertex_count();
    std::vector<Handle> more = ends();
    more.push_back({{n + 3, n + n / 2}, {}});
    more.push_back({{n + 4 * n / 5}, {}});
    Poses poses = traits().bent;
    poses.push_back(shapes::turn({1, 0, 1}, 140));
    poses.push_back(shapes::turn({0, 1, 1}, -150));
    for (const SurfaceVariant& variant : traits().variants)
        if (variant.separate) {
            EXPECT_LT(shapes::distance(solve(*bound(variant, both, more), poses).topRows(n),
                                       solve(*bound(variant, mesh(), ends()), traits().bent)),
                      traits().apart)
                << variant.name;
        }
}

TEST_P(SurfaceContract, energy_never_rises_along_the_iterations)
{
    if (!traits().iterative)
        GTEST_SKIP() << "there are no iterations";
    const double along = mesh().points().col(0).maxCoeff();
    const std::vector<Poses> targets{
        calls::bend(120, along, traits().depth), calls::twist(135),
        Poses{shapes::still(), shapes::shift(-6, 8, 0)},
        Poses{shapes::still(), shapes::turn({1, 0.5, 1}, 120, {11, 0, 0}, {-4, 5, 3})}};
    for (const SurfaceVariant& variant : traits().variants)
        for (double weight : {1.0, 0.9}) {
            const Method method = bound(variant, mesh(), softened(ends(), weight));
            for (const Poses& poses : targets) {
                SCOPED_TRACE(variant.name);
                calls::expect_falling_energy(*method, poses);
            }
        }
}

TEST_P(SurfaceContract, unrelated_starts_meet)
{
    if (traits().settles == 0)
        GTEST_SKIP() << "one shape for all starts is not promised";
    for (int k = 0; k < traits().settling; ++k) {
        SCOPED_TRACE(traits().variants[k].name);
        calls::expect_starts_meet(
            *bound(traits().variants[k], traits().large, shapes::ends(traits().large, traits().depth)),
            traits().depth, traits().settles);
    }
}

TEST_P(SurfaceContract, solves_after_the_first_allocate_nothing_in_proportion_to_the_mesh)
{
    if (!allocations::counted() || !traits().many)
        GTEST_SKIP() << "nobody counts here";
    const SurfaceMesh& many = *traits().many;
    const Points incoming = shapes::transformed(many.points(), shapes::shift(1, 2, 3));
    for (const SurfaceVariant& variant : traits().variants)
        for (const bool soft : {false, true})
            for (const bool enters : {false, true}) {
                if ((soft && !traits().many_soft) || (enters && !traits().many_enter) ||
                    std::ranges::count(traits().allocates, variant.name))
                    continue;
                SCOPED_TRACE(variant.name);
                const Method method = variant.make(many);
                SolveRequest request{.poses = traits().bent};
                if (enters)
                    request.incoming.emplace(view(incoming));
                Points positions;
                const allocations::Count count(sizeof(double) * many.vertex_count());
                method->set_handles(softened(shapes::ends(many, traits().depth), soft ? 0.5 : 1.0));
                method->solve(request, positions);
                const int first = count.so_far();
                EXPECT_GT(first, 0);
                for (int k = 0; k < 3; ++k)
                    method->solve(request, positions);
                EXPECT_EQ(count.so_far(), first);
            }
}

} // namespace sinew::contract_poses

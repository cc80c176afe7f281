// SPDX-License-Identifier: GPL-3.0-or-later
// What every surface method does where it is bound again, or by several threads.
#include "tests/native/methods/surface/calls.h"

#include "tests/native/threads.h"

namespace sinew::contract_binds {

namespace {

using calls::bound, calls::Method, calls::solve;

const Progress never([](double, const char*) { return false; });

} // namespace

TEST_P(SurfaceContract, solves_from_several_threads_give_the_same_bits)
{
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, traits().large, shapes::ends(traits().large, traits().depth));
        const Points alone = solve(*method, traits().bent);
        expect_in_threads(3, 5, [&] { return solve(*method, traits().bent); }, alone);
    }
}

TEST_P(SurfaceContract, binds_and_solves_from_several_threads_take_turns)
{
    const std::vector<Handle> few = shapes::ends(traits().large, traits().depth),
                              more = shapes::ends(traits().large, traits().depth + 1);
    const SurfaceVariant& variant = traits().variants.front();
    const Points of_few = solve(*bound(variant, traits().large, few), traits().bent),
                 of_more = solve(*bound(variant, traits().large, more), traits().bent);
    const Method one = bound(variant, traits().large, few), other = bound(variant, traits().large, few);
    std::vector<int> wrong(4, 0);
    in_threads(4, [&](int t) {
        for (int k = 0; k < 8; ++k) {
            if (t == 0)
                one->set_handles(k % 2 ? few : more);
            else if (t == 1)
                (k % 2 ? one : other)->rebind(k % 2 ? *other : *one, k % 3 ? few : more);
            else
                try { // the former object of a rebind has no handles
                    const Points q = solve(k % 2 ? *one : *other, traits().bent);
                    wrong[t] += shapes::distance(q, of_few) > traits().similar &&
                                shapes::distance(q, of_more) > traits().similar;
                } catch (const InvalidConstraint&) {
                }
        }
    });
    EXPECT_EQ(wrong, std::vector<int>(4, 0));
}

TEST_P(SurfaceContract, a_callback_cannot_wait_for_its_own_call)
{
    const Method method = bound(traits().variants.front(), mesh(), ends());
    const Points before = solve(*method, traits().bent);
    const Progress solves([&](double, const char*) { return solve(*method, traits().bent).rows() > 0; });
    const Progress binds([&](double, const char*) { return method->set_handles(ends()).handle_count > 0; });
    for (const Progress& callback : {solves, binds})
        EXPECT_THROW(method->set_handles(ends(), callback), ObjectInUse);
    EXPECT_EQ(solve(*method, traits().bent), before);
    Points q;
    method->solve({.poses = traits().bent, .progress = solves}, q);
    EXPECT_EQ(q, before);
}

TEST_P(SurfaceContract, rebind_keeps_what_is_the_same)
{
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method former = bound(variant, mesh(), ends()), next = variant.make(mesh());
        const Points before = solve(*former, traits().bent);
        EXPECT_TRUE(next->can_reuse(*former));
        EXPECT_EQ(next->differences(*former), std::vector<std::string>{});
        EXPECT_THROW(next->rebind(*former, ends(), never), Cancelled);
        EXPECT_THROW(next->rebind(*former, {{{}, {}}}), InvalidConstraint);
        EXPECT_EQ(solve(*former, traits().bent), before);
        const BindReport report = next->rebind(*former, ends());
        EXPECT_EQ(report.reuse, Reuse::kept);
        EXPECT_EQ(report.changed, "");
        EXPECT_EQ(report.factorizations, variant.factorizations);
        EXPECT_EQ(solve(*next, traits().bent), before);
        EXPECT_EQ(solve(*former, {}), mesh().points()) << "it has no handles any more";
        EXPECT_FALSE(variant.make(mesh())->can_reuse(*former));
    }
}

TEST_P(SurfaceContract, rebind_to_other_handles_gives_what_a_new_object_gives)
{
    std::vector<Handle> more = ends();
    more.push_back({{mesh().vertex_count() / 2}, {}});
    Poses poses = traits().bent;
    poses.push_back(shapes::shift(0, 0, 1));
    for (const SurfaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method former = bound(variant, mesh(), ends()), next = variant.make(mesh());
        const BindReport report = next->rebind(*former, more);
        EXPECT_EQ(report.reuse, Reuse::updated);
        EXPECT_EQ(report.changed, "handles");
        EXPECT_LT(shapes::distance(solve(*next, poses), solve(*bound(variant, mesh(), more), poses)),
                  traits().similar);
    }
}

TEST_P(SurfaceContract, rebind_says_what_differs_and_leaves_alone_what_serves_nothing)
{
    const SurfaceVariant& variant = traits().variants.front();
    const Method former = bound(variant, mesh(), ends());
    const Points before = solve(*former, traits().bent);
    const auto anew = [&](const Method& next, const std::string& changed) {
        EXPECT_FALSE(next->can_reuse(*former));
        EXPECT_EQ(next->differences(*former), std::vector{changed});
        const BindReport report = next->rebind(*former, ends());
        EXPECT_EQ(report.reuse, Reuse::anew);
        EXPECT_EQ(report.changed, changed);
        EXPECT_EQ(solve(*former, traits().bent), before);
    };
    Points elsewhere = mesh().points();
    elsewhere(0, 0) += 1e-9;
    anew(variant.make(shapes::moved(mesh(), elsewhere)), "rest shape");
    shapes::Polygons fewer = shapes::faces_of(mesh());
    fewer.pop_back();
    anew(variant.make(shapes::over(mesh().points(), fewer)), "rest shape");
    if (traits().other) {
        EXPECT_FALSE(traits().other(mesh())->can_reuse(*former));
    }
    if (traits().updated) {
        const Method next = traits().updated(mesh()), fresh = traits().updated(mesh());
        EXPECT_EQ(next->differences(*former), std::vector{traits().updates});
        const BindReport report = next->rebind(*former, ends());
        EXPECT_EQ(report.reuse, Reuse::updated);
        EXPECT_EQ(report.changed, traits().updates);
        fresh->set_handles(ends());
        EXPECT_LT(shapes::distance(solve(*next, traits().bent), solve(*fresh, traits().bent)),
                  traits().similar);
    }
}

} // namespace sinew::contract_binds

// SPDX-License-Identifier: GPL-3.0-or-later
#include "tests/native/methods/space/contract.h"

#include "tests/native/refusals.h"
#include "tests/native/threads.h"

#include <cmath>
#include <limits>

namespace sinew::space_contract {

namespace {

using Method = std::shared_ptr<SpaceMethod>;
constexpr double nan = std::numeric_limits<double>::quiet_NaN();

Method bound(const SpaceVariant& variant, const Points& points)
{
    Method method = variant.make();
    method->bind(view(points));
    return method;
}

Points warped(const SpaceMethod& method, const Points& control,
              const std::optional<PointsView>& incoming = {})
{
    Points out(method.points().rows(), 3);
    method.warp(view(control), incoming, out.data());
    return out;
}

Points moved(const SpaceTraits& traits)
{
    return shapes::Random(5).shaken(traits.control, 0.1 * shapes::size(traits.control));
}

} // namespace

GTEST_ALLOW_UNINSTANTIATED_PARAMETERIZED_TEST(SpaceContract);

TEST_P(SpaceContract, rest_in_rest_out_to_the_last_bit)
{
    for (const SpaceVariant& variant : traits().variants)
        EXPECT_EQ(warped(*bound(variant, traits().points), traits().control), traits().points)
            << variant.name;
}

TEST_P(SpaceContract, reproduces_the_maps_that_it_declares)
{
    const double size = shapes::size(traits().control);
    Matrix3 shear;
    shear << 1.2, 0.3, 0, -0.4, 0.8, 0.1, 0.5, 0.2, 2;
    struct Map
    {
        Pose pose;
        std::optional<double> tolerance;
    };
    const std::vector<Map> maps{
        {shapes::shift(1, 2, 3), traits().translation},
        {shapes::affine(2.5 * shapes::rotation({1, 2, -1}, 130), {3, -1, 2}), traits().similarity},
        {shapes::affine(shear, {1, -2, 3}), traits().affine}};
    for (const SpaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, traits().points);
        for (const auto& [pose, tolerance] : maps)
            if (tolerance) {
                EXPECT_LT(shapes::distance(warped(*method, shapes::transformed(traits().control, pose)),
                                           shapes::transformed(traits().points, pose)),
                          *tolerance * size);
            }
    }
}

TEST_P(SpaceContract, displacements_are_added_to_what_enters)
{
    const Points entering =
        shapes::transformed(traits().points, shapes::turn({1, 2, 0}, 30, {0, 0, 0}, {1, 2, 3}));
    const Points control = moved(traits());
    for (const SpaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, traits().points);
        EXPECT_EQ(warped(*method, traits().control, view(entering)), entering);
        EXPECT_EQ(warped(*method, control, view(traits().points)), warped(*method, control));
        if (const std::optional<double> tolerance = traits().deforms_what_enters) {
            const Pose rigid = shapes::turn({2, 1, -1}, 170, {1, 0, 0}, {0, 1, 0});
            EXPECT_LT(shapes::distance(
                          warped(*method, shapes::transformed(traits().control, rigid), view(entering)),
                          shapes::transformed(entering, rigid)),
                      *tolerance * shapes::size(entering));
            continue;
        }
        EXPECT_LT(shapes::distance(warped(*method, control, view(entering)) - entering,
                                   warped(*method, control) - traits().points),
                  1e-14 * shapes::size(entering));
    }
}

TEST_P(SpaceContract, single_precision_is_the_rounded_answer)
{
    const Points control = moved(traits());
    for (const SpaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, traits().points);
        std::vector<float> out(static_cast<std::size_t>(traits().points.size()));
        method->warp(view(control), {}, out.data());
        const Points expected = warped(*method, control);
        for (Eigen::Index k = 0; k < expected.size(); ++k)
            ASSERT_EQ(out[static_cast<std::size_t>(k)], static_cast<float>(expected.data()[k]));
    }
}

TEST_P(SpaceContract, a_closed_drag_returns_to_the_same_bits_without_a_jump)
{
    constexpr int steps = 60;
    const double radius = 0.3 * shapes::size(traits().control);
    const Eigen::Index last_row = traits().control.rows() - 1;
    for (const SpaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = bound(variant, traits().points);
        const Points first = warped(*method, traits().control);
        Points last = first, control = traits().control;
        for (int k = 1; k <= steps; ++k) {
            const double angle = 2 * shapes::pi * (k % steps) / steps;
            const Eigen::RowVector3d before = control.row(last_row);
            control.row(last_row) =
                traits().control.row(last_row) +
                radius * Eigen::RowVector3d(std::cos(angle) - 1, std::sin(angle), 0.5 * std::sin(2 * angle));
            const Points now = warped(*method, control);
            EXPECT_LT(shapes::distance(now, last), traits().follow * (control.row(last_row) - before).norm())
                << "step " << k;
            last = now;
        }
        EXPECT_EQ(last, first);
    }
}

TEST_P(SpaceContract, binds_any_number_of_points)
{
    const Points control = moved(traits());
    for (const SpaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Points all = warped(*bound(variant, traits().points), control);
        for (const int count : {0, 1, 63, 64, 65}) {
            const Points points = traits().points.topRows(count);
            const Method method = variant.make();
            const SpaceReport report = method->bind(view(points));
            EXPECT_EQ(report.point_count, count);
            EXPECT_EQ(report.reuse, Reuse::anew);
            EXPECT_EQ(warped(*method, traits().control), points);
            EXPECT_EQ(warped(*method, control), all.topRows(count));
        }
    }
}

TEST_P(SpaceContract, a_point_is_bound_the_same_in_any_company)
{
    const Points control = moved(traits()), some = traits().points.middleRows(3, 150);
    for (const SpaceVariant& variant : traits().variants)
        EXPECT_EQ(warped(*bound(variant, some), control),
                  warped(*bound(variant, traits().points), control).middleRows(3, 150))
            << variant.name;
}

TEST_P(SpaceContract, names_points_that_are_not_finite)
{
    Points points = traits().points;
    points(1, 2) = nan;
    points(3, 0) = std::numeric_limits<double>::infinity();
    for (const SpaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method binds = variant.make(), warps = bound(variant, traits().points);
        for (const auto& call : std::vector<std::function<void()>>{
                 [&] { binds->bind(view(points)); }, [&] { warped(*warps, traits().control, view(points)); }})
            expect_elements(refusal<InvalidConstraint>(call), Error::Element::vertex, {1, 3});
    }
}

TEST_P(SpaceContract, names_points_outside)
{
    if (!traits().outside)
        GTEST_SKIP() << "nothing lies outside";
    const Points inside = traits().points.topRows(3), control = moved(traits());
    Points points = inside;
    points.row(1) = traits().outside->transpose();
    for (const SpaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method method = variant.make();
        if (!traits().refuses_outside) {
            EXPECT_EQ(method->bind(view(points)).outside, std::vector{1});
            continue;
        }
        const auto bind = [&] { method->bind(view(points)); };
        expect_elements(refusal<InvalidConstraint>(bind), Error::Element::vertex, {1});
        EXPECT_THROW(warped(*method, traits().control), InvalidConstraint) << "it binds nothing";
        method->bind(view(inside));
        const Points before = warped(*method, control);
        EXPECT_THROW(bind(), InvalidConstraint);
        EXPECT_EQ(warped(*method, control), before) << "the last bind stays";
    }
}

TEST_P(SpaceContract, refuses_what_does_not_fit_a_warp)
{
    const Points points = traits().points.topRows(5);
    for (const SpaceVariant& variant : traits().variants) {
        const Method method = variant.make();
        const Points untouched = Points::Constant(5, 3, 7.0);
        Points out = untouched;
        const auto refused = [&](const Points& control, const std::optional<PointsView>& incoming = {}) {
            EXPECT_THROW(method->warp(view(control), incoming, out.data()), InvalidConstraint)
                << variant.name;
            EXPECT_EQ(out, untouched) << "nothing was written";
        };
        refused(traits().control); // before bind()
        method->bind(view(points));
        refused(traits().control.topRows(traits().control.rows() - 1));
        Points broken = traits().control;
        broken(2, 2) = std::numeric_limits<double>::infinity();
        refused(broken);
        const Points four = points.topRows(4);
        refused(traits().control, view(four));
    }
}

TEST_P(SpaceContract, a_cancelled_bind_changes_nothing_and_progress_never_falls)
{
    const Points control = moved(traits()), few = traits().points.topRows(20);
    for (const SpaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        int all = 0;
        double last = 0.0;
        bound(variant, few)->bind(view(traits().points), Progress([&](double fraction, const char* stage) {
                                      EXPECT_GE(fraction, last);
                                      EXPECT_LE(fraction, 1.0);
                                      EXPECT_STRNE(stage, "");
                                      last = fraction;
                                      ++all;
                                      return true;
                                  }));
        EXPECT_EQ(last, 1.0);
        EXPECT_GE(all, 2);
        const Method method = bound(variant, few), unbound = variant.make();
        const Points before = warped(*method, control);
        for (int stop : {1, 2, 3, all - 1, all}) {
            int ticks = 0;
            // A busy machine makes other ticks of the same work, but the last one says that all is done.
            const Progress stops([&](double done, const char*) { return ++ticks < stop && done < 1.0; });
            EXPECT_THROW(method->bind(view(traits().points), stops), Cancelled);
            EXPECT_EQ(warped(*method, control), before) << "cancelled at tick " << stop;
        }
        EXPECT_THROW(unbound->bind(view(few), Progress([](double, const char*) { return false; })),
                     Cancelled);
        EXPECT_THROW(warped(*unbound, control), InvalidConstraint) << "it binds nothing";
    }
}

TEST_P(SpaceContract, any_number_of_threads_gives_the_same_bits)
{
    const Points control = moved(traits());
    for (const SpaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method many = bound(variant, traits().points);
        const Points alone = warped(*many, control);
        for (const int threads : {1, 5}) {
            const ThreadLimit limit(threads);
            EXPECT_EQ(warped(*bound(variant, traits().points), control), alone) << threads << " threads";
        }
        expect_in_threads(3, 5, [&] { return warped(*many, control); }, alone);
    }
}

TEST_P(SpaceContract, binds_and_warps_from_several_threads_take_turns)
{
    const Points control = moved(traits()), fewer = traits().points.topRows(60);
    for (const SpaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Points all = warped(*bound(variant, traits().points), control);
        const Method one = bound(variant, fewer), other = bound(variant, fewer);
        std::vector<int> wrong(4, 0);
        in_threads(4, [&](int t) {
            for (int k = 0; k < 6; ++k) {
                if (t == 0)
                    one->bind(view(fewer));
                else if (t == 1)
                    (k % 2 ? one : other)
                        ->rebind(k % 2 ? *other : *one, view(k % 3 ? fewer : traits().points));
                else
                    try { // the former object of a rebind has no points, and others have more of them
                        Points out(fewer.rows(), 3);
                        (k % 2 ? one : other)->warp(view(control), {}, out.data(), out.rows());
                        wrong[t] += out != all.topRows(fewer.rows());
                    } catch (const InvalidConstraint&) {
                    }
            }
        });
        EXPECT_EQ(wrong, std::vector<int>(4, 0));
    }
}

TEST_P(SpaceContract, a_callback_cannot_wait_for_its_own_call)
{
    const Method method = bound(traits().variants.front(), traits().points);
    const Points control = moved(traits()), before = warped(*method, control);
    const Progress warps([&](double, const char*) { return warped(*method, control).rows() > 0; });
    const Progress binds(
        [&](double, const char*) { return method->bind(view(traits().points)).point_count > 0; });
    for (const Progress& callback : {warps, binds})
        EXPECT_THROW(method->bind(view(traits().points), callback), ObjectInUse);
    EXPECT_EQ(warped(*method, control), before);
}

TEST_P(SpaceContract, rebind_takes_over_what_is_the_same)
{
    const Points control = moved(traits()), fewer = traits().points.topRows(20);
    const Progress never([](double, const char*) { return false; });
    for (const SpaceVariant& variant : traits().variants) {
        SCOPED_TRACE(variant.name);
        const Method former = bound(variant, traits().points), next = variant.make();
        const Points before = warped(*former, control);
        EXPECT_TRUE(next->can_reuse(*former, view(traits().points)));
        EXPECT_FALSE(next->can_reuse(*former, view(fewer)));
        EXPECT_THROW(next->rebind(*former, view(traits().points), never), Cancelled);
        SpaceReport report = variant.make()->rebind(*former, view(fewer));
        EXPECT_EQ(report.reuse, Reuse::anew);
        EXPECT_EQ(report.changed, "points");
        EXPECT_EQ(warped(*former, control), before) << "nothing of it served";
        report = next->rebind(*former, view(traits().points));
        EXPECT_EQ(report.reuse, Reuse::kept);
        EXPECT_EQ(report.changed, "");
        EXPECT_EQ(warped(*next, control), before);
        EXPECT_THROW(warped(*former, control), InvalidConstraint) << "no points are bound to it any more";
        EXPECT_FALSE(variant.make()->can_reuse(*former, view(traits().points)));
        if (traits().other) {
            EXPECT_FALSE(traits().other()->can_reuse(*next, view(traits().points)));
        }
    }
}

} // namespace sinew::space_contract

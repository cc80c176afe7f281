// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/cage_coordinates.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "tests/native/space/cage/cages.h"

#include <gtest/gtest.h>

#include <atomic>
#include <limits>

namespace sinew {

namespace {

/// Weights of 1 / distance, normalised; counts what the base class asks for.
class Counted : public CageCoordinates
{
public:
    explicit Counted(const CageWeightOptions& options = {}) : CageCoordinates(Cage(shapes::cube()), options)
    {
    }
    mutable std::atomic<int> evaluated = 0;

protected:
    void evaluate(int, PointsView block, RowMatrix& rows, std::vector<char>& outside) const override
    {
        evaluated += static_cast<int>(block.rows());
        rows.resize(block.rows(), columns());
        outside.assign(static_cast<std::size_t>(block.rows()), 0);
        for (Eigen::Index i = 0; i < block.rows(); ++i) {
            for (int v = 0; v < columns(); ++v)
                rows(i, v) = 1.0 / (0.1 + (block.row(i) - cage().rest().points().row(v)).norm());
            rows.row(i) /= rows.row(i).sum();
            outside[static_cast<std::size_t>(i)] = block(i, 0) > 1.0;
        }
    }
};

} // namespace

TEST(CageCoordinates, rest_in_rest_out_to_the_last_bit)
{
    const Points points = shapes::points_around(shapes::cube(), 1000, 1.5);
    for (const double threshold : {0.0, 0.1}) {
        Counted coordinates({WeightPrecision::single_precision, threshold});
        coordinates.bind(view(points));
        EXPECT_EQ(warped_by(coordinates, view(shapes::cube().points())), points);
    }
}

TEST(CageCoordinates, a_closed_drag_returns_to_the_same_bits_without_a_jump)
{
    const Points points = shapes::points_around(shapes::cube(), 500, 1.2);
    Counted coordinates;
    coordinates.bind(view(points));
    Points pose = shapes::cube().points(), last = warped_by(coordinates, view(pose));
    const Points first = last;
    double largest = 0.0;
    constexpr int steps = 60;
    for (int k = 1; k <= steps; ++k) {
        const double angle = 2 * shapes::pi * k / steps;
        pose = shapes::cube().points();
        if (k < steps)
            pose.row(6) +=
                Eigen::RowVector3d(std::cos(angle) - 1, std::sin(angle), 0.5 * std::sin(2 * angle));
        const Points now = warped_by(coordinates, view(pose));
        largest = std::max(largest, shapes::distance(now, last));
        last = now;
    }
    EXPECT_EQ(last, first);
    EXPECT_LT(largest, 2 * shapes::pi / steps * 1.5); // no farther than the vertex went in a step
    EXPECT_EQ(coordinates.evaluated, 500) << "sixty warps, one bind";
}

TEST(CageCoordinates, reports_what_it_bound)
{
    Points points(3, 3);
    points << 0.5, 0.5, 0.5, 1.5, 0, 0, 2, 0, 0;
    Counted coordinates;
    const SpaceReport report = coordinates.bind(view(points));
    EXPECT_EQ(report.point_count, 3);
    EXPECT_EQ(report.outside, (std::vector<int>{1, 2}));
    EXPECT_EQ(report.dropped, 0.0);
    EXPECT_EQ(report.weight_bytes, 16 * 8 * 4); // a block of 16 points, 8 vertices
    EXPECT_EQ(coordinates.points(), points);
}

TEST(CageCoordinates, binds_any_number_of_points)
{
    for (const int count : {0, 1, 63, 64, 65, 5000}) {
        Counted coordinates({WeightPrecision::double_precision, 0.0});
        const Points points = shapes::points_around(shapes::cube(), count, 1.0);
        EXPECT_EQ(coordinates.bind(view(points)).point_count, count);
        const Points moved = shapes::cube().points().rowwise() + Eigen::RowVector3d(1, 2, 3);
        const Points out = warped_by(coordinates, view(moved));
        ASSERT_EQ(out.rows(), count);
        if (count > 0) {
            EXPECT_LT(shapes::distance(out, points.rowwise() + Eigen::RowVector3d(1, 2, 3)), 1e-14);
        }
    }
}

TEST(CageCoordinates, names_points_that_are_not_finite)
{
    Counted coordinates;
    Points points = Points::Zero(4, 3);
    points(1, 2) = std::numeric_limits<double>::quiet_NaN();
    points(3, 0) = std::numeric_limits<double>::infinity();
    try {
        coordinates.bind(view(points));
        FAIL();
    } catch (const InvalidConstraint& error) {
        EXPECT_EQ(error.elements(), (std::vector<int>{1, 3}));
    }
}

TEST(CageCoordinates, a_bind_that_fails_changes_nothing)
{
    Counted coordinates;
    const Points points = shapes::points_around(shapes::cube(), 20'000, 1.0);
    coordinates.bind(view(points));
    const Points pose = 2.0 * shapes::cube().points();
    const Points before = warped_by(coordinates, view(pose));
    const Progress cancel([](double fraction, const char*) { return fraction < 0.01; });
    const Points others = shapes::points_around(shapes::cube(), 50'000, 2.0);
    EXPECT_THROW(coordinates.bind(view(others), cancel), Cancelled);
    EXPECT_EQ(warped_by(coordinates, view(pose)), before);
}

TEST(CageCoordinates, refuses_poses_that_do_not_fit)
{
    Counted coordinates;
    Points out = Points::Constant(2, 3, 7.0);
    EXPECT_THROW(coordinates.warp(view(shapes::cube().points()), {}, out.data()), InvalidConstraint) << "before bind()";
    const Points points = Points::Zero(5, 3);
    coordinates.bind(view(points));
    EXPECT_THROW(coordinates.warp(view(points), {}, out.data()), InvalidConstraint) << "five vertices";
    Points pose = shapes::cube().points();
    pose(2, 2) = std::numeric_limits<double>::infinity();
    EXPECT_THROW(coordinates.warp(view(pose), {}, out.data()), InvalidConstraint);
    EXPECT_EQ(out, Points::Constant(2, 3, 7.0)) << "nothing was written";
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/cage_coordinates.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

#include <atomic>

namespace sinew::test_cage_coordinates {

namespace {

/// Weights of 1 / distance, normalised; counts what the base class asks for.
class Counted : public CageCoordinates
{
public:
    explicit Counted(Cage cage = Cage(shapes::cube()), const PointWeightOptions& options = {})
        : CageCoordinates(std::move(cage), options)
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

SpaceTraits traits()
{
    const SurfaceMesh cage = shapes::cube();
    using enum WeightPrecision;
    return {.name = "CageCoordinates",
            .variants = {cages::variant<Counted>("single", cage, PointWeightOptions{single_precision, 0.0}),
                         cages::variant<Counted>("sparse", cage, PointWeightOptions{single_precision, 0.1}),
                         cages::variant<Counted>("double", cage, PointWeightOptions{double_precision, 0.0})},
            .control = cage.points(),
            .points = shapes::points_around(cage, 1000, 1.5),
            .translation = 1e-6, // of single weights
            .outside = Vector3(2, 0, 0),
            .other = [] { return std::make_shared<Counted>(Cage(shapes::octahedron())); }};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(CageCoordinates, SpaceContract, testing::Values(traits()));

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

TEST(CageCoordinates, sixty_warps_take_one_bind)
{
    const Points points = shapes::points_around(shapes::cube(), 500, 1.2);
    Counted coordinates;
    coordinates.bind(view(points));
    for (int k = 0; k < 60; ++k)
        warped_by(coordinates, view(shapes::cube().points()));
    EXPECT_EQ(coordinates.evaluated, 500);
}

} // namespace sinew::test_cage_coordinates

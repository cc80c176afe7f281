// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/cage/cage.h"
#include "native/methods/space/cage/inside/outside_weights.h"
#include "native/methods/space/cage/mean_value.h"
#include "native/methods/space/method.h"
#include "native/methods/space/weights/points_outside.h"
#include "tests/native/methods/space/contract.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <cmath>

namespace sinew {

/// Where a posed control takes the bound points.
Points warped_by(const SpaceMethod& method, PointsView control,
                 const std::optional<PointsView>& incoming = {});

} // namespace sinew

/// Cages and points that the tests of cage coordinates share.
namespace sinew::shapes {

/// A prism over a U, with n-gons at both ends: at (.5, 2.5, .5) one arm does not see the other's inner side.
SurfaceMesh u_prism();

/// A sphere of triangles with bumps, no two planes or lengths the same.
SurfaceMesh bumpy_sphere(int level, double bumps = 0.1);

/// In a box around the middle, `reach` times as large as the cage's.
Points points_around(const SurfaceMesh& cage, int count, double reach, std::uint64_t seed = 1);

/// On and around every vertex, the edges and the faces, at the given distances to both sides.
Points points_near(const SurfaceMesh& cage, const std::vector<double>& distances);

} // namespace sinew::shapes

namespace sinew::cages {

using shapes::u_prism;

Points inside_u_prism(int count, double depth, std::uint64_t seed = 1);

/// A sphere of triangles whose radius is anything from `low` to 1: concave, and no two edges alike.
SurfaceMesh bumpy(int level, double low, std::uint64_t seed);

/// Points within a ball.
Points in_ball(int count, double radius, std::uint64_t seed = 1);

Points in_cube(int count, double depth = 0.0);

/// The unit cube, its top of two triangles of which one has no area.
SurfaceMesh cube_with_a_flat_triangle();

inline constexpr PointWeightOptions doubles{WeightPrecision::double_precision, 0.0};

template <class Method, class Options>
RowMatrix weights(const SurfaceMesh& cage, const Points& points, const Options& options)
{
    Method coordinates(Cage(cage), options);
    coordinates.bind(view(points));
    return coordinates.weights().dense();
}

double largest(const RowMatrix& matrix);

/// Sum, sign, and linear precision to a share of the cage's size.
void expect_barycentric(const RowMatrix& w, const SurfaceMesh& cage, const Points& points, double precision);

/// These points are refused and named, or bound by mean values where that is asked for.
template <class Method, class Options>
void expect_outside(const SurfaceMesh& cage, Options options, const Points& points,
                    const std::vector<int>& outside)
{
    expect_elements(refusal<PointsOutside>([&] { weights<Method>(cage, points, options); }),
                    Error::Element::vertex, outside);
    options.outside = CageOutside::mean_value;
    Method both(Cage(cage), options);
    EXPECT_EQ(both.bind(view(points)).outside, outside);
    const RowMatrix w = both.weights().dense(), plain = weights<MeanValue>(cage, points, doubles);
    for (int i : outside)
        EXPECT_LT((w.row(i) - plain.row(i)).norm(), 1e-12) << i;
}

/// One set of options of a cage method.
template <class Method, class Options>
SpaceVariant variant(const std::string& name, const SurfaceMesh& cage, const Options& options)
{
    return {name, [cage, options] { return std::make_shared<Method>(Cage(cage), options); }};
}

} // namespace sinew::cages

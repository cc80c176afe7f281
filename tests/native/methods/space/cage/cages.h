// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/cage/cage.h"
#include "native/methods/space/method.h"
#include "native/methods/space/weights/point_weights.h"
#include "tests/native/methods/space/contract.h"
#include "tests/native/shapes.h"

#include <memory>
#include <string>

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

/// At least `depth` from its surface.
Points inside_u_prism(int count, double depth);

inline constexpr PointWeightOptions doubles{WeightPrecision::double_precision, 0.0};

/// One set of options of a cage method.
template <class Method, class Options>
SpaceVariant variant(const std::string& name, const SurfaceMesh& cage, const Options& options)
{
    return {name, [cage, options] { return std::make_shared<Method>(Cage(cage), options); }};
}

/// With one set of options, and another one that needs other weights.
template <class Method, class Options>
SpaceTraits traits(const std::string& name, const SurfaceMesh& cage, const Points& points,
                   const Options& options, const Options& other)
{
    return {.name = name,
            .variants = {variant<Method>(name, cage, options)},
            .control = cage.points(),
            .points = points,
            .other = variant<Method>(name, cage, other).make};
}

/// For points in the U, which refuses the others.
inline SpaceTraits refusing(SpaceTraits traits)
{
    traits.outside = Vector3(1.5, 2, 0.5);
    traits.refuses_outside = true;
    return traits;
}

} // namespace sinew::cages

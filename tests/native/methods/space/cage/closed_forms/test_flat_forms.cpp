// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/closed_forms/flat_forms.h"

#include "native/methods/space/cage/green.h"
#include "native/methods/space/cage/mean_value.h"
#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

namespace sinew::test_flat_forms {

namespace {

/// Turned and moved out of the axes.
Pose placed() { return shapes::turn({1, 2, -1}, 50, {0, 0, 0}, {3, -1, 2}); }

/// A concave polygon, as one face.
SurfaceMesh polygon()
{
    return shapes::mesh({{0, 0, 0}, {4, 0, 0}, {4, 3, 0}, {2.5, 1, 0}, {1, 3, 0}, {0, 2.5, 0}},
                        {{0, 1, 2, 3, 4, 5}});
}

template <class Method>
std::shared_ptr<Method> of(const SurfaceMesh& cage)
{
    if constexpr (std::is_same_v<Method, Green>)
        return std::make_shared<Green>(Cage(cage, true), GreenOptions{cages::doubles, {}, -1, {}});
    else
        return std::make_shared<Method>(Cage(cage, true), cages::doubles);
}

template <class Method>
SpaceTraits traits(const char* name)
{
    const SurfaceMesh flat = polygon(),
                      cage = shapes::moved(flat, shapes::transformed(flat.points(), placed()));
    const Points points = shapes::points_around(shapes::joined(flat, flat, {0, 0, 1}), 300, 1.2);
    return {.name = name,
            .variants = {{name, [cage] { return of<Method>(cage); }}},
            .control = cage.points(),
            .points = shapes::transformed(points, placed()),
            .translation = 1e-12,
            .follow = 4.0,
            .other = [] { return of<Method>(polygon()); }};
}

} // namespace

// What they keep is in tests/bindings/spaces/test_cages_flat.py.
INSTANTIATE_TEST_SUITE_P(Flat, SpaceContract,
                         testing::Values(traits<MeanValue>("MeanValue"), traits<Green>("Green")));

} // namespace sinew::test_flat_forms

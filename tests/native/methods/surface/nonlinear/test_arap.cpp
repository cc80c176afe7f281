// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/arap.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_arap {

namespace {

using Cells = ArapOptions::Cells;

std::vector<ArapOptions> variants()
{
    std::vector<ArapOptions> all;
    for (double smoothness : {0.0, 5e-4, 0.1})
        for (Cells cells : {Cells::spokes, Cells::rims})
            all.push_back({.smoothness = smoothness, .cells = cells});
    return all;
}

std::string name_of(const ArapOptions& options)
{
    return std::string(options.cells == Cells::rims ? "rims" : "spokes") + ", smoothness " +
           std::to_string(options.smoothness);
}

class Arap : public SurfaceFixture<sinew::Arap, ArapOptions>
{
public:
    static SurfaceTraits traits()
    {
        std::vector<SurfaceVariant> all{{"default", maker(), 2, false}};
        for (const Options& options : variants()) {
            const bool smooth = options.smoothness > 0; // alpha is scaled by the area of the whole mesh
            all.push_back({name_of(options), maker(options), smooth ? 2 : 1, !smooth});
        }
        all.push_back({"point handles", maker({.point_handles = 0.3}), 3, false});
        SurfaceTraits made = nonlinear("Arap", all);
        made.iterative = true;
        made.other = maker({.rigidity = {2.0}});
        return made;
    }
};

} // namespace

// More of it is in tests/bindings/surfaces/test_nonlinear.py.
INSTANTIATE_TEST_SUITE_P(Arap, SurfaceContract, testing::Values(Arap::traits()));

} // namespace sinew::test_arap

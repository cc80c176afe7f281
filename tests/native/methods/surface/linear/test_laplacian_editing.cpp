// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/laplacian_editing.h"

#include "tests/native/methods/surface/fixture.h"

#include <gtest/gtest.h>

namespace sinew::test_laplacian_editing {

namespace {

using Options = LaplacianEditingOptions;
const Options none{.transforms = LocalTransforms::none},
    explicitly{.transforms = LocalTransforms::from_handles}, estimated{},
    implicit{.transforms = LocalTransforms::implicit},
    length{.transforms = LocalTransforms::implicit, .second_stage = SecondStage::length};

class LaplacianEditing : public SurfaceFixture<sinew::LaplacianEditing, Options>
{
public:
    // The systems of 80-vertex meshes have condition numbers of up to 1e7.
    static SurfaceTraits traits(const std::string& name, const std::vector<SurfaceVariant>& variants)
    {
        SurfaceTraits made = linear(name, variants);
        made.follow = 3.0;
        made.rest = made.incoming = 1e-11; // rotations are fitted to edges that have not turned
        made.translation = 1e-9;
        made.similar = 1e-8;
        made.rides = 1e-9;
        made.other = maker({.laplacian = Discretization::uniform});
        return made;
    }
    static SurfaceTraits turning()
    {
        Options geodesic = explicitly, uniform = estimated;
        geodesic.field = Field::geodesic;
        uniform.laplacian = Discretization::uniform;
        SurfaceTraits made = traits("Turning", {{"estimated", maker(estimated)},
                                                {"estimated, uniform", maker(uniform)},
                                                {"explicit", maker(explicitly), 2, true, 1e-9},
                                                {"explicit, geodesic", maker(geodesic), 1, true, 1e-9},
                                                {"implicit", maker(implicit), 2},
                                                {"implicit, length", maker(length), 2}});
        made.rigid = 1e-9;
        made.turns_incoming = made.parts_apart = true;
        made.half_turns = 81;
        made.updates = "refits";
        made.updated = maker({.refits = 5});
        return made;
    }
    static SurfaceTraits unturned()
    {
        Options paper = estimated, cotan = none;
        paper.mean_frame = false;
        cotan.laplacian = Discretization::cotan;
        SurfaceTraits made = traits("Unturned", {{"none", maker(none)},
                                                 {"none, cotan", maker(cotan)},
                                                 {"estimated without a mean frame", maker(paper)}});
        made.updates = "transforms, refits";
        return made;
    }
};

} // namespace

// More of it is in tests/bindings/oracles/test_oracles_surface.py.
INSTANTIATE_TEST_SUITE_P(LaplacianEditing, SurfaceContract,
                         testing::Values(LaplacianEditing::turning(), LaplacianEditing::unturned()));

} // namespace sinew::test_laplacian_editing

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/laplacian_editing.h"

#include "native/methods/surface/linear/thin_shell.h"
#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_laplacian_editing {

namespace {

constexpr std::array every{Discretization::uniform, Discretization::cotan, Discretization::cotan_voronoi};

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
        made.similar = made.scaled = 1e-8;
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

std::vector<SurfaceMesh> some_meshes() { return {shapes::hill(8, 8), shapes::bar(6, 2), shapes::sphere(2)}; }

} // namespace

INSTANTIATE_TEST_SUITE_P(LaplacianEditing, SurfaceContract,
                         testing::Values(LaplacianEditing::turning(), LaplacianEditing::unturned()));

TEST_F(LaplacianEditing, without_transformations_is_the_thin_shell_with_bending_alone)
{
    for (const SurfaceMesh& mesh : some_meshes())
        for (Discretization kind : every) {
            std::vector<Handle> handles = shapes::ends(mesh, shapes::size(mesh.points()) / 8);
            handles[1].weights.assign(handles[1].vertices.size(), 0.8);
            ThinShell shell(mesh, {.laplacian = kind});
            shell.set_handles(handles);
            Points expected;
            const SolveReport wanted = shell.solve({bent}, expected);
            Options options = none;
            options.laplacian = kind;
            SolveReport report;
            EXPECT_LT(shapes::distance(solved(mesh, handles, {.poses = bent}, options, &report), expected),
                      1e-10);
            EXPECT_NEAR(report.energy, wanted.energy, 1e-9 * wanted.energy);
        }
}

TEST_F(LaplacianEditing, keeps_the_factor_where_only_transformations_change)
{
    const SurfaceMesh mesh = shapes::hill(12, 9);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    Method former(mesh, none), next(mesh, explicitly);
    former.set_handles(handles);
    const BindReport report = next.rebind(former, handles);
    EXPECT_EQ(report.reuse, Reuse::updated);
    EXPECT_EQ(report.changed, "transforms");
    Points q;
    next.solve({bent}, q);
    EXPECT_EQ(q, solved(mesh, handles, {.poses = bent}, explicitly));
}

} // namespace sinew::test_laplacian_editing

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/multiresolution.h"

#include "native/core/errors.h"
#include "native/methods/surface/linear/gradient_editing.h"
#include "native/methods/surface/linear/laplacian_editing.h"
#include "native/methods/surface/linear/thin_shell.h"
#include "native/methods/surface/nonlinear/arap.h"
#include "tests/native/methods/multiresolution/bumpy_plate.h"
#include "tests/native/methods/surface/fixture.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_multiresolution {

namespace {

using Fixture = SurfaceFixture<sinew::Multiresolution, MultiresolutionOptions>;
const Poses& bent = Fixture::bent;

template <class Base>
auto around(const MultiresolutionOptions& options = {})
{
    return [options](const SurfaceMesh& mesh) {
        return std::make_shared<Multiresolution>(mesh, std::make_shared<Base>(mesh), options);
    };
}

SurfaceTraits traits()
{
    // Not separate: the wavelength is in mean edge lengths of the whole mesh.
    SurfaceTraits made = Fixture::linear(
        "Multiresolution",
        {{"vectors", around<ThinShell>(), 2, false},
         {"normals", around<ThinShell>({.details = DetailKind::normal_displacements}), 2, false},
         {"volumes", around<ThinShell>({.details = DetailKind::displacement_volumes}), 3, false},
         {"transfer", around<ThinShell>({.details = DetailKind::deformation_transfer}), 3, false},
         {"two bands", around<ThinShell>({.bands = 2}), 3, false}});
    made.many_enter = true;
    made.allocates = {"volumes", "transfer"};
    made.follow = 3.0; // details turn, too
    made.rest = 1e-13;
    made.incoming = 1e-12;
    // One held vertex leaves a condition of 1e6, and bands are solved one after the other.
    made.translation = made.similar = 1e-9;
    made.updates = "wavelength";
    made.updated = around<ThinShell>({.wavelength = 5.0});
    made.other = around<GradientEditing>();
    return made;
}

SurfaceTraits rigid_traits()
{
    SurfaceTraits found = traits();
    found.name = "MultiresolutionArap";
    found.variants = {{"vectors", around<Arap>(), 3, false},
                      {"normals", around<Arap>({.details = DetailKind::normal_displacements}), 3, false},
                      {"volumes", around<Arap>({.details = DetailKind::displacement_volumes}), 4, false},
                      {"transfer", around<Arap>({.details = DetailKind::deformation_transfer}), 4, false}};
    // As for ARAP alone: rounding may change the iteration at which it stops, and sheets may buckle.
    found.drag = [](double s) {
        const double t = 0.5 - 0.5 * std::cos(2 * shapes::pi * s);
        return Poses{shapes::still(), shapes::turn({0.2, 1, 0.5}, 30 * t, {9, 4, 0}, {t, 0.5 * t, 0})};
    };
    found.many.reset();
    found.slack = 0.02;
    found.similar = 1e-6;
    found.rigid = 1e-9;
    found.updates = "";
    found.updated = {};
    found.other = around<ThinShell>();
    return found;
}

/// Displaces all vertices by the translation of its second handle, and tells whether a shape entered.
class Lift final : public SurfaceMethod
{
public:
    explicit Lift(const SurfaceMesh& rest) : SurfaceMethod(rest) {}
    bool displaces_all_alike() const override { return true; }
    mutable bool entered = false;

private:
    void bind(const Regions&, BindReport&, const Progress&) override {}
    SolveReport deform(const SolveRequest& request, const Targets& targets, Points& positions) const override
    {
        entered = request.incoming.has_value();
        positions = targets.base().rowwise() + request.poses[1].col(3).transpose();
        return {.converged = true};
    }
    std::vector<std::string> changed_options(const SurfaceMethod&) const override { return {}; }
    bool updates(const std::string&) const override { return true; }
    void swap_binding(SurfaceMethod&) override {}
};

Points solved(const SurfaceMethod& method, const SolveRequest& request)
{
    Points positions;
    method.solve(request, positions);
    return positions;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Multiresolution, SurfaceContract, testing::Values(traits(), rigid_traits()));

TEST(Multiresolution, the_base_is_kept_where_only_the_details_change)
{
    const SurfaceMesh mesh = shapes::hill(12, 12);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    Multiresolution former(mesh, std::make_shared<Arap>(mesh));
    former.set_handles(handles);
    Multiresolution next(mesh, std::make_shared<Arap>(mesh), {.bands = 2});
    const BindReport report = next.rebind(former, handles);
    EXPECT_EQ(report.reuse, Reuse::updated);
    EXPECT_EQ(report.changed, "bands");
    EXPECT_EQ(report.factorizations, 2 + 1 + 2); // of the base, of the former band, of two bands
    Multiresolution fresh(mesh, std::make_shared<Arap>(mesh), {.bands = 2});
    fresh.set_handles(handles);
    EXPECT_EQ(solved(next, {bent}), solved(fresh, {bent}));
    // Another base is another method.
    Multiresolution other(mesh, std::make_shared<Arap>(mesh, ArapOptions{.smoothness = 0.0}));
    EXPECT_FALSE(other.can_reuse(next));
    EXPECT_EQ(other.differences(next), (std::vector<std::string>{"base", "bands"}));
    EXPECT_THROW(Multiresolution(mesh, nullptr), InvalidOption);
}

TEST(Multiresolution, a_base_that_displaces_all_shapes_alike_solves_from_rest)
{
    const SurfaceMesh mesh = bumps::plate(12);
    std::vector<Handle> handles = shapes::ends(mesh, 1.01);
    const Poses lifted{shapes::shift(1, 2, 3), shapes::shift(1, 2, 3)};
    const auto base = std::make_shared<Lift>(mesh);
    Multiresolution method(mesh, base);
    method.set_handles(handles);
    const Points expected = shapes::transformed(mesh.points(), lifted[0]);
    EXPECT_LT(shapes::distance(solved(method, {lifted}), expected), 1e-12);
    EXPECT_FALSE(base->entered);
    for (const SolveRequest& request :
         {SolveRequest{.poses = lifted, .incoming = view(mesh.points())}, {.poses = lifted, .substeps = 2}}) {
        EXPECT_LT(shapes::distance(solved(method, request), expected), 1e-12);
        EXPECT_TRUE(base->entered);
    }
    // A soft handle pulls the base from another place than the rest shape.
    handles[1].weights.assign(handles[1].vertices.size(), 0.5);
    method.set_handles(handles);
    EXPECT_LT(shapes::distance(solved(method, {lifted}), expected), 1e-12);
    EXPECT_TRUE(base->entered);
    ThinShell shell(mesh);
    LaplacianEditing fixed(mesh, {.transforms = LocalTransforms::none}), turning(mesh);
    EXPECT_TRUE(shell.displaces_all_alike() && fixed.displaces_all_alike());
    EXPECT_FALSE(turning.displaces_all_alike());
}

} // namespace sinew::test_multiresolution

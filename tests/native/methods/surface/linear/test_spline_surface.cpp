// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/spline_surface.h"

#include "tests/native/methods/surface/fixture.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_spline_surface {

namespace {

class SplineSurface : public SurfaceFixture<sinew::SplineSurface, SplineSurfaceOptions>
{
public:
    /// x and y of the points, in which the meshes of the suite are graphs.
    static auto mapped(const SurfaceMesh& mesh)
    {
        return std::make_shared<Method>(
            mesh, Options{.degree = 2, .columns = 6, .rows = 5, .uv_map = mesh.points().leftCols(2)});
    }
    static SurfaceTraits traits()
    {
        SurfaceTraits made =
            linear("SplineSurface",
                   {{"plane", maker()},
                    {"map", mapped},
                    {"least squares", maker({.degree = 1, .columns = 4, .rows = 3, .smoothing = 0.0})}});
        made.translation = 1e-7;
        made.similar = 1e-6;
        made.many_enter = true;
        made.updates = "smoothing";
        made.updated = maker({.smoothing = 0.1});
        return made;
    }
};

} // namespace

INSTANTIATE_TEST_SUITE_P(SplineSurface, SurfaceContract, testing::Values(SplineSurface::traits()));

TEST_F(SplineSurface, reaches_only_as_far_into_the_handles_as_the_margin)
{
    const SurfaceMesh mesh = shapes::grid(30, 4); // the free vertices lie within 4 of the middle
    std::vector<Handle> handles = shapes::ends(mesh, 10.5);
    std::erase_if(handles[1].vertices, [&](int v) { return mesh.point(v).x() > 22.5; });
    handles.push_back({shapes::where(mesh, [](const Vector3& x) { return x.x() > 22.5; }), {}});
    const Pose pose = shapes::turn({0, 1, 0}, 30, {20, 0, 0});
    const Poses alike{shapes::still(), pose, pose}, apart{shapes::still(), pose, shapes::still()};
    // The free vertices go 4.47 from their mean, and the third handle begins 4 from them.
    const auto change = [&](double margin) {
        const Points a = solved(mesh, handles, {.poses = alike}, {.margin = margin}),
                     b = solved(mesh, handles, {.poses = apart}, {.margin = margin});
        double most = 0.0;
        for (int v = 0; v < mesh.vertex_count(); ++v)
            if (mesh.point(v).x() < 22.5)
                most = std::max(most, (a.row(v) - b.row(v)).norm());
        return most;
    };
    EXPECT_LT(change(0.44), 1e-12);
    EXPECT_GT(change(0.46), 1e-3);
}

} // namespace sinew::test_spline_surface

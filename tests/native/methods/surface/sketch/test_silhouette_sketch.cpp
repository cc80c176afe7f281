// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/sketch/silhouette_sketch.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

// What it makes of a line is in tests/bindings/surfaces/test_silhouette_sketch.py.
namespace sinew::test_silhouette_sketch {

TEST(SilhouetteSketch, ten_strokes_take_one_factorisation)
{
    const SurfaceMesh mesh = shapes::hill(7, 8);
    std::vector<LinePoint> line;
    for (int v = 3; v < mesh.vertex_count(); v += 8)
        line.push_back({v, v, 0.0});
    const SilhouetteSketch sketch(mesh, line, {0, 7});
    Points positions;
    for (int k = 0; k < 10; ++k) {
        const Points targets = k * Points::Ones(static_cast<Eigen::Index>(line.size()), 3);
        sketch.solve(view(targets), positions);
    }
    EXPECT_EQ(sketch.factorizations(), 1);
}

} // namespace sinew::test_silhouette_sketch

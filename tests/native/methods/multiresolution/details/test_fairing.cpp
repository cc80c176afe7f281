// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/fairing.h"

#include "tests/native/methods/multiresolution/bumpy_plate.h"

#include <gtest/gtest.h>

namespace sinew::test_fairing {

namespace {

Regions held_at(const SurfaceMesh& mesh, std::vector<Handle> handles)
{
    const Components parts = connected_components(mesh);
    return faired_regions(mesh, Regions(std::move(handles), parts), parts);
}

Points smoothed(const Fairing& fairing, const Points& y)
{
    Points b;
    fairing.smooth(view(y), b);
    return b;
}

} // namespace

TEST(Fairing, halves_waves_of_its_wavelength_and_keeps_a_plane_to_the_border)
{
    const int k = 60;
    Points flat = shapes::grid_points(k, k, 0.1);
    const SurfaceMesh mesh = shapes::moved(shapes::grid(k, k), flat);
    const Fairing fairing(mesh, held_at(mesh, {{{0}, {}}}), 1.0);
    EXPECT_LT(shapes::distance(smoothed(fairing, flat), flat), 1e-12);
    for (const auto& [length, left] : {std::pair{1.0, 0.5}, {0.5, 1.0 / 17}, {2.0, 16.0 / 17}}) {
        Points wavy = flat;
        wavy.col(2) = (2 * shapes::pi / length * flat.col(0)).array().sin() * 0.1;
        const Points b = smoothed(fairing, wavy);
        double most = 0.0; // far from the border, which is held
        for (int i = 0; i < b.rows(); ++i)
            if ((b.row(i) - Eigen::RowVector3d(3, 3, b(i, 2))).cwiseAbs().maxCoeff() < 1.0)
                most = std::max(most, std::abs(b(i, 2)));
        EXPECT_NEAR(most / 0.1, left, 0.03) << length; // a wave has 5 to 20 edges
    }
}

TEST(Fairing, soft_handles_take_details_away_as_far_as_they_pull)
{
    const SurfaceMesh mesh = shapes::sphere(2);
    double before = 1e9;
    for (double weight : {0.0, 0.5, 0.99, 1.0}) {
        const std::vector<Handle> handles{{{0, 1}, {}}, {{20, 21}, {weight, weight}}};
        const Points b = smoothed({mesh, held_at(mesh, handles), 3.0}, mesh.points());
        const double detail = (b.row(20) - mesh.points().row(20)).norm();
        EXPECT_LT(detail, before) << weight;
        before = detail;
    }
    EXPECT_EQ(before, 0.0);
}

} // namespace sinew::test_fairing

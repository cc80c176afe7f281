// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/deformation_transfer.h"

#include "tests/native/methods/multiresolution/codings.h"

namespace sinew::test_deformation_transfer {

namespace {

CodingTraits traits()
{
    return {.name = "DeformationTransfer",
            .make =
                [](const Study& study) {
                    return std::make_unique<DeformationTransfer>(
                        study.mesh, study.regions, view(study.fine()), view(study.base), study.rings);
                },
            .bent_up = 0.0199,
            .bent_down = 0.0192,
            .zero = 1e-12,
            .rigid = 1e-11,
            .similar = true};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(DeformationTransfer, CodingContract, testing::Values(traits()));

TEST(DeformationTransfer, vertices_that_are_pulled_softly_go_where_their_vectors_lead)
{
    const SurfaceMesh mesh = shapes::sphere(3);
    const Components parts = connected_components(mesh);
    const Regions regions({{{0, 5, 9, 200}, {0.7, 0.7, 0.7, 0.7}}}, parts);
    const auto rings = std::make_shared<const RingRotations>(mesh);
    Points base;
    Fairing(mesh, regions, 2.0).smooth(view(mesh.points()), base);
    const Pose pose = shapes::turn({1, 1, 2}, 100, {1, 2, 3}, {5, -4, 6});
    const DeformationTransfer coding(mesh, regions, view(mesh.points()), view(base), rings);
    EXPECT_LT(shapes::distance(bumps::detailed(coding, mesh.points(), base, shapes::transformed(base, pose)),
                               shapes::transformed(mesh.points(), pose)),
              1e-11);
}

} // namespace sinew::test_deformation_transfer

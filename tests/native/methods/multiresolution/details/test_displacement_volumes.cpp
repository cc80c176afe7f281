// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/details/displacement_volumes.h"

#include "tests/native/methods/multiresolution/codings.h"

namespace sinew::test_displacement_volumes {

namespace {

std::unique_ptr<DisplacementVolumes> coding_of(const Study& study)
{
    return std::make_unique<DisplacementVolumes>(study.mesh, study.regions, view(study.fine()),
                                                 view(study.base), study.rings);
}

CodingTraits traits()
{
    return {.name = "DisplacementVolumes", .make = coding_of, .bent_up = 0.0144, .bent_down = 0.0144};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(DisplacementVolumes, CodingContract, testing::Values(traits()));

TEST(DisplacementVolumes, a_lifted_plate_has_its_area_times_the_lift_wherever_it_is_pushed)
{
    const SurfaceMesh mesh = shapes::grid(3, 3, 1.0 / 3);
    const Points lifted = mesh.points().rowwise() + Eigen::RowVector3d(0.2, -0.1, 0.3);
    double sum = 0.0;
    for (const Triangle& t : mesh.triangles())
        for (double volume : prism_between(view(mesh.points()), view(lifted), t).volumes)
            sum += volume;
    EXPECT_NEAR(sum, 0.3, 1e-14);
}

TEST(DisplacementVolumes, of_a_vertex_are_the_sums_over_its_prisms)
{
    const Study study(13); // triangles that do not fill up the lanes of kernels
    shapes::Random random(6);
    const Points fine = study.fine() + 0.3 * random.dense(study.mesh.vertex_count(), 3);
    VectorX sums = VectorX::Zero(study.mesh.vertex_count());
    for (const Triangle& t : study.mesh.triangles()) {
        const Prism prism = prism_between(view(study.base), view(fine), t);
        for (int corner = 0; corner < 3; ++corner)
            sums[t[corner]] += study.regions.is_free(t[corner]) ? prism.volumes[corner] : 0.0;
    }
    EXPECT_LT((coding_of(study)->volumes(view(fine), view(study.base)) - sums).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(DisplacementVolumes, are_the_same_before_and_after_in_gentle_and_tight_bends)
{
    const Study study(60);
    const auto coding = coding_of(study);
    const VectorX goal = coding->volumes(view(study.fine()), view(study.base));
    const double height = shapes::distance(study.fine(), study.base),
                 mean = goal.cwiseAbs().sum() / goal.size();
    // Height times curvature, and more than the iterations that are taken: 5, 8, 15, 18, and 10 with those of
    // Newton's; the study found 8, 24, and 74 solves.
    for (const auto& [sharpness, iterations] :
         {std::pair(0.28, 7), {0.7, 12}, {1.27, 17}, {1.6, 21}, {3.0, 21}}) {
        const double half = 0.5 * 200 * shapes::pi / 180 * height / sharpness;
        const double degrees = half > 3 ? 200 * 3 / half : 200, wide = std::min(half, 3.0);
        const Points moved = bumps::bent(study.base, degrees, 5 - wide, 5 + wide);
        SolveReport report;
        const Points x = bumps::detailed(*coding, study.fine(), study.base, moved, &report);
        EXPECT_TRUE(report.converged) << sharpness;
        EXPECT_LT((coding->volumes(view(x), view(moved)) - goal).cwiseAbs().maxCoeff(), 2e-6 * mean)
            << sharpness;
        if (sharpness < 2) { // in bends of a third of the height, some faces turn
            EXPECT_EQ(bumps::turned_faces(study.mesh, study.base, moved, x), 0) << sharpness;
        }
        EXPECT_LT(report.iterations, iterations) << sharpness;
        if (sharpness != 1.6) { // where the quick iteration may or may not do
            EXPECT_EQ(report.fallbacks, sharpness > 2) << sharpness;
        }
    }
}

TEST(DisplacementVolumes, take_few_steps_on_a_base_that_is_stretched)
{
    const Study study(60);
    const auto coding = coding_of(study);
    const Points moved = study.base * Vector3(1.3, 1 / 1.3, 1).asDiagonal();
    SolveReport report;
    bumps::detailed(*coding, study.fine(), study.base, moved, &report);
    EXPECT_TRUE(report.converged);
    EXPECT_EQ(report.fallbacks, 0);
    EXPECT_LT(report.iterations, 7); // 6; and 8 if moves are not measured as at rest
}

TEST(DisplacementVolumes, are_kept_on_a_base_of_another_size)
{
    const Study study(24);
    const auto coding = coding_of(study);
    const VectorX goal = coding->volumes(view(study.fine()), view(study.base));
    for (double scale : {0.4, 0.7, 2.0, 5.0}) {
        SolveReport report;
        const Points moved = scale * study.base;
        const Points x = bumps::detailed(*coding, study.fine(), study.base, moved, &report);
        EXPECT_TRUE(report.converged) << scale;
        EXPECT_EQ(report.fallbacks, 1) << scale;
        EXPECT_LT((coding->volumes(view(x), view(moved)) - goal).cwiseAbs().maxCoeff(),
                  2e-6 * goal.cwiseAbs().sum() / goal.size());
    }
}

} // namespace sinew::test_displacement_volumes

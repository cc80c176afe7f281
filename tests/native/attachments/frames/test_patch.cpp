// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/frames/patch.h"

#include "tests/native/attachments/scenes.h"

#include <numeric>

namespace sinew::test_patch {

struct Bed
{
    SurfaceMesh mesh;
    Part part;
    HostSurface host;

    explicit Bed(const scenes::Piece& piece)
        : mesh(scenes::Scene({piece}).mesh()), part(parts_of(mesh, connected_components(mesh)).front()),
          host(part)
    {
        host.prepare_tree();
    }

    Contact contact(const Vector3& above, double weight = 1.0, double anchor = 1.0) const
    {
        const TriangleTree::Place place = host.tree().closest_place(above);
        return {place.point, place.triangle, weight, anchor};
    }
    Vector3 mean(const Patch& patch, const std::vector<double>& weights) const
    {
        Vector3 sum = Vector3::Zero();
        for (std::size_t i = 0; i < weights.size(); ++i)
            sum += weights[i] * host.centres()[patch.triangles[i]];
        return sum;
    }
};

TEST(Patch, lies_within_reach_and_its_centroid_where_the_contacts_are)
{
    const Bed bed(scenes::plate(61, 61));
    const std::vector<Contact> contacts{bed.contact({4, 5, 1}), bed.contact({4.4, 5.1, 1})};
    const Patch patch = patch_beneath(bed.host, contacts, 0, 1.2, 24);
    EXPECT_EQ(patch.triangles.size(), 24u);
    EXPECT_NEAR(std::accumulate(patch.weights.begin(), patch.weights.end(), 0.0), 1, 1e-14);
    EXPECT_NEAR(std::accumulate(patch.anchors.begin(), patch.anchors.end(), 0.0), 1, 1e-14);
    EXPECT_LT((bed.mean(patch, patch.weights) - Vector3(4.2, 5.05, 0)).norm(), 1e-10);
    EXPECT_LT((bed.mean(patch, patch.anchors) - Vector3(4.2, 5.05, 0)).norm(), .1);
    for (int t : patch.triangles)
        EXPECT_LT((bed.host.centres()[t] - Vector3(4.2, 5.05, 0)).norm(), 1.2 + .25);
}

TEST(Patch, stays_on_one_of_two_sheets)
{
    // A sheet folded over: its ends lie above one another.
    const Bed bed(scenes::sheet(121, 21, false, false, [](double a, double b) {
        const double s = 12 * a - 6;
        const double x = std::abs(s) < 1 ? std::cos(s * shapes::pi / 2) / 2 : 1 - std::abs(s);
        return Vector3(x, 2 * b, std::abs(s) < 1 ? std::sin(s * shapes::pi / 2) / 2 : std::copysign(.5, s));
    }));
    const std::vector<Contact> contacts{bed.contact({-3, 1, .5}), bed.contact({-3, 1, -.5})};
    for (int best : {0, 1}) {
        const Patch patch = patch_beneath(bed.host, contacts, best, 1.5, 24);
        for (int t : patch.triangles)
            EXPECT_EQ(bed.host.centres()[t].z() > 0, best == 0);
    }
}

TEST(Patch, on_large_triangles_is_the_one_that_is_touched)
{
    const Bed bed(scenes::plate(2, 2));
    const Patch patch = patch_beneath(bed.host, {bed.contact({9, 5, .1})}, 0, .01, 24);
    EXPECT_EQ(patch.triangles.size(), 1u);
    EXPECT_EQ(patch.weights, std::vector{1.0});
    EXPECT_EQ(patch.anchors, std::vector{1.0});
}

} // namespace sinew::test_patch

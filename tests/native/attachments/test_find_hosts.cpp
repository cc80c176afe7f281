// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/find_hosts.h"

#include "tests/native/attachments/scenes.h"

namespace sinew::test_find_hosts {

/// Median distance of the samples that count from a part.
double distance(const Attachment& attachment, const std::vector<Part>& parts, const TriangleTree& from)
{
    std::vector<double> gaps;
    for (std::size_t s = 0; s < std::min<std::size_t>(attachment.samples.size(), 96); ++s) {
        const Vector3& point = parts[attachment.part].points[attachment.samples[s]];
        gaps.push_back((from.closest(point) - point).norm());
    }
    std::ranges::sort(gaps);
    const std::size_t middle = gaps.size() / 2;
    return gaps.size() % 2 ? gaps[middle] : (gaps[middle] + gaps[middle - 1]) / 2;
}

/// A plate, large balls on it, and many small ones around them, of many sizes.
scenes::Scene cloud(int count)
{
    shapes::Random random(3);
    scenes::Scene scene{scenes::plate(11, 11)};
    for (int i = 0; i < count; ++i) {
        const Vector3 at = 5 * random.vector() + Vector3(5, 5, 5);
        const double radius = i % 10 ? .02 + .05 * random.unit() : .4 + .3 * random.unit();
        scene.add(scenes::ball(radius, at.cwiseProduct(Vector3(1, 1, .4)) + Vector3(0, 0, .1), 5, 3));
    }
    return scene;
}

std::vector<Attachment> seats_of(const scenes::Scene& scene, std::vector<int> driven)
{
    const SurfaceMesh mesh = scene.mesh();
    const std::vector<Part> parts = parts_of(mesh, connected_components(mesh));
    std::vector<bool> flags(parts.size(), false);
    for (int part : driven)
        flags[part] = true;
    HostSurfaces surfaces;
    std::vector<Attachment> attachments = find_hosts(parts, flags, 0.1, surfaces, {});
    for (const Attachment& attachment : attachments)
        for (std::size_t i = 0; i < attachment.samples.size(); ++i) {
            // What lies beneath lies on the triangle that is named.
            const auto& [a, b, c] =
                surfaces[attachment.host]->triangles().at(attachment.beneath.at(i).triangle);
            const std::vector<Vector3>& points = parts[attachment.host].points;
            const Vector3 normal = (points[b] - points[a]).cross(points[c] - points[a]).normalized();
            EXPECT_NEAR(normal.dot(attachment.beneath[i].point - points[a]), 0, 1e-12);
        }
    return attachments;
}

TEST(FindHosts, finds_the_nearest_driven_part_unless_a_larger_part_is_much_nearer)
{
    const scenes::Scene scene{scenes::plate(21, 21),         scenes::ball(1, {20, 5, 0}),
                              scenes::ball(.5, {5, 5, .8}),  scenes::ball(.2, {18.6, 5, 0}),
                              scenes::ball(.1, {5, 5, 1.4}), scenes::ball(.3, {12, 5, 0})};
    const std::vector<Attachment> attachments = seats_of(scene, {0, 1});
    std::vector<std::array<int, 2>> found;
    for (const Attachment& attachment : attachments)
        found.push_back({attachment.part, attachment.host});
    // The small ball rides on the large one, not on the plate below.
    EXPECT_EQ(found, (std::vector<std::array<int, 2>>{{2, 0}, {5, 0}, {3, 1}, {4, 2}}));
}

TEST(FindHosts, of_a_part_between_two_driven_ones_are_all_on_one)
{
    scenes::Piece other = scenes::plate(21, 21);
    for (Vector3& p : other.points)
        p.x() += 10.5;
    const std::vector<Attachment> attachments =
        seats_of({scenes::plate(21, 21), other, scenes::block({4, 1, .1}, {10, 5, .3}, {8, 2, 1})}, {0, 1});
    ASSERT_EQ(attachments.size(), 1u);
    EXPECT_EQ(attachments[0].beneath.size(), attachments[0].samples.size());
}

TEST(FindHosts, are_those_that_a_look_at_every_larger_part_finds)
{
    const scenes::Scene scene = cloud(150);
    const SurfaceMesh mesh = scene.mesh();
    const std::vector<Part> parts = parts_of(mesh, connected_components(mesh));
    std::vector<TriangleTree> trees;
    for (const Part& part : parts)
        trees.emplace_back(part.points, part.triangles);
    int moved = 0;
    for (const Attachment& attachment : seats_of(scene, {0})) {
        double best = distance(attachment, parts, trees[0]) / 2;
        int host = 0;
        for (int other = 1; other < static_cast<int>(parts.size()); ++other)
            if (parts[other].area > 1.0001 * parts[attachment.part].area)
                if (const double found = distance(attachment, parts, trees[other]); found < best) {
                    best = found;
                    host = other;
                }
        EXPECT_EQ(attachment.host, host) << attachment.part;
        moved += host > 0;
    }
    EXPECT_GT(moved, 50);
}

TEST(FindHosts, of_many_parts_are_found_without_a_look_at_all_pairs)
{
    double before = 0.0;
    for (int count : {250, 500, 1000}) {
        double looks = 0.0;
        for (const Attachment& attachment : seats_of(cloud(count), {0}))
            looks += attachment.looks;
        EXPECT_LT(looks, 100.0 * count) << count;
        if (before > 0) {
            EXPECT_LT(looks, 3 * before) << count << ": four times as many pairs";
        }
        before = looks;
    }
}

} // namespace sinew::test_find_hosts

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/trees/box_tree.h"

#include "tests/native/shapes.h"

namespace sinew::test_box_tree {

using Box = BoxTree::Box;

/// Small boxes in a cube; every third one stands for two equal ones.
std::vector<Box> boxes_of(int count)
{
    shapes::Random random(7);
    std::vector<Box> boxes;
    while (static_cast<int>(boxes.size()) < count) {
        const Vector3 at = random.vector();
        boxes.emplace_back(at, at + .1 * random.vector().cwiseAbs());
        if (boxes.size() % 3 == 0)
            boxes.push_back(boxes.back());
    }
    boxes.resize(count);
    return boxes;
}

TEST(BoxTree, visits_boxes_by_rising_bound_and_equal_ones_by_rising_index)
{
    for (int count : {0, 1, 2, 3, 10, 500}) {
        const std::vector<Box> boxes = boxes_of(count);
        const BoxTree tree(boxes);
        const Vector3 from(.3, .4, .5);
        const double limit = .8;
        for (int end : {0, count / 2, count}) {
            std::vector<std::pair<double, int>> expected;
            for (int i = 0; i < end; ++i)
                if (boxes[i].exteriorDistance(from) < limit)
                    expected.emplace_back(boxes[i].exteriorDistance(from), i);
            std::ranges::sort(expected);
            std::vector<std::pair<double, int>> visited;
            tree.visit_by_bound(
                end, limit, [&](const Box& box, bool) { return box.exteriorDistance(from); },
                [&](int i) {
                    visited.emplace_back(boxes[i].exteriorDistance(from), i);
                    return limit;
                });
            EXPECT_EQ(visited, expected) << count << " " << end;
        }
    }
}

TEST(BoxTree, a_search_that_ends_with_the_first_box_looks_at_few)
{
    const int count = 20000;
    const std::vector<Box> boxes = boxes_of(count);
    const BoxTree tree(boxes);
    for (const Vector3& from : {Vector3(0, 0, 0), Vector3(-1, -1, -1), Vector3(3, -.8, .4)}) {
        int looks = 0, visits = 0;
        tree.visit_by_bound(
            count, 10,
            [&](const Box& box, bool) {
                ++looks;
                return box.exteriorDistance(from);
            },
            [&](int i) {
                ++visits;
                return boxes[i].exteriorDistance(from);
            });
        EXPECT_LE(visits, 3);
        EXPECT_LT(looks, 300);
    }
}

} // namespace sinew::test_box_tree

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/frames/frame_kernels.h"

#include "native/attachments/frames/moving_frames.h"
#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <cstring>

namespace sinew::test_frame_kernels {

TEST(FrameKernels, give_the_same_bits_with_every_set_of_instructions)
{
    const SurfaceMesh mesh = shapes::octahedron();
    const std::vector<Triangle>& triangles = mesh.triangles();
    const Points after =
        shapes::transformed(mesh.points(), shapes::affine(Matrix3(Vector3(2, .5, 1).asDiagonal())));
    std::vector<FrameSlot> slots(triangles.size());
    LooseSlot loose{};
    for (int lane = 0; lane < 4; ++lane) {
        for (std::size_t i = 0; i < slots.size(); ++i) {
            const Triangle& t = triangles[(i + lane) % slots.size()];
            for (int k = 0; k < 3; ++k)
                slots[i].corners[k][lane] = t[k];
            slots[i].weights[lane] = slots[i].anchors[lane] = static_cast<double>(i + 1) / 36;
        }
        loose.vertices[lane] = triangles[lane][0];
        for (int k = 0; k < 3; ++k)
            loose.corners[k][lane] = triangles[7 - lane][k];
    }
    const auto run = [&](const FrameKernels& kernels) {
        std::vector<FrameArms> arms(slots.size());
        FourRests rests;
        FourMotions motions;
        std::array<double, 36> C{}, fitted{};
        const int count = static_cast<int>(slots.size());
        EXPECT_EQ(kernels.measure(slots.data(), count, mesh.points().data(), arms.data(), rests, C.data()),
                  15);
        EXPECT_EQ(kernels.fit(slots.data(), arms.data(), count, rests, after.data(), motions, fitted.data()),
                  15);
        const FrameMap map{{{1, 2, 3, 0}, {4, 5, 6, 0}, {7, 8, 9, 0}, {.1, .2, .3, 0}}};
        const std::array<int, 3> offsets{0, 1, 3}, frames{0, 0, 0}, vertices{1, 2, 4};
        const std::array<double, 3> shares{1, .4, .6};
        Points carried = after, bent = after, ridden = after, entered = after;
        kernels.carry(map, vertices.data(), 2, mesh.points().data(), carried.data());
        kernels.bend(&map, offsets.data(), frames.data(), shares.data(), vertices.data(), 2,
                     mesh.points().data(), bent.data());
        EXPECT_LT(shapes::distance(carried, bent), 1e-14);
        const std::array<int, 3> middle{1, 2, 3};
        Points one_by_one = after, in_a_row = after;
        kernels.carry(map, middle.data(), 3, mesh.points().data(), one_by_one.data());
        kernels.carry_row(map, 3, mesh.points().data() + 3, in_a_row.data() + 3);
        EXPECT_EQ(in_a_row, one_by_one) << "and nothing behind the row is written";
        LooseSlot slot = loose;
        kernels.place(&slot, 1, mesh.points().data());
        kernels.ride(&slot, 1, nullptr, ridden.data());
        kernels.ride(&slot, 1, mesh.points().data(), entered.data());
        EXPECT_EQ(ridden, entered);
        std::vector<double> all(sizeof motions / sizeof(double));
        std::memcpy(all.data(), &motions, sizeof motions);
        for (const Points* points : {&carried, &bent, &ridden})
            all.insert(all.end(), points->data(), points->data() + points->size());
        return all;
    };
    const std::vector<double> expected = run(FrameKernels::baseline);
    for (const FrameKernels* kernels : wide_kernels<FrameKernels>())
        EXPECT_EQ(run(*kernels), expected);
}

} // namespace sinew::test_frame_kernels

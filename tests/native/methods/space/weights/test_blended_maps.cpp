// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/weights/blended_maps.h"

#include "tests/native/shapes.h"

#include <gtest/gtest.h>

namespace sinew::test_blended_maps {

namespace {

struct Some
{
    static constexpr int maps = 6, count = 5000;
    BlendedMaps blended;
    std::vector<std::vector<BlendedMaps::Share>> shares;
    Poses moves;
    Points at;
    Some()
    {
        shapes::Random random(8);
        for (int i = 0; i < count; ++i) {
            std::vector<BlendedMaps::Share> own;
            for (int k = 0; k <= i % 5; ++k)
                own.push_back({(i + k) % maps, random.unit() + 0.01});
            blended.add(own);
            shares.push_back(own);
        }
        for (int j = 0; j < maps; ++j)
            moves.push_back(shapes::affine(random.matrix(), random.vector()));
        at = random.dense(count, 3);
    }
};

} // namespace

TEST(BlendedMaps, is_the_sum_of_the_formula)
{
    const Some some;
    const Vector3 centre(0.3, -2, 1);
    const Points base = 2.0 * some.at;
    Points out(Some::count, 3);
    some.blended.apply(some.moves, centre, view(some.at), view(base), out.data());
    for (int i = 0; i < Some::count; ++i) {
        double sum = 0.0;
        Vector3 move = Vector3::Zero();
        for (const auto& share : some.shares[i]) {
            sum += share.weight;
            move += share.weight * apply(some.moves[share.map], some.at.row(i).transpose() - centre);
        }
        // Weights are rounded to 24 bits; moves have lengths of about 5.
        EXPECT_LT((out.row(i).transpose() - base.row(i).transpose() - move / sum).norm(), 2e-6);
    }
    EXPECT_EQ(some.blended.bytes(), 4 * (Some::count + 1) + 8 * 3 * Some::count); // 3 shares on average
}

TEST(BlendedMaps, of_one_map_is_that_map_exactly)
{
    Some some;
    some.moves.assign(Some::maps, some.moves[2]);
    Points out(Some::count, 3), plain(Some::count, 3);
    some.blended.apply(some.moves, Vector3::Zero(), view(some.at), view(some.at), out.data());
    BlendedMaps alone;
    for (int i = 0; i < Some::count; ++i)
        alone.add({{0, 1.0}});
    alone.apply(some.moves, Vector3::Zero(), view(some.at), view(some.at), plain.data());
    EXPECT_EQ(out, plain);
}

} // namespace sinew::test_blended_maps

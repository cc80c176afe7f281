// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/arap_system.h"

#include "tests/native/local_global/arap/graphs.h"
#include "tests/native/shapes.h"

namespace sinew::test_arap_system {

TEST(ArapSystem, chunks_hold_every_edge_once_within_and_twice_across)
{
    for (const double smoothness : {0.0, 0.02})
        for (const bool rims : {false, true}) {
            SurfaceMesh mesh = shapes::sphere(4); // several chunks
            const auto low = shapes::where(mesh, [](const Vector3& p) { return p.z() < -0.5; });
            const ArapSystem graph = graphs::of(mesh, {{low, {}}}, smoothness, rims);
            const GraphChunks& chunks = graph.chunks();
            const GraphEdges& edges = graph.nodes().edges();
            ASSERT_GT(chunks.all.size(), 4u);
            const int moving = chunks.all[chunks.moving - 1].end;
            int next = 0;
            std::vector<int> chunk_of(graph.size());
            for (std::size_t c = 0; c < chunks.all.size(); ++c) {
                EXPECT_EQ(chunks.all[c].begin, next);
                EXPECT_LE(chunks.all[c].end - chunks.all[c].begin, graph_chunk);
                next = chunks.all[c].end;
                std::fill(chunk_of.begin() + chunks.all[c].begin, chunk_of.begin() + next,
                          static_cast<int>(c));
            }
            EXPECT_EQ(next, graph.size());
            for (int i = 0; i < graph.size(); ++i) {
                EXPECT_EQ(graph.nodes().place(i), i < graph.free_count() ? i : -1);
                int within = 0, across = 0;
                for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a) {
                    const int j = edges.neighbours[a];
                    within += chunk_of[i] == chunk_of[j] && i < j;
                    across += chunk_of[i] != chunk_of[j];
                    // Cells that do not move belong to held nodes among held ones.
                    if (i < graph.free_count()) {
                        EXPECT_LT(j, moving);
                    }
                }
                EXPECT_EQ(chunks.edges[2 * i + 1] - chunks.edges[2 * i], within);
                EXPECT_EQ(chunks.edges[2 * i + 2] - chunks.edges[2 * i + 1], across);
            }
            EXPECT_EQ(moving < graph.size(), smoothness == 0);
        }
}

} // namespace sinew::test_arap_system

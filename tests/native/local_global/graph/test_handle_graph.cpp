// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/graph/handle_graph.h"

#include "tests/native/local_global/graph/mesh_graph.h"

namespace sinew::test_handle_graph {

std::map<std::pair<int, int>, double> entries(const GraphEdges& edges, const std::vector<int>& names)
{
    std::map<std::pair<int, int>, double> found;
    for (int i = 0; i < edges.size(); ++i)
        for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a)
            found[{names[i], names[edges.neighbours[a]]}] = edges.weights[a];
    return found;
}

TEST(HandleGraph, says_of_each_node_what_the_regions_say_of_its_vertex)
{
    const graphs::BarAndSphere setting(0.3);
    const HandleGraph& graph = setting.graph;
    int free = 0;
    for (int i = 0; i < graph.size(); ++i) {
        EXPECT_EQ(graph.hard(i), setting.regions.hard(i));
        EXPECT_EQ(graph.is_idle(i), setting.regions.is_idle(i));
        EXPECT_EQ(graph.place(i), setting.regions.is_free(i) ? free : -1);
        if (setting.regions.is_free(i)) {
            EXPECT_EQ(graph.free_nodes()[free++], i);
        }
    }
    EXPECT_EQ(graph.free_count(), free);
    ASSERT_EQ(graph.pulls().size(), setting.regions.soft().size());
    for (std::size_t k = 0; k < graph.pulls().size(); ++k)
        EXPECT_EQ(graph.pulls()[k].stiffness, setting.regions.soft()[k].stiffness());
}

TEST(HandleGraph, soft_pulls_are_in_units_of_the_diagonal)
{
    const graphs::BarAndSphere setting(0.5);
    const GraphHandles doubled(setting.regions, [](int vertex) { return vertex % 2 ? 2.0 : 0.0; });
    ASSERT_FALSE(doubled.pulls.empty());
    for (const GraphPull& pull : doubled.pulls)
        EXPECT_EQ(pull.stiffness, pull.node % 2 ? 2.0 : 1.0); // 1 where there is no diagonal
}

TEST(HandleGraph, is_the_same_by_other_numbers)
{
    const graphs::BarAndSphere setting(0.3);
    const HandleGraph& graph = setting.graph;
    const std::vector<int> same = shapes::numbers(0, graph.size());
    std::vector<int> old(graph.size());
    for (int i = 0; i < graph.size(); ++i)
        old[i] = (7 * i) % graph.size();
    ASSERT_NE(graph.size() % 7, 0);
    const HandleGraph renumbered = graph.renumbered(old);
    EXPECT_EQ(entries(renumbered.edges(), old), entries(graph.edges(), same));
    for (int i = 0; i < graph.size(); ++i) {
        EXPECT_EQ(renumbered.hard(i), graph.hard(old[i]));
        EXPECT_EQ(renumbered.is_idle(i), graph.is_idle(old[i]));
        const auto first = renumbered.edges().neighbours.begin();
        EXPECT_TRUE(
            std::is_sorted(first + renumbered.edges().offsets[i], first + renumbered.edges().offsets[i + 1]));
    }
    for (std::size_t k = 0; k < graph.pulls().size(); ++k)
        EXPECT_EQ(old[renumbered.pulls()[k].node], graph.pulls()[k].node);
    const std::vector<int> renamed = new_numbers(old);
    for (int i = 0; i < graph.size(); ++i)
        EXPECT_EQ(renamed[old[i]], i);
}

} // namespace sinew::test_handle_graph

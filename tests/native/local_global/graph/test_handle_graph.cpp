// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/graph/handle_graph.h"

#include "tests/native/local_global/graph/mesh_graph.h"

namespace sinew::test_handle_graph {

// Other tests see it through what is solved with it.
TEST(HandleGraph, soft_pulls_are_in_units_of_the_diagonal)
{
    const graphs::BarAndSphere setting(0.5);
    const GraphHandles doubled(setting.regions, [](int vertex) { return vertex % 2 ? 2.0 : 0.0; });
    ASSERT_FALSE(doubled.pulls.empty());
    for (const GraphPull& pull : doubled.pulls)
        EXPECT_EQ(pull.stiffness, pull.node % 2 ? 2.0 : 1.0); // 1 where there is no diagonal
}

} // namespace sinew::test_handle_graph

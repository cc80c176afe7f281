// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/graph/clusters.h"

#include "tests/native/local_global/graph/mesh_graph.h"

namespace sinew::test_clusters {

/// Clusters of a graph and, in a second step, clusters of these.
struct Level
{
    ClusterMap map;
    HandleGraph graph;
    Points rest;

    Level(const HandleGraph& finer, const Points& finer_rest, int wanted)
        : map(finer, Clusters(finer, finer_rest, wanted)), graph(graph_of_clusters(finer, finer_rest, map)),
          rest(map.restrict(view(finer_rest)))
    {
    }
};

struct Setting : graphs::BarAndSphere
{
    Level middle, coarse;

    explicit Setting(double weight = 1.0)
        : BarAndSphere(weight), middle(graph, mesh.points(), graph.size() / 4),
          coarse(middle.graph, middle.rest, middle.graph.size() / 4)
    {
    }

    std::vector<std::pair<const HandleGraph*, const Level*>> steps() const
    {
        return {{&graph, &middle}, {&middle.graph, &coarse}};
    }
};

TEST(Clusters, are_as_many_as_wanted_and_reach_as_far_as_they_say)
{
    const Setting setting;
    const Clusters clusters(setting.graph, setting.mesh.points(), 50);
    EXPECT_EQ(clusters.seeds.size(), 50u);
    for (std::size_t c = 0; c < clusters.seeds.size(); ++c)
        EXPECT_EQ(clusters.label[clusters.seeds[c]], static_cast<int>(c));
    for (int i = 0; i < setting.graph.size(); ++i)
        if (clusters.label[i] >= 0) {
            const Vector3 seed = setting.mesh.point(clusters.seeds[clusters.label[i]]);
            EXPECT_LE((setting.mesh.point(i) - seed).norm(), clusters.radius * clusters.unit * (1 + 1e-12));
        }
}

TEST(Clusters, do_not_depend_on_last_bits_of_the_rest_shape_or_on_the_order_of_nodes)
{
    const Setting setting;
    const double size = shapes::size(setting.mesh.points());
    Points rest = setting.mesh.points() / size; // bent, as numbers decide where there is a symmetry
    for (int i = 0; i < rest.rows(); ++i) {
        const Vector3 p = rest.row(i).transpose();
        const Vector3 bend(0.3 * p.y() * p.y(), 0.4 * p.y() + 0.3 * p.z() * p.x(), 0.2 * p.x() * p.x());
        rest.row(i) = size * (p + bend).transpose();
    }
    const Clusters clusters(setting.graph, rest, setting.graph.size() / 4);

    const Clusters again(setting.graph, shapes::Random(5).shaken(rest, 1e-8), setting.graph.size() / 4);
    EXPECT_EQ(again.seeds, clusters.seeds);
    EXPECT_EQ(again.label, clusters.label);

    std::vector<int> reversed = shapes::numbers(0, setting.graph.size());
    std::ranges::reverse(reversed);
    const Points others = rest.colwise().reverse();
    const Clusters turned(setting.graph.renumbered(reversed), others, setting.graph.size() / 4);
    for (int i = 0; i < rest.rows(); ++i)
        EXPECT_EQ(turned.label[i], clusters.label[reversed[i]]);
}

TEST(Clusters, hold_every_node_but_the_idle_ones_and_never_cross_the_border_of_a_handle)
{
    const Setting setting;
    for (const auto& [finer, level] : setting.steps()) {
        std::vector<std::vector<int>> nodes(level->graph.size());
        for (int i = 0; i < finer->size(); ++i) {
            const int cluster = level->map.label()[i];
            EXPECT_EQ(cluster < 0, finer->is_idle(i));
            if (cluster < 0)
                continue;
            nodes[cluster].push_back(i);
            EXPECT_EQ(level->graph.hard(cluster), finer->hard(i));
            const ClusterMap::Shares shares = level->map.shares(i);
            const Eigen::Map<const VectorX> weights(shares.weights, shares.count);
            EXPECT_GE(weights.minCoeff(), 0.0);
            EXPECT_NEAR(weights.sum(), 1.0, 1e-14); // some ten shares
        }
        for (int p = 0; p < level->map.cluster_count(); ++p) {
            EXPECT_TRUE(std::ranges::equal(nodes[p], level->map.nodes(p)));
            EXPECT_FALSE(nodes[p].empty());
        }
    }
}

TEST(Clusters, edges_between_them_are_symmetric_and_positive)
{
    const Setting setting;
    for (const auto& [finer, level] : setting.steps()) {
        const GraphEdges& edges = level->graph.edges();
        std::map<std::pair<int, int>, double> weights;
        for (int p = 0; p < edges.size(); ++p)
            for (int a = edges.offsets[p]; a < edges.offsets[p + 1]; ++a)
                weights[{p, edges.neighbours[a]}] = edges.weights[a];
        for (const auto& [edge, weight] : weights) {
            EXPECT_GT(weight, 0.0);
            EXPECT_NEAR((weights[{edge.second, edge.first}]), weight, 1e-13 * weight); // another order
        }
    }
}

TEST(Clusters, restriction_takes_means)
{
    const Setting setting;
    const std::vector<int>& label = setting.middle.map.label();
    std::vector<double> heights;
    for (int i = 0; i < setting.graph.size(); ++i)
        heights.push_back(setting.mesh.point(i).z());
    const std::vector<double> means = setting.middle.map.restrict(heights);
    for (int p = 0; p < setting.middle.graph.size(); p += 11) {
        Vector3 mean = Vector3::Zero();
        for (int i = 0; i < setting.graph.size(); ++i)
            if (label[i] == p)
                mean += setting.mesh.point(i) / static_cast<double>(setting.middle.map.nodes(p).size());
        EXPECT_LT((setting.middle.rest.row(p).transpose() - mean).norm(), 1e-12);
        EXPECT_NEAR(means[p], mean.z(), 1e-12);
    }
}

TEST(Clusters, keep_the_sum_of_soft_pulls)
{
    const Setting setting(0.3);
    const auto total = [](const HandleGraph& graph) {
        double sum = 0.0;
        for (const GraphPull& pull : graph.pulls())
            sum += pull.stiffness;
        return sum;
    };
    EXPECT_GT(total(setting.graph), 0.0);
    for (const auto& [finer, level] : setting.steps())
        EXPECT_NEAR(total(level->graph), total(setting.graph), 1e-10 * total(setting.graph));
}

TEST(Clusters, are_the_same_by_other_numbers)
{
    const Setting setting;
    const int count = setting.middle.graph.size();
    std::vector<int> old = shapes::numbers(0, count);
    std::ranges::reverse(old);
    ClusterMap map = setting.middle.map;
    map.renumber(old);
    const Points means = map.restrict(view(setting.mesh.points()));
    for (int p = 0; p < count; ++p) {
        EXPECT_TRUE(std::ranges::equal(map.nodes(p), setting.middle.map.nodes(old[p])));
        EXPECT_EQ(means.row(p), setting.middle.rest.row(old[p]));
    }
    for (int i = 0; i < setting.graph.size(); ++i)
        for (int k = 0; k < map.shares(i).count; ++k)
            EXPECT_EQ(old[map.shares(i).clusters[k]], setting.middle.map.shares(i).clusters[k]);
}

} // namespace sinew::test_clusters

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/primo/prisms.h"

#include "native/local_global/bodies/body_problem.h"
#include "native/mesh/components.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_prisms {

namespace {

constexpr double height = 0.3;

/// The prisms of a mesh with one handle, whose rotations an evaluation leaves as they are.
struct Setting
{
    SurfaceMesh mesh;
    Regions regions;
    Prisms prisms;
    ArapSystem graph;
    PrismShape shape;
    RigidBodies bodies;
    Points pulls;

    Setting(const SurfaceMesh& given, const std::vector<int>& held)
        : mesh(given), regions({{held, {}}}, connected_components(given)),
          prisms(mesh, regions, std::vector<double>(mesh.vertex_count(), height)),
          graph(prisms.graph(regions), {.rigidity = std::vector<double>(prisms.size(), 1.0), .triangles = {}},
                at_rest().centres),
          shape(in_order()), bodies(graph, prisms.joints(), shapes(), 0)
    {
    }
    RigidBodies::Shapes shapes() const
    {
        return [this](int k) { return prisms.joint_shape(k, shape); };
    }
    double energy(const Points& centres, const std::vector<Matrix3>& rotations) const
    {
        BodyProblem problem(graph, bodies, bodies.rest_numbers(), centres, pulls);
        for (int b = 0; b < prisms.size(); ++b)
            problem.set_rotation(b, rotations[b]);
        Points gradient;
        return problem.evaluate(centres.topRows(graph.free_count()), gradient);
    }

private:
    PrismShape at_rest() const
    {
        PrismShape result;
        prisms.set_shape(view(mesh.points()), result);
        return result;
    }
    PrismShape in_order()
    {
        prisms.renumber(graph.order());
        return at_rest();
    }
};

} // namespace

TEST(Prisms, a_constant_gap_costs_its_square)
{
    const SurfaceMesh mesh = shapes::hill(5, 4);
    const Setting s(mesh, {0});
    const std::vector<Matrix3> still(s.prisms.size(), Matrix3::Identity());
    int body = 0; // a prism with three neighbours, none of whose corners is held
    const auto joints_of = [&](int b) {
        double sum = 0.0;
        int count = 0;
        for (const BodyJoint& joint : s.prisms.joints())
            if (joint.body[0] == b || joint.body[1] == b) {
                sum += joint.weight;
                ++count;
            }
        return std::pair(sum, count);
    };
    while (joints_of(body).second != 3)
        ++body;
    Points centres = s.shape.centres;
    centres.row(body) += Eigen::RowVector3d(.3, 0, .4);
    EXPECT_NEAR(s.energy(centres, still), 0.5 * joints_of(body).first * 0.25, 1e-14);
}

TEST(Prisms, a_prism_is_held_where_all_of_its_corners_are)
{
    const Setting s(shapes::quad_grid(4, 4), {0, 1, 5, 6, 2});
    int held = 0, vertices = 0;
    for (int b = 0; b < s.prisms.size(); ++b) {
        held += s.prisms.handle(b) >= 0 && !s.prisms.is_vertex(b);
        vertices += s.prisms.is_vertex(b);
    }
    EXPECT_EQ(held, 1); // the face 0, 1, 6, 5
    EXPECT_EQ(vertices, 4); // all but vertex 0, which no free face has
    EXPECT_EQ(s.prisms.body_of(0), -1);
    EXPECT_EQ(s.graph.free_count(), 15);
}

TEST(Prisms, faces_that_share_only_a_vertex_hang_together)
{
    const SurfaceMesh bow =
        shapes::mesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {0, 3, 4}});
    const Setting s(bow, {1});
    ASSERT_EQ(s.prisms.joints().size(), 2u); // that of both faces, and that of the held vertex
    EXPECT_EQ(s.graph.free_count(), 2);
}

TEST(Prisms, all_faces_at_an_edge_are_joined)
{
    std::vector<Vector3> points{{0, 0, 0}, {0, 0, 1}};
    shapes::Polygons faces;
    for (int k = 0; k < 4; ++k) {
        points.emplace_back(std::cos(1.5 * k), std::sin(1.5 * k), 0.5);
        faces.push_back({0, 1, 2 + k});
    }
    EXPECT_EQ(Setting(shapes::mesh(points, faces), {2}).prisms.joints().size(), 7u); // 6, and the vertex
}

} // namespace sinew::test_prisms

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/bodies/body_problem.h"

#include "native/local_global/rows/row_problem.h"
#include "tests/native/local_global/arap/graphs.h"
#include "tests/native/shapes.h"

namespace sinew::test_body_problem {

/// Bodies at the vertices of a sphere, joined along its edges by random joints, and held at the poles.
struct Setting
{
    SurfaceMesh mesh = shapes::sphere(3); // more than one chunk
    ArapSystem graph;
    std::vector<BodyJoint> joints;
    std::vector<std::array<Vector3, 5>> vectors; ///< p, q and three for the form
    RigidBodies bodies;
    RowSystem table;
    Points centres, pulls;

    explicit Setting(int sweeps)
        : graph(graphs::of(mesh, graphs::poles(mesh), 0.0)), bodies(graph, random_joints(), shapes(), sweeps),
          table(rows(), mesh.points(), held(), held(), {.field = sweeps > 0, .sweeps = sweeps}),
          centres(sinew::shapes::Random(9).shaken(mesh.points(), 0.1))
    {
    }
    BodyProblem problem() const { return {graph, bodies, bodies.rest_numbers(), centres, pulls}; }
    /// Where the free bodies are.
    Points free() const { return centres.topRows(graph.free_count()); }
    RigidBodies::Shapes shapes() const
    {
        return [this](int k) {
            const auto& v = vectors[k];
            Matrix3 form = Matrix3::Zero();
            for (int a : {2, 3, 4})
                form += v[a] * v[a].transpose();
            return JointShape{{v[0], v[1]}, form};
        };
    }
    void turn(BodyProblem& problem, RowProblem& oracle) const
    {
        shapes::Random random(4);
        for (int i = 0; i < graph.size(); ++i) {
            const Matrix3 R = shapes::rotation(random.vector(), 20 * random.unit());
            problem.set_rotation(i, R);
            oracle.set_rotation(i, R);
        }
    }

private:
    std::vector<BodyJoint> random_joints()
    {
        shapes::Random random(2);
        const GraphEdges& edges = graph.nodes().edges();
        for (int i = 0; i < graph.size(); ++i)
            for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a) {
                const int j = edges.neighbours[a];
                if (i > j || (i >= graph.free_count() && j >= graph.free_count()))
                    continue;
                const bool flipped = random.unit() < 0.5; // a joint may begin at either body
                joints.push_back({{flipped ? j : i, flipped ? i : j}, edges.weights[a]});
                vectors.push_back({0.2 * random.vector(), 0.2 * random.vector(), 0.1 * random.vector(),
                                   0.1 * random.vector(), 0.1 * random.vector()});
            }
        return joints;
    }
    std::vector<bool> held() const
    {
        std::vector<bool> flags(graph.size());
        for (int i = 0; i < graph.size(); ++i)
            flags[i] = i >= graph.free_count();
        return flags;
    }
    RowTable rows() const
    {
        RowTable result(graph.size(), graph.size());
        for (std::size_t k = 0; k < joints.size(); ++k) {
            const auto [a, b] = joints[k].body;
            const double w = joints[k].weight;
            const RowTable::Term terms[]{{a, 1.0}, {b, -1.0}};
            result.add(w, terms, a, -vectors[k][0], b, vectors[k][1]);
            for (int v : {2, 3, 4})
                result.add(w, {}, a, vectors[k][v], b, -vectors[k][v]);
        }
        return result;
    }
};

TEST(BodyProblem, energy_and_gradient_are_those_of_a_table_of_rows)
{
    const Setting setting(0);
    BodyProblem problem = setting.problem();
    RowProblem oracle(setting.table, setting.table.rest_vectors(), setting.centres);
    setting.turn(problem, oracle);
    Points gradient, expected;
    const Points x = setting.free();
    const double E = problem.evaluate(x, gradient);
    EXPECT_NEAR(E, oracle.evaluate(setting.table.free_rows(view(setting.centres)), expected), 1e-12 * E);
    Points all = Points::Zero(setting.graph.size(), 3), solved, solved_by_oracle;
    all.topRows(gradient.rows()) = gradient;
    EXPECT_LT(shapes::distance(setting.table.free_rows(view(all)), expected), 1e-12);
    problem.centres_for_rotations(solved);
    oracle.global_step(solved_by_oracle);
    oracle.place(solved_by_oracle, all);
    EXPECT_LT(shapes::distance(solved, all.topRows(setting.graph.free_count())), 1e-11);

    double sum = 0.0; // by the definition
    for (std::size_t k = 0; k < setting.joints.size(); ++k) {
        const auto [a, b] = setting.joints[k].body;
        const Matrix3 A = problem.rotation(a), B = problem.rotation(b);
        const auto& v = setting.vectors[k];
        sum +=
            setting.joints[k].weight *
            ((setting.centres.row(a).transpose() + A * v[0] - setting.centres.row(b).transpose() - B * v[1])
                 .squaredNorm() +
             ((A - B) * v[2]).squaredNorm() + ((A - B) * v[3]).squaredNorm() +
             ((A - B) * v[4]).squaredNorm());
    }
    EXPECT_NEAR(E, 0.5 * sum, 1e-12 * E);
}

TEST(BodyProblem, rotations_move_as_those_of_a_table_of_rows)
{
    for (int sweeps : {1, 3}) {
        const Setting setting(sweeps);
        BodyProblem problem = setting.problem();
        RowProblem oracle(setting.table, setting.table.rest_vectors(), setting.centres);
        setting.turn(problem, oracle);
        Points gradient, expected, all = Points::Zero(setting.graph.size(), 3);
        const double E = problem.evaluate(setting.free(), gradient);
        // Factors in single precision, and the tie to the former rotation.
        EXPECT_NEAR(oracle.evaluate(setting.table.free_rows(view(setting.centres)), expected), E, 1e-6 * E);
        for (int i = 0; i < setting.graph.size(); ++i)
            EXPECT_LT((problem.rotation(i) - oracle.rotation(i)).norm(), 1e-5) << i;
        all.topRows(gradient.rows()) = gradient;
        EXPECT_LT(shapes::distance(setting.table.free_rows(view(all)), expected), 1e-5);
    }
}

TEST(BodyProblem, a_rejected_step_leaves_the_rotations_that_were_kept)
{
    const Setting setting(2);
    BodyProblem problem = setting.problem();
    Points gradient;
    const Points x = setting.free();
    problem.evaluate(x, gradient);
    std::vector<Matrix3> kept;
    for (int i = 0; i < setting.graph.size(); ++i)
        kept.push_back(problem.rotation(i));
    problem.keep_state();
    for (int k = 0; k < 3; ++k)
        problem.evaluate(2 * x, gradient);
    EXPECT_NE(problem.rotation(0), kept[0]);
    problem.restore_state();
    for (int i = 0; i < setting.graph.size(); ++i)
        EXPECT_EQ(problem.rotation(i), kept[i]);
}

} // namespace sinew::test_body_problem

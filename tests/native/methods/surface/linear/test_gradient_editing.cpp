// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/gradient_editing.h"

#include "native/handles/constrained_system.h"
#include "native/operators/laplacian.h"
#include "tests/native/allocations.h"
#include "tests/native/dense.h"
#include "tests/native/methods/surface/contract.h"
#include "tests/native/methods/surface/linear/study_tube.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <cmath>

namespace sinew::test_gradient_editing {

namespace {

const Poses bent{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};

auto maker(Field field)
{
    return [field](const SurfaceMesh& mesh) {
        return std::make_shared<GradientEditing>(mesh, GradientEditingOptions{field});
    };
}

Points solved(const SurfaceMesh& mesh, const std::vector<Handle>& handles, const SolveRequest& request,
              SolveReport* report = nullptr, Field field = Field::harmonic)
{
    GradientEditing editing(mesh, {field});
    editing.set_handles(handles);
    Points positions;
    const SolveReport found = editing.solve(request, positions);
    if (report)
        *report = found;
    return positions;
}

SurfaceTraits traits()
{
    const auto drag = [](double t) {
        const double angle = 2 * shapes::pi * t;
        return Poses{shapes::still(), shapes::turn({0, 1, 0}, 60 * std::sin(angle), {9, 4, 0},
                                                   {2 * std::cos(angle) - 2, std::sin(angle), 0})};
    };
    return {.name = "GradientEditing",
            .variants = {{"harmonic", maker(Field::harmonic)}, {"geodesic", maker(Field::geodesic)}},
            .mesh = shapes::hill(8, 8),
            .large = shapes::hill(10, 9),
            .depth = 1.5,
            .bent = bent,
            .drag = drag,
            .drag_steps = 48,
            .follow = 2.0, // where the surface bends outwards, it goes farther than the handle
            .slack = 0.0,
            .translation = 1e-11,
            .rigid = 1e-12, // a condition of 1e3
            .similar = 1e-10,
            .scaled = 1e-10,
            .updates = "field",
            .updated = maker(Field::geodesic)};
}

/// The method once more for two handles: gradients by planes through three points, a harmonic field and
/// positions by dense matrices, rotations by slerp.
class DenseGradients
{
public:
    DenseGradients(const SurfaceMesh& mesh, const std::vector<Handle>& handles)
        : mesh_(mesh), n_(mesh.vertex_count()), held_(n_, -1), G_(3 * mesh.triangles().size(), n_),
          D_(3 * mesh.triangles().size())
    {
        for (int h : {0, 1})
            for (int v : handles[h].vertices)
                held_[v] = h;
        for (int v = 0; v < n_; ++v)
            if (held_[v] < 0)
                free_.push_back(v);
        G_.setZero();
        for (int t = 0; t < triangles(); ++t) {
            const auto [i, j, k] = mesh.triangles()[t];
            const Vector3 u = mesh.point(j) - mesh.point(i), v = mesh.point(k) - mesh.point(i);
            Matrix3 frame; // grad . u = f_j - f_i, grad . v = f_k - f_i, grad . n = 0
            frame << u.transpose(), v.transpose(), u.cross(v).transpose();
            const Matrix3 slopes = frame.inverse();
            G_.block<3, 1>(3 * t, j) = slopes.col(0);
            G_.block<3, 1>(3 * t, k) = slopes.col(1);
            G_.block<3, 1>(3 * t, i) = -slopes.col(0) - slopes.col(1);
            D_.segment<3>(3 * t).setConstant(0.5 * u.cross(v).norm());
        }
        L_ = G_.transpose() * D_.asDiagonal() * G_;
        MatrixX s = MatrixX::Zero(n_, 1);
        for (int v = 0; v < n_; ++v)
            s(v, 0) = held_[v] == 1;
        field_ = solve(dense::with_positive_weights(L_), s, MatrixX::Zero(n_, 1));
    }

    /// \param R, S, move  of the second handle; the first rests.
    Points solve(const Points& y, const Matrix3& R, const Matrix3& S, const Vector3& move,
                 double* energy) const
    {
        MatrixX target = y, G = G_ * y;
        for (int v = 0; v < n_; ++v)
            if (held_[v] == 1)
                target.row(v) = (R * S * y.row(v).transpose() + move).transpose();
        for (int t = 0; t < triangles(); ++t) {
            double s = 0.0, touched = -1;
            bool both = false;
            for (int v : mesh_.triangles()[t]) {
                s += field_(v, 0) / 3;
                both = both || (touched >= 0 && held_[v] >= 0 && held_[v] != touched);
                touched = held_[v] >= 0 ? held_[v] : touched;
            }
            if (touched >= 0 && !both)
                s = touched;
            const Matrix3 turn =
                Eigen::Quaterniond::Identity().slerp(s, Eigen::Quaterniond(R)).toRotationMatrix();
            G.middleRows<3>(3 * t) *= (turn * (s * S + (1 - s) * Matrix3::Identity())).transpose();
        }
        const MatrixX x = solve(L_, target, G_.transpose() * D_.asDiagonal() * G);
        const MatrixX misfit = G_ * x - G;
        *energy = 0.5 * (misfit.transpose() * D_.asDiagonal() * misfit).trace();
        return x;
    }

private:
    int triangles() const { return static_cast<int>(mesh_.triangles().size()); }
    MatrixX solve(const MatrixX& L, const MatrixX& x, const MatrixX& b) const
    {
        return dense::solution(L, b, x, free_);
    }

    const SurfaceMesh& mesh_;
    int n_;
    std::vector<int> held_, free_;
    MatrixX G_;
    VectorX D_;
    MatrixX L_, field_;
};

} // namespace

INSTANTIATE_TEST_SUITE_P(GradientEditing, SurfaceContract, testing::Values(traits()));

TEST(GradientEditing, solves_as_dense_gradients_do)
{
    shapes::Random random(6);
    for (const SurfaceMesh& mesh : {shapes::hill(8, 8), shapes::bar(6, 2), shapes::sphere(2)}) {
        const std::vector<Handle> handles = shapes::ends(mesh, shapes::size(mesh.points()) / 8);
        const DenseGradients dense(mesh, handles);
        const Points incoming = mesh.points() + 0.3 * random.dense(mesh.vertex_count(), 3);
        for (const Points& y : {mesh.points(), incoming})
            for (double degrees : {0.0, 40.0, 170.0, -90.0}) {
                const Matrix3 A = random.matrix(), R = shapes::rotation(random.vector(), degrees),
                              S = Matrix3::Identity() + 0.2 * (A + A.transpose());
                const Vector3 move = random.vector();
                double energy = 0.0;
                SolveReport report;
                const Points expected = dense.solve(y, R, S, move, &energy);
                const Points found = solved(
                    mesh, handles,
                    {.poses = {shapes::still(), shapes::affine(R * S, move)}, .incoming = view(y)}, &report);
                EXPECT_LT(shapes::distance(found, expected), 1e-11 * shapes::size(expected));
                EXPECT_NEAR(report.energy, energy, 1e-11 * (energy + 1));
                EXPECT_LT(report.residual, 1e-11);
                EXPECT_EQ(report.iterations, 1);
            }
    }
}

TEST(GradientEditing, one_affine_map_of_all_handles_is_exact)
{
    const SurfaceMesh mesh = shapes::hill(9, 8);
    Matrix3 A;
    A << 1.2, 0.3, 0, -0.4, 0.8, 0.1, 0.5, 0.2, -2; // it reflects
    const Pose pose = shapes::affine(A, {1, 2, 3});
    for (Field field : {Field::harmonic, Field::geodesic})
        for (double weight : {1.0, 0.3}) {
            std::vector<Handle> handles = shapes::ends(mesh, 1.5);
            handles.push_back({{45}, {}});
            handles[1].weights.assign(handles[1].vertices.size(), weight);
            EXPECT_LT(shapes::distance(solved(mesh, handles, {.poses = Poses(3, pose)}, nullptr, field),
                                       shapes::transformed(mesh.points(), pose)),
                      1e-11);
        }
}

TEST(GradientEditing, is_blind_to_translations_which_spread_as_a_harmonic_field_does)
{
    // T = I turns nothing: L d = 0, and d is the field of the handle times its move. On a regular tube, the
    // field is linear: every cross section keeps its shape and direction, and the tube is sheared.
    const SurfaceMesh mesh = study_tube();
    const Vector3 move(0.3, 7, -2);
    const Points q = solved(mesh, shapes::ends(mesh, 3.1),
                            {.poses = {shapes::still(), shapes::shift(move.x(), move.y(), move.z())}});
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        const double s = std::clamp((mesh.point(v).x() - 3) / 14, 0.0, 1.0);
        EXPECT_LT((q.row(v).transpose() - mesh.point(v) - s * move).norm(), 1e-11);
    }
}

TEST(GradientEditing, bends_a_tube_by_120_degrees_about_as_well_as_a_beam_bends)
{
    // The isometric bend of the axis has .0580; the study measured .0565 by this method.
    const SurfaceMesh mesh = study_tube();
    const std::vector<Handle> handles = shapes::ends(mesh, study_depth);
    const Poses poses{shapes::still(), study_bend()};
    for (Field field : {Field::harmonic, Field::geodesic})
        EXPECT_NEAR(rms_edge_ratio(mesh, solved(mesh, handles, {.poses = poses}, nullptr, field)), 0.0565,
                    0.0005);
    // With gradients that nobody turns (Figure 15b) it is far worse.
    ConstrainedSystem poisson;
    poisson.factorize(std::make_shared<SparseMatrix>(laplacian_matrix(mesh, Discretization::cotan)),
                      Regions(handles, connected_components(mesh)));
    Points unturned;
    poisson.solve({poses, view(mesh.points()), {}, nullptr}, unturned);
    EXPECT_GT(rms_edge_ratio(mesh, unturned), 0.2);
}

TEST(GradientEditing, a_handle_that_rides_on_what_posed_the_mesh_does_not_turn_details_twice)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const Pose pose = shapes::turn({1, 2, -0.5}, 120, {3, 7, 1}, {3, -2, 1});
    const Points incoming = shapes::transformed(mesh.points(), pose);
    const Points q = solved(mesh, shapes::ends(mesh, 1.5),
                            {.poses = {shapes::still(), pose},
                             .incoming = view(incoming),
                             .from_rest = std::vector<bool>{false, true}});
    EXPECT_LT(shapes::distance(q, incoming), 1e-11);
}

TEST(GradientEditing, says_where_a_rule_chose_the_way_of_half_a_turn)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    for (const auto& [degrees, vertices] : {std::pair{179.0, 0}, {180.0, 81}}) {
        SolveReport report;
        solved(mesh, shapes::ends(mesh, 1.5), {.poses = {shapes::still(), shapes::turn({1, 2, 0}, degrees)}},
               &report);
        EXPECT_EQ(report.half_turns, vertices);
    }
}

TEST(GradientEditing, handles_of_other_parts_do_not_count)
{
    const SurfaceMesh mesh = shapes::hill(8, 8), both = shapes::joined(mesh, mesh, {0, 20, 0});
    const int n = mesh.vertex_count();
    std::vector<Handle> handles = shapes::ends(mesh, 1.5), more = handles;
    more.push_back({{n + 3, n + 40}, {}});
    more.push_back({{n + 70}, {}});
    const Poses poses{bent[0], bent[1], shapes::turn({1, 0, 1}, 140), shapes::turn({0, 1, 1}, -150)};
    for (Field field : {Field::harmonic, Field::geodesic})
        EXPECT_LT(shapes::distance(solved(both, more, {.poses = poses}, nullptr, field).topRows(n),
                                   solved(mesh, handles, {.poses = bent}, nullptr, field)),
                  1e-12);
}

TEST(GradientEditing, solves_after_the_first_allocate_nothing_in_proportion_to_the_mesh)
{
    if (!allocations::counted())
        GTEST_SKIP() << "nobody counts here";
    const SurfaceMesh mesh = shapes::hill(60, 60);
    GradientEditing editing(mesh);
    editing.set_handles(shapes::ends(mesh, 1.5));
    Points positions;
    const allocations::Count count(sizeof(double) * mesh.vertex_count());
    editing.solve({bent}, positions);
    const int first = count.so_far();
    EXPECT_GT(first, 0);
    for (int k = 0; k < 3; ++k)
        editing.solve({bent}, positions);
    EXPECT_EQ(count.so_far(), first);
}

} // namespace sinew::test_gradient_editing

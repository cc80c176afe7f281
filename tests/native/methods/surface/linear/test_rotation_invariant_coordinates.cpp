// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/rotation_invariant_coordinates.h"

#include "native/methods/surface/linear/gradient_editing.h"
#include "tests/native/allocations.h"
#include "tests/native/methods/surface/contract.h"
#include "tests/native/methods/surface/linear/study_tube.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>

#include <cmath>

namespace sinew::test_rotation_invariant_coordinates {

namespace {

constexpr std::array every{Discretization::cotan, Discretization::uniform};
const Poses bent{shapes::still(), shapes::turn({0, 1, 0}, 40, {6, 0, 0}, {-1, 0.5, 2})};

auto maker(Discretization laplacian)
{
    return [laplacian](const SurfaceMesh& mesh) {
        return std::make_shared<RotationInvariantCoordinates>(mesh,
                                                              RotationInvariantCoordinatesOptions{laplacian});
    };
}

Points solved(const SurfaceMesh& mesh, const std::vector<Handle>& handles, const SolveRequest& request,
              SolveReport* report = nullptr, Discretization laplacian = Discretization::cotan)
{
    RotationInvariantCoordinates method(mesh, {laplacian});
    method.set_handles(handles);
    Points positions;
    const SolveReport found = method.solve(request, positions);
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
    return {
        .name = "RotationInvariantCoordinates",
        .variants = {{"cotan", maker(Discretization::cotan)}, {"uniform", maker(Discretization::uniform)}},
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
        .other = maker(Discretization::uniform)};
}

/// The statement of the paper for two handles, the first at rest: frames of rest, rotations between them, the
/// frames that keep these by least squares, and positions by least squares over the edges. By dense matrices.
class PaperStatement
{
public:
    PaperStatement(const SurfaceMesh& mesh, const std::vector<Handle>& handles, Discretization kind)
        : mesh_(mesh), n_(mesh.vertex_count()), held_(n_, -1), W_(MatrixX::Zero(n_, n_))
    {
        for (int h : {0, 1})
            for (int v : handles[h].vertices)
                held_[v] = h;
        const auto add = [&](int i, int j, double w) {
            W_(i, j) += w;
            W_(j, i) += w;
        };
        if (kind == Discretization::uniform)
            for (const auto& [i, j] : mesh.edges())
                add(i, j, 1.0);
        else
            for (const auto& [i, j, k] : mesh.triangles()) {
                add(i, j, 0.5 * cotangent(k, i, j));
                add(j, k, 0.5 * cotangent(i, j, k));
                add(k, i, 0.5 * cotangent(j, k, i));
            }
    }

    /// \param[out] energy  half the sum over the edges.
    Points solve(const Points& y, const Pose& pose, double* energy) const
    {
        shapes::Random random(11);
        std::vector<Matrix3> frames, turned;
        for (int v = 0; v < n_; ++v)
            frames.push_back(random.rotation());
        MatrixX f(3 * n_, 3), x(n_, 3); // rows 3v: the transposed frames
        for (int v = 0; v < n_; ++v) {
            const Matrix3 R = held_[v] == 1 ? Matrix3(pose.leftCols<3>()) : Matrix3::Identity();
            f.middleRows<3>(3 * v) = (R * frames[v]).transpose();
            x.row(v) = (held_[v] == 1 ? apply(pose, y.row(v).transpose()) : Vector3(y.row(v))).transpose();
        }
        MatrixX A = MatrixX::Zero(3 * n_, 3 * n_);
        for_edges([&](int i, int j, double weight) { // w |f_j - f_i R|^2
            const double w = weight > 0 ? weight : -1e-6 * weight;
            const Matrix3 R = frames[i].transpose() * frames[j];
            A.block<3, 3>(3 * i, 3 * i) += w * Matrix3::Identity();
            A.block<3, 3>(3 * j, 3 * j) += w * Matrix3::Identity();
            A.block<3, 3>(3 * i, 3 * j) -= w * R;
            A.block<3, 3>(3 * j, 3 * i) -= w * R.transpose();
        });
        f = free(A, MatrixX::Zero(3 * n_, 3), f, 3);
        for (int v = 0; v < n_; ++v) {
            const Matrix3 Q = f.middleRows<3>(3 * v).transpose() * frames[v].transpose();
            const Eigen::JacobiSVD<Matrix3> svd(Q, Eigen::ComputeFullU | Eigen::ComputeFullV);
            turned.push_back(svd.matrixU() * svd.matrixV().transpose());
        }
        MatrixX L = MatrixX::Zero(n_, n_), b = MatrixX::Zero(n_, 3);
        for_edges([&](int i, int j, double w) {
            L(i, i) += w;
            L(j, j) += w;
            L(i, j) -= w;
            L(j, i) -= w;
            const Eigen::RowVector3d e = (y.row(i) - y.row(j)) * (0.5 * (turned[i] + turned[j])).transpose();
            b.row(i) += w * e;
            b.row(j) -= w * e;
        });
        const MatrixX solved = free(L, b, x, 1);
        *energy = 0.0;
        for_edges([&](int i, int j, double w) {
            const Eigen::RowVector3d e = (y.row(i) - y.row(j)) * (0.5 * (turned[i] + turned[j])).transpose();
            *energy += 0.5 * w * (solved.row(i) - solved.row(j) - e).squaredNorm();
        });
        return solved;
    }

private:
    double cotangent(int at, int i, int j) const
    {
        const Vector3 u = mesh_.point(i) - mesh_.point(at), v = mesh_.point(j) - mesh_.point(at);
        return 1.0 / std::tan(std::acos(u.normalized().dot(v.normalized())));
    }
    template <class Body>
    void for_edges(const Body& body) const
    {
        for (int i = 0; i < n_; ++i)
            for (int j = 0; j < i; ++j)
                if (W_(i, j) != 0.0)
                    body(i, j, W_(i, j));
    }
    /// A x = b for the rows of free vertices, `size` rows each.
    MatrixX free(const MatrixX& A, const MatrixX& b, MatrixX x, int size) const
    {
        std::vector<int> rows;
        for (int row = 0; row < x.rows(); ++row)
            if (held_[row / size] < 0) {
                rows.push_back(row);
                x.row(row).setZero();
            }
        const MatrixX rhs = (b - A * x)(rows, Eigen::all);
        const MatrixX found = MatrixX(A(rows, rows)).partialPivLu().solve(rhs);
        x(rows, Eigen::all) = found;
        return x;
    }

    const SurfaceMesh& mesh_;
    int n_;
    std::vector<int> held_;
    MatrixX W_;
};

} // namespace

INSTANTIATE_TEST_SUITE_P(RotationInvariantCoordinates, SurfaceContract, testing::Values(traits()));

TEST(RotationInvariantCoordinates, solve_the_statement_of_the_paper_with_any_frames_at_rest)
{
    shapes::Random random(6);
    for (const SurfaceMesh& mesh : {shapes::hill(7, 7), shapes::bar(5, 2)})
        for (Discretization kind : every) {
            const std::vector<Handle> handles = shapes::ends(mesh, 1.1);
            const PaperStatement paper(mesh, handles, kind);
            const Points incoming = mesh.points() + 0.3 * random.dense(mesh.vertex_count(), 3);
            for (const Points& y : {mesh.points(), incoming})
                for (double degrees : {0.0, 40.0, 150.0}) {
                    const Pose pose =
                        shapes::turn(random.vector(), degrees, random.vector(), random.vector());
                    SolveReport report;
                    const Points found =
                        solved(mesh, handles, {.poses = {shapes::still(), pose}, .incoming = view(y)},
                               &report, kind);
                    double energy = 0.0;
                    EXPECT_LT(shapes::distance(found, paper.solve(y, pose, &energy)),
                              1e-10 * shapes::size(y));
                    EXPECT_NEAR(report.energy, energy, 1e-10 * energy);
                    EXPECT_LT(report.residual, 1e-11);
                }
        }
}

TEST(RotationInvariantCoordinates, of_handles_that_do_not_turn_are_gradients_that_do_not_turn)
{
    const SurfaceMesh mesh = shapes::hill(9, 8);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Poses lifted{shapes::still(), shapes::shift(-2, 1, 4)};
    GradientEditing gradients(mesh);
    gradients.set_handles(handles);
    Points expected;
    gradients.solve({lifted}, expected);
    EXPECT_LT(shapes::distance(solved(mesh, handles, {.poses = lifted}), expected), 1e-12);
}

TEST(RotationInvariantCoordinates, bend_a_tube_by_120_degrees_about_as_well_as_a_beam_bends)
{
    // The isometric bend of the axis has .0580.
    const SurfaceMesh mesh = study_tube();
    for (const auto& [kind, expected] :
         {std::pair{Discretization::cotan, .0639}, {Discretization::uniform, .0597}}) {
        const Points q = solved(mesh, shapes::ends(mesh, study_depth),
                                {.poses = {shapes::still(), study_bend()}}, nullptr, kind);
        EXPECT_NEAR(rms_edge_ratio(mesh, q), expected, 0.0005);
    }
}

TEST(RotationInvariantCoordinates, between_handles_at_half_a_turn_follow_the_mean_angle)
{
    const SurfaceMesh mesh = shapes::hill(10, 9);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    SolveReport report;
    const auto at = [&](double degrees) {
        return solved(mesh, handles, {.poses = {shapes::still(), shapes::turn({1, 0, 0}, degrees)}}, &report);
    };
    at(150);
    EXPECT_EQ(report.half_turns, 0);
    const Points half = at(180);
    EXPECT_GT(report.half_turns, 0);
    EXPECT_LT(report.half_turns, mesh.vertex_count() / 2) << "those in the middle";
    for (double rounding : {-1e-11, 1e-11}) // degrees; rounding does not choose the way
        EXPECT_LT(shapes::distance(at(180 + rounding), half), 1e-8);
}

TEST(RotationInvariantCoordinates, take_the_rotation_of_an_affine_map_and_leave_its_scale_at_the_handle)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    const std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    const Matrix3 R = shapes::rotation({0, 1, 0}, 40);
    const Points scaled = solved(mesh, handles, {.poses = {shapes::still(), shapes::affine(1.5 * R)}}),
                 plain = solved(mesh, handles, {.poses = {shapes::still(), shapes::affine(R)}});
    // Only held vertices differ, and what lies between them is as smooth as it can be.
    const MatrixX force = laplacian_matrix(mesh, Discretization::cotan) * (scaled - plain);
    const Regions regions(handles, connected_components(mesh));
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (regions.is_free(v)) {
            EXPECT_LT(force.row(v).norm(), 1e-12);
        } else if (regions.hard(v) == 1) {
            EXPECT_LT((scaled.row(v).transpose() - 1.5 * R * mesh.point(v)).norm(), 1e-13);
        }
    }
}

TEST(RotationInvariantCoordinates, refuse_a_laplacian_with_masses)
{
    EXPECT_THROW(RotationInvariantCoordinates(shapes::cube(), {Discretization::cotan_voronoi}),
                 InvalidOption);
}

TEST(RotationInvariantCoordinates, allocate_nothing_in_proportion_to_the_mesh_after_the_first_solve)
{
    if (!allocations::counted())
        GTEST_SKIP() << "nobody counts here";
    const SurfaceMesh mesh = shapes::hill(60, 60);
    RotationInvariantCoordinates method(mesh);
    method.set_handles(shapes::ends(mesh, 1.5));
    Points positions;
    const allocations::Count count(sizeof(double) * mesh.vertex_count());
    method.solve({bent}, positions);
    const int first = count.so_far();
    EXPECT_GT(first, 0);
    for (int k = 0; k < 3; ++k)
        method.solve({bent}, positions);
    EXPECT_EQ(count.so_far(), first);
}

} // namespace sinew::test_rotation_invariant_coordinates

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/mls.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/refusals.h"

#include <Eigen/SVD>
#include <gtest/gtest.h>

#include <cmath>

namespace sinew::test_mls {

namespace {

constexpr WeightPrecision doubles = WeightPrecision::double_precision;
constexpr MlsMaps every_kind[] = {MlsMaps::affine, MlsMaps::similarity, MlsMaps::rigid};

Points random_points(int count, double reach, std::uint64_t seed)
{
    shapes::Random random(seed);
    Points points(count, 3);
    for (int i = 0; i < count; ++i)
        points.row(i) = reach * random.vector().transpose();
    return points;
}

Points warped(Mls& mls, const Points& points, const Points& control)
{
    mls.bind(view(points));
    Points out(points.rows(), 3);
    mls.warp(view(control), {}, out.data());
    return out;
}

/// One point by the formulas of the papers, with a singular value decomposition.
Vector3 by_the_paper(const Points& p, const Points& q, const VectorX& share, const Vector3& v, MlsMaps kind,
                     double alpha)
{
    VectorX w(p.rows());
    for (Eigen::Index i = 0; i < p.rows(); ++i)
        w[i] = share[i] * std::pow((p.row(i).transpose() - v).norm(), -2 * alpha);
    const Vector3 p_star = (w.transpose() * p).transpose() / w.sum(),
                  q_star = (w.transpose() * q).transpose() / w.sum();
    const MatrixX P = p.rowwise() - p_star.transpose(), Q = q.rowwise() - q_star.transpose();
    const Matrix3 spread = P.transpose() * w.asDiagonal() * P, N = P.transpose() * w.asDiagonal() * Q;
    if (kind == MlsMaps::affine)
        return N.transpose() * spread.inverse() * (v - p_star) + q_star;
    const Eigen::JacobiSVD<Matrix3> svd(N, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3 D = Matrix3::Identity();
    D(2, 2) = (svd.matrixU() * svd.matrixV()).determinant() < 0 ? -1 : 1;
    const Matrix3 R = svd.matrixV() * D * svd.matrixU().transpose();
    const double scale = kind == MlsMaps::similarity ? (R * N).trace() / spread.trace() : 1.0;
    return scale * R * (v - p_star) + q_star;
}

HandlePoints regions(int each = 40)
{
    Points points = random_points(2 * each + 1, 1.0, 7);
    points.topRows(each).col(0).array() -= 3.0;
    points.middleRows(each, each).col(0).array() += 3.0;
    points.row(2 * each) << 0, 2, 0;
    return HandlePoints(view(points), {each, each, 1});
}

Points posed(const HandlePoints& handles, const std::vector<Pose>& poses)
{
    Points control = handles.control();
    for (int h = 0; h < handles.handle_count(); ++h)
        for (int r = handles.column(h); r < handles.column(h + 1); ++r)
            control.row(r) = apply(poses[h], Vector3(control.row(r).transpose())).transpose();
    return control;
}

SpaceTraits traits(MlsMaps kind, const std::string& name)
{
    const Points centres = random_points(25, 1.0, 3);
    const HandlePoints handles{view(centres)};
    const std::vector<std::array<int, 2>> edges{{0, 1}, {2, 3}, {3, 4}};
    SpaceTraits traits{
        .name = name,
        .variants = {{"single", [=] { return std::make_shared<Mls>(handles, MlsOptions{kind}); }},
                     {"double",
                      [=] { return std::make_shared<Mls>(handles, MlsOptions{kind, 2.0, {}, doubles}); }},
                     {"segments",
                      [=] { return std::make_shared<Mls>(handles, MlsOptions{kind, 1.5, edges, doubles}); }}},
        .control = centres,
        .points = random_points(600, 1.3, 4),
        .follow = 8.0, // of affine maps, which may stretch
        .other = [=] { return std::make_shared<Mls>(handles, MlsOptions{kind, 3.0}); }};
    if (kind != MlsMaps::rigid)
        traits.similarity = 1e-11;
    if (kind == MlsMaps::affine)
        traits.affine = 1e-11;
    return traits;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Mls, SpaceContract,
                         testing::Values(traits(MlsMaps::affine, "affine"),
                                         traits(MlsMaps::similarity, "similarity"),
                                         traits(MlsMaps::rigid, "rigid")));

TEST(Mls, is_what_the_papers_say_at_every_point)
{
    const Points p = random_points(30, 1.0, 1), q = p + 0.4 * random_points(30, 1.0, 2),
                 points = random_points(150, 1.5, 3);
    const VectorX even = VectorX::Ones(30);
    for (const MlsMaps kind : every_kind)
        for (const double alpha : {1.0, 2.0, 0.7}) {
            Mls mls(HandlePoints(view(p)), {kind, alpha, {}, doubles});
            const Points found = warped(mls, points, q);
            for (Eigen::Index i = 0; i < points.rows(); ++i) {
                const Vector3 v = points.row(i).transpose();
                EXPECT_LT((found.row(i).transpose() - by_the_paper(p, q, even, v, kind, alpha)).norm(), 1e-10)
                    << i;
            }
        }
}

TEST(Mls, points_of_a_region_share_its_weight_and_move_by_one_map)
{
    const HandlePoints handles = regions();
    const std::vector<Pose> poses{shapes::still(), shapes::turn({1, 2, 3}, 70, {3, 0, 0}, {0, 1, 0}),
                                  shapes::shift(0, 0.5, 0.2)};
    Points q = handles.points();
    VectorX share(handles.point_count());
    for (int i = 0; i < handles.point_count(); ++i) {
        const int h = handles.handle_of(i);
        q.row(i) = apply(poses[h], Vector3(q.row(i).transpose())).transpose();
        share[i] = 1.0 / (handles.begin(h + 1) - handles.begin(h));
    }
    const Points points = random_points(150, 3.0, 5);
    for (const MlsMaps kind : every_kind) {
        Mls mls(handles, {kind, 1.3, {}, doubles});
        const Points found = warped(mls, points, posed(handles, poses));
        for (Eigen::Index i = 0; i < points.rows(); ++i) {
            const Vector3 v = points.row(i).transpose();
            EXPECT_LT(
                (found.row(i).transpose() - by_the_paper(handles.points(), q, share, v, kind, 1.3)).norm(),
                1e-10);
        }
    }
}

TEST(Mls, a_point_on_a_handle_gets_its_target_exactly)
{
    const HandlePoints handles = regions();
    const std::vector<Pose> poses{shapes::still(), shapes::turn({1, 2, 3}, 70, {3, 0, 0}, {0, 1, 0}),
                                  shapes::shift(0, 0.5, 0.2)};
    Points moved = handles.points();
    for (int i = 0; i < handles.point_count(); ++i)
        moved.row(i) = apply(poses[handles.handle_of(i)], Vector3(moved.row(i).transpose())).transpose();
    for (const MlsMaps kind : every_kind)
        for (const WeightPrecision precision : {doubles, WeightPrecision::single_precision}) {
            Mls mls(handles, {kind, 1.0, {}, precision});
            EXPECT_LT(shapes::distance(warped(mls, handles.points(), posed(handles, poses)), moved),
                      1e-14 * 8);
            // And what comes near gets near: the map is continuous.
            const Points near = handles.points().array() + 1e-7;
            EXPECT_LT(shapes::distance(warped(mls, near, posed(handles, poses)), moved), 1e-5);
        }
}

TEST(Mls, a_segment_takes_its_points_along)
{
    Points ends(5, 3);
    ends << 0, 0, 0, 1, 0, 0, 0, 1, 0.2, 1, 1, 0, 0.4, 0.3, 1;
    Points control = ends;
    control.row(1) << 0.8, 0.5, 0.1;
    control.row(4) << 0.4, 0.3, 1.4;
    Points on(9, 3), moved(9, 3);
    for (int k = 0; k < 9; ++k) {
        on.row(k) = ends.row(0) + k / 8.0 * (ends.row(1) - ends.row(0));
        moved.row(k) = control.row(0) + k / 8.0 * (control.row(1) - control.row(0));
    }
    for (const MlsMaps kind : every_kind) {
        Mls mls(HandlePoints(view(ends)), {kind, 1.0, {{0, 1}, {2, 3}}, doubles});
        EXPECT_LT(shapes::distance(warped(mls, on, control), moved), 1e-13);
        const Points near = on.array() + 1e-6;
        EXPECT_LT(shapes::distance(warped(mls, near, control), moved), 1e-3);
    }
}

TEST(Mls, a_segment_weighs_as_the_many_points_on_it)
{
    // The oracle: a sum over 20,000 points of the segment.
    Points ends(5, 3);
    ends << 0, 0, 0, 1, 0, 0, 0, 1, 0.2, 1, 1, 0.5, 0.4, 0.3, 1;
    Points control = ends + 0.3 * random_points(5, 1.0, 9);
    constexpr int many = 20000;
    Points p(many + 3, 3), q(many + 3, 3);
    VectorX share = VectorX::Constant(many + 3, 1.0);
    const double size = HandlePoints(view(ends)).size();
    for (int k = 0; k < many; ++k) {
        const double t = (k + 0.5) / many;
        p.row(k) = ends.row(0) + t * (ends.row(1) - ends.row(0));
        q.row(k) = control.row(0) + t * (control.row(1) - control.row(0));
        share[k] = 1.0 / size / many; // the length, 1, as a share of the size of all handles
    }
    p.bottomRows(3) = ends.bottomRows(3);
    q.bottomRows(3) = control.bottomRows(3);
    const Points points = random_points(60, 1.0, 4).array() + 0.5;
    for (const MlsMaps kind : every_kind)
        for (const double alpha : {1.0, 2.0}) {
            Mls mls(HandlePoints(view(ends)), {kind, alpha, {{0, 1}}, doubles});
            const Points found = warped(mls, points, control);
            for (Eigen::Index i = 0; i < points.rows(); ++i) {
                const Vector3 v = points.row(i).transpose();
                EXPECT_LT((found.row(i).transpose() - by_the_paper(p, q, share, v, kind, alpha)).norm(), 2e-3)
                    << "8 nodes on each side of the foot";
            }
        }
}

TEST(Mls, flat_handles_are_fitted_by_rigid_maps_and_the_report_says_so)
{
    Points plane = random_points(12, 1.0, 5);
    plane.col(2).setZero();
    Mls mls(HandlePoints(view(plane)), {MlsMaps::affine, 1.0, {}, doubles});
    const Points points = random_points(40, 1.0, 6);
    EXPECT_EQ(mls.bind(view(points)).remarks.size(), 1U);
    EXPECT_EQ(mls.maps(), MlsMaps::rigid);
    const Pose turn = shapes::turn({1, 2, 3}, 80, {0, 0, 1}, {1, 0, 0});
    EXPECT_LT(shapes::distance(warped(mls, points, shapes::transformed(plane, turn)),
                               shapes::transformed(points, turn)),
              1e-12)
        << "a rigid map is carried by handles in a plane";
}

TEST(Mls, handles_on_a_line_turn_by_the_smallest_angle)
{
    Points line(3, 3);
    line << 0, 0, 0, 1, 0, 0, 2.5, 0, 0;
    const Points points = random_points(40, 1.0, 6);
    const Pose turn = shapes::turn({0, 0, 1}, 50, {0, 0, 0}, {1, 2, 3});
    for (const MlsMaps kind : {MlsMaps::rigid, MlsMaps::similarity}) {
        Mls mls(HandlePoints(view(line)), {kind, 1.0, {}, doubles});
        EXPECT_LT(shapes::distance(warped(mls, points, shapes::transformed(line, turn)),
                                   shapes::transformed(points, turn)),
                  1e-9);
    }
    Mls alone(HandlePoints(view(Points(line.topRows(1)))));
    EXPECT_LT(shapes::distance(warped(alone, points, Points(line.row(1))),
                               shapes::transformed(points, shapes::shift(1, 0, 0))),
              1e-15);
}

TEST(Mls, refuses_options_that_make_no_sense)
{
    const Points p = random_points(6, 1.0, 1);
    Points twice = p;
    twice.row(1) = twice.row(0);
    EXPECT_THROW(Mls(HandlePoints(view(p)), {MlsMaps::rigid, 0.0}), InvalidOption);
    EXPECT_THROW(Mls(HandlePoints(view(p)), {MlsMaps::rigid, 1.0, {{0, 6}}}), InvalidConstraint);
    EXPECT_THROW(Mls(HandlePoints(view(p), {2, 4}), {MlsMaps::rigid, 1.0, {{0, 1}}}), InvalidConstraint);
    expect_elements(
        refusal<InvalidConstraint>([&] { Mls(HandlePoints(view(twice)), {MlsMaps::rigid, 1.0, {{0, 1}}}); }),
        Error::Element::handle, {0, 1});
    Mls mls(HandlePoints{view(twice)});
    Points apart = twice;
    apart(1, 0) += 1.0;
    expect_elements(refusal<InvalidConstraint>([&] { warped(mls, p, apart); }), Error::Element::handle,
                    {0, 1});
    const MemoryLimit limit(100);
    Mls large(HandlePoints{view(p)});
    EXPECT_THROW(large.bind(view(random_points(100, 1.0, 2))), OutOfMemory);
}

} // namespace sinew::test_mls

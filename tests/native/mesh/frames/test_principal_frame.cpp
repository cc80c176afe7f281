// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/frames/principal_frame.h"

#include "tests/native/dense.h"
#include "tests/native/shapes.h"

namespace sinew::test_principal_frame {

std::vector<int> all(const Points& points) { return shapes::numbers(0, static_cast<int>(points.rows())); }

void expect_rotation(const Matrix3& axes)
{
    EXPECT_LT((axes.transpose() * axes - Matrix3::Identity()).norm(), 1e-14);
    EXPECT_GT(axes.determinant(), 0.0);
}

TEST(PrincipalFrame, has_the_axes_of_the_covariance_from_the_longest_to_the_normal)
{
    shapes::Random random(3);
    for (double scale : {1e-12, 1.0, 1e12}) {
        const Matrix3 turn = random.rotation();
        const Matrix3 stretched = scale * turn * Vector3(5, 2, 0.3).asDiagonal();
        const Points points =
            shapes::transformed(random.points(200), shapes::affine(stretched, scale * Vector3(9, -4, 2)));
        const PrincipalFrame frame = principal_frame(points, all(points));
        expect_rotation(frame.axes);
        const Points around = points.rowwise() - points.colwise().mean();
        const MatrixX modes = dense::eigenvectors(around.transpose() * around / (scale * scale));
        for (int k : {0, 1, 2}) // the smallest eigenvalue comes first there
            EXPECT_NEAR(std::abs(frame.axes.col(k).dot(modes.col(2 - k))), 1.0, 1e-12);
        EXPECT_LT((frame.seen(points.row(7).transpose()) - frame.axes.transpose() * around.row(7).transpose())
                      .norm(),
                  1e-12 * scale);
    }
}

TEST(PrincipalFrame, takes_the_hint_or_the_axes_of_space_where_the_points_leave_it_open)
{
    const Points square = shapes::grid_points(6, 6);
    const std::vector<int> rows = all(square);
    const auto first = [&](const Vector3& hint) -> Vector3 {
        return principal_frame(square, rows, hint).axes.col(0);
    };
    EXPECT_LT((first({1, 2, 0}) - Vector3(1, 2, 0).normalized()).norm(), 1e-14);
    EXPECT_LT((first({1, 2, 9}) - Vector3(1, 2, 0).normalized()).norm(), 1e-14);
    EXPECT_LT((first({1e-9, 2e-9, 0}) - Vector3(1, 0, 0)).norm(), 1e-14) << "nothing but rounding";
    EXPECT_LT((first({0, 0, 9}) - Vector3(1, 0, 0)).norm(), 1e-14);
    const Points ball = shapes::sphere(2).points();
    const PrincipalFrame round = principal_frame(ball, all(ball));
    EXPECT_LT((round.axes - Matrix3::Identity()).norm(), 1e-12);
    Points rod = Points::Zero(5, 3);
    rod.col(1).setLinSpaced(0, 1);
    const PrincipalFrame thin = principal_frame(rod, all(rod));
    expect_rotation(thin.axes);
    EXPECT_NEAR(std::abs(thin.axes(1, 0)), 1.0, 1e-14);
    EXPECT_NEAR(thin.axes(2, 2), 1.0, 1e-14) << "the normal is z";
    const Points one = Points::Constant(1, 3, 2.0);
    expect_rotation(principal_frame(one, {0}).axes);
}

} // namespace sinew::test_principal_frame

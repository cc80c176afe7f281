// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/pose_problem.h"

#include "native/skeleton/pose_solver.h"
#include "tests/native/shapes.h"

namespace sinew::test_pose_problem {

/// Bones along z, each joint a little beside the line, so that those in between have hinges in several planes.
Skeleton zigzag(int count, const std::vector<Joint>& joints)
{
    const Vector3 beside[] = {{0, 0, 0}, {0.1, 0, 0}, {0, 0.1, 0}};
    Points ends(count + 1, 3);
    for (int b = 0; b <= count; ++b)
        ends.row(b) = (Vector3(0, 0, b) + beside[b % 3]).transpose();
    return {ends.topRows(count), ends.bottomRows(count), shapes::numbers(-1, count - 1), {}, joints};
}

// What the solver finds is in tests/bindings/surfaces/test_mesh_puppetry.py.
TEST(PoseProblem, SlopesAreThoseOfDifferences)
{
    std::vector<Joint> joints(6);
    joints[1].kind = joints[2].kind = Joint::Kind::angles;
    joints[1].order = {2, 0, 1};
    joints[3].most = 2;
    const Skeleton skeleton = zigzag(6, joints); // with hinges at the last two joints
    PoseRequest request;
    request.targets = {{5, {0, 0, 5}, {1, 2, 3}, 1}, {2, {0, 0.1, 2.5}, {0.5, 0.2, 1}, 2}};
    request.moving_roots = {true, false, false, false, false, false};
    request.balance = Balance{shapes::points_of({{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}})};
    const PoseSolverOptions options;
    PoseProblem problem(skeleton, request, options, skeleton.rest());
    shapes::Random random(1);
    VectorX x = problem.base();
    for (double& number : x)
        number += 0.7 * random.signed_unit();
    VectorX multipliers(4);
    multipliers << 0.3, 0.2, 0.1, 0.7;
    LeastSquares::Values here, more, less;
    LeastSquares::Slopes slopes, after, before;
    problem.evaluate(x, here);
    problem.linearize(multipliers, slopes);
    const MatrixX hessian =
        slopes.rows.transpose() * slopes.rows + MatrixX(slopes.diagonal.asDiagonal()) + slopes.curvature;
    const double h = 1e-5; // the error of central differences is of its square
    for (Eigen::Index k = 0; k < x.size(); ++k) {
        VectorX moved = x;
        moved[k] += h;
        problem.evaluate(moved, more);
        problem.linearize(multipliers, after);
        moved[k] -= 2 * h;
        problem.evaluate(moved, less);
        problem.linearize(multipliers, before);
        EXPECT_NEAR((more.squares - less.squares) / (2 * h), slopes.gradient[k], 1e-8);
        EXPECT_LT(((more.sides - less.sides) / (2 * h) - slopes.sides.col(k)).norm(), 1e-8);
        EXPECT_LT(((more.residuals - less.residuals) / (2 * h) - slopes.rows.col(k)).norm(), 1e-8);
        const VectorX pull = after.gradient + after.sides.transpose() * multipliers - before.gradient -
                             before.sides.transpose() * multipliers;
        EXPECT_LT((pull / (2 * h) - hessian.col(k)).norm(), 1e-8);
    }
}

} // namespace sinew::test_pose_problem

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/skeleton/pose_solver.h"

#include "native/skeleton/pose_problem.h"
#include "tests/native/shapes.h"
#include "tests/native/skeleton/bodies.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace sinew::test_pose_solver {

namespace {

PoseRequest tip_to(const Skeleton& skeleton, const Vector3& goal)
{
    const int last = skeleton.bone_count() - 1;
    PoseRequest request;
    request.targets = {{last, skeleton.tail(last), goal}};
    return request;
}

Points square(double half, const Vector3& middle = Vector3::Zero())
{
    Points corners(4, 3);
    corners << -half, -half, 0, half, -half, 0, half, half, 0, -half, half, 0;
    return corners.rowwise() + middle.transpose();
}

struct Solved
{
    Posture posture;
    PoseReport report;
};

Solved solve(const Skeleton& skeleton, const PoseRequest& request, const PoseSolverOptions& options = {})
{
    Solved solved;
    solved.report = solve_pose(skeleton, request, solved.posture, options);
    return solved;
}

constexpr PoseSolverOptions to_the_end{.max_iterations = 1000, .tolerance = 1e-13};

/// A figure that stands on its feet, and whose hand is pulled.
PoseRequest pulled(const bodies::Figure& figure, const Vector3& pull)
{
    PoseRequest request;
    for (int foot : figure.foot)
        for (const Vector3& end : {figure.heads[foot], figure.tails[foot]})
            request.targets.push_back({foot, end, end, 1e3});
    const int hand = figure.hand[0];
    request.targets.push_back({hand, figure.tails[hand], figure.tails[hand] + pull});
    request.moving_roots.assign(figure.count(), false);
    request.moving_roots[0] = true;
    return request;
}

/// Not by a hair.
void expect_within_limits(const Skeleton& skeleton, const Posture& posture)
{
    for (int b = 0; b < skeleton.bone_count(); ++b) {
        const Joint& joint = skeleton.joint(b);
        const Vector3 turn = posture.turns.row(b).transpose();
        if (joint.kind == Joint::Kind::ball) {
            EXPECT_LE(turn.norm(), joint.most) << b;
        } else {
            EXPECT_TRUE((turn.array() >= joint.lower.array()).all() &&
                        (turn.array() <= joint.upper.array()).all())
                << b;
        }
    }
}

} // namespace

TEST(PoseSolver, SlopesAreThoseOfDifferences)
{
    std::vector<Joint> joints(6);
    joints[1].kind = joints[2].kind = Joint::Kind::angles;
    joints[1].order = {2, 0, 1};
    joints[3].most = 2;
    const Skeleton skeleton = bodies::zigzag(6, joints); // with hinges at the last two joints
    PoseRequest request;
    request.targets = {{5, {0, 0, 5}, {1, 2, 3}, 1}, {2, {0, 0.1, 2.5}, {0.5, 0.2, 1}, 2}};
    request.moving_roots = {true, false, false, false, false, false};
    request.balance = Balance{square(1)};
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

TEST(PoseSolver, MeetsATargetInReach)
{
    for (double degrees : {180.0, 80.0, 35.0}) {
        const Skeleton skeleton = bodies::chain(4, bodies::limited(4, degrees));
        const Solved solved = solve(skeleton, tip_to(skeleton, {1.8, 0, 2.6}));
        EXPECT_TRUE(solved.report.converged);
        EXPECT_LE(solved.report.iterations + solved.report.rejected, 30);
        EXPECT_LT(solved.report.gaps[0], 2e-3); // what the rest pose is worth at a weight of 1e-4
        expect_within_limits(skeleton, solved.posture);
        const Solved exact = solve(skeleton, tip_to(skeleton, {1.8, 0, 2.6}),
                                   {.rest = 1e-10, .max_iterations = 1000, .tolerance = 1e-13});
        EXPECT_LT(exact.report.gaps[0], 1e-7);
    }
    // Turns in degrees, as a prototype in NumPy finds them, which does not divide gaps by the size.
    const Skeleton skeleton = bodies::chain(4, bodies::limited(4, 35));
    PoseSolverOptions options = to_the_end;
    options.rest /= 16;
    const Solved solved = solve(skeleton, tip_to(skeleton, {1.8, 0, 2.6}), options);
    const double known[] = {15.6, 32.3, 35, 35};
    for (int b = 0; b < 4; ++b)
        EXPECT_NEAR(solved.posture.turns.row(b).norm() * 180 / shapes::pi, known[b], 0.1);
}

TEST(PoseSolver, UnreachableTargetsAreApproached)
{
    const Skeleton skeleton = bodies::chain(4);
    for (const Vector3& goal : {Vector3(6, 1, 2), Vector3(0, 3, -5), Vector3(0, 0, 9)}) {
        const Solved solved = solve(skeleton, tip_to(skeleton, goal), {.rest = 1e-9});
        // The chain points at its target.
        EXPECT_NEAR(solved.report.gaps[0], goal.norm() - 4, 1e-6);
    }
    // With joints that turn by at most 10 degrees, an arc is the best that there is.
    const Skeleton stiff = bodies::chain(4, bodies::limited(4, 10));
    const Solved solved = solve(stiff, tip_to(stiff, {100, 0, 0}), {.rest = 1e-9});
    Vector3 tip = Vector3::Zero();
    for (int k = 1; k <= 4; ++k)
        tip += Vector3(std::sin(k * shapes::pi / 18), 0, std::cos(k * shapes::pi / 18));
    EXPECT_NEAR(solved.report.gaps[0], (tip - Vector3(100, 0, 0)).norm(), 1e-6);
    expect_within_limits(stiff, solved.posture);
}

TEST(PoseSolver, ContradictingTargetsShareTheirGaps)
{
    const Skeleton skeleton = bodies::chain(4);
    PoseRequest request = tip_to(skeleton, {1, 0, 2});
    request.targets.push_back(request.targets[0]);
    request.targets[1].goal = {2, 0, 2};
    const Solved equal = solve(skeleton, request, {.rest = 1e-9});
    EXPECT_NEAR(equal.report.gaps[0], 0.5, 1e-6);
    EXPECT_NEAR(equal.report.gaps[1], 0.5, 1e-6);
    request.targets[0].weight = 3;
    const Solved weighted = solve(skeleton, request, {.rest = 1e-9});
    EXPECT_NEAR(weighted.report.gaps[0], 0.25, 1e-6);
}

TEST(PoseSolver, TheCentreOfMassStaysOverItsSupport)
{
    const bodies::Figure figure;
    const Skeleton skeleton = figure.skeleton();
    shapes::Random random(11);
    int leaning = 0;
    for (int k = 0; k < 20; ++k) {
        PoseRequest request = pulled(figure, 0.5 * random.vector());
        const Solved loose = solve(skeleton, request);
        request.balance = Balance{square(0.1, {0, -0.05, 0})};
        const Solved solved = solve(skeleton, request);
        EXPECT_LE(solved.report.overhang, 0.0) << k;
        const Poses poses = skeleton.poses(solved.posture);
        for (std::size_t t = 0; t < request.targets.size(); ++t) { // the report is about these poses
            const BoneTarget& target = request.targets[t];
            EXPECT_NEAR(solved.report.gaps[t], (apply(poses[target.bone], target.point) - target.goal).norm(),
                        1e-9);
        }
        // The report's centre is that of the bones.
        Vector3 centre = Vector3::Zero();
        double mass = 0.0;
        for (int b = 0; b < figure.count(); ++b) {
            const double length = (figure.tails[b] - figure.heads[b]).norm();
            centre += length * apply(poses[b], (figure.tails[b] + figure.heads[b]) / 2);
            mass += length;
        }
        EXPECT_LT((centre / mass - solved.report.centre).norm(), 1e-12);
        EXPECT_LE(std::max(std::abs(solved.report.centre.x()), std::abs(solved.report.centre.y() + 0.05)),
                  0.1);
        leaning +=
            std::max(std::abs(solved.report.centre.x()), std::abs(solved.report.centre.y() + 0.05)) > 0.0999;
        // What balance costs, the targets pay.
        EXPECT_GE(solved.report.energy, loose.report.energy * (1 - 1e-3));
    }
    EXPECT_GT(leaning, 3); // it was asked to lean, and went to the border
}

TEST(PoseSolver, ABalanceOutOfReachIsApproachedAndReported)
{
    const Skeleton skeleton = bodies::chain(4);
    PoseRequest request = tip_to(skeleton, {1, 0, 3});
    request.balance = Balance{square(0.1, {50, 0, 0})};
    const Solved solved = solve(skeleton, request, to_the_end);
    // Stretched out along x, with the centre 2 from the base.
    EXPECT_NEAR(solved.report.overhang, 49.9 - 2, 0.05);
    EXPECT_FALSE(solved.report.converged);
}

TEST(PoseSolver, AStraightChainBendsThroughItsPole)
{
    const Skeleton skeleton = bodies::chain(4);
    const Solved solved = solve(skeleton, tip_to(skeleton, {0, 0, 2.5})); // on the chain's own line
    EXPECT_LT(solved.report.gaps[0], 5e-3);
    EXPECT_GT(solved.posture.turns.rowwise().norm().maxCoeff(), 0.5);
    // Nearly all of it in one plane: that of its pole, which bends it a tenth as much aside.
    EXPECT_LT(solved.posture.turns.rightCols<2>().cwiseAbs().maxCoeff(), 0.15);
    // Without one it cannot.
    EXPECT_GT(solve(skeleton, tip_to(skeleton, {0, 0, 2.5}), {.pole = 0.0}).report.gaps[0], 1.0);
    // A knee that bends one way alone bends that way.
    std::vector<Joint> knees(4);
    for (Joint& knee : knees) {
        knee.kind = Joint::Kind::angles;
        knee.lower = {-2.5, 0, 0};
        knee.upper = {0, 0, 0};
    }
    const Skeleton leg = bodies::chain(4, knees);
    const Solved bent = solve(leg, tip_to(leg, {0, 0, 2.5}));
    EXPECT_LT(bent.posture.turns.col(0).maxCoeff(), 1e-12);
    EXPECT_LT(bent.posture.turns.col(0).minCoeff(), -0.5);
}

TEST(PoseSolver, ARigidMotionIsExact)
{
    const bodies::Figure figure;
    const Skeleton skeleton = figure.skeleton(figure.joints());
    const Pose motion = shapes::turn({0.3, 1, -0.4}, 170, {1, 2, 3}, {0.5, -0.7, 2});
    PoseRequest request = pulled(figure, Vector3::Zero());
    for (BoneTarget& target : request.targets)
        target.goal = apply(motion, target.point);
    const Solved solved = solve(skeleton, request);
    EXPECT_TRUE(solved.report.converged);
    for (const Pose& pose : skeleton.poses(solved.posture))
        EXPECT_LT((pose - motion).norm(), 1e-9 * skeleton.size());
    EXPECT_LT(*std::ranges::max_element(solved.report.gaps), 1e-10);
}

TEST(PoseSolver, TargetsThatAreMetChangeNothing)
{
    const bodies::Figure figure;
    const Skeleton skeleton = figure.skeleton();
    Posture base = skeleton.rest();
    shapes::Random random(2);
    for (double& turn : base.turns.reshaped())
        turn = 0.4 * random.signed_unit();
    const Poses poses = skeleton.poses(base);
    PoseRequest request = pulled(figure, Vector3::Zero());
    request.base = base;
    for (BoneTarget& target : request.targets)
        target.goal = apply(poses[target.bone], target.point);
    const Solved solved = solve(skeleton, request);
    EXPECT_EQ(solved.posture.turns, base.turns);
    EXPECT_EQ(solved.posture.moves, base.moves);
    EXPECT_EQ(solved.report.iterations, 0);
}

TEST(PoseSolver, APathOfADragClosesToTheBit)
{
    const bodies::Figure figure;
    const Skeleton skeleton = figure.skeleton(figure.joints());
    const auto at = [&](double t) {
        return solve(skeleton,
                     pulled(figure, {0.3 * std::sin(t), 0.2 * std::sin(2 * t), 0.3 - 0.3 * std::cos(t)}));
    };
    const Solved before = at(1.0);
    for (int k = 0; k < 10; ++k)
        at(0.7 * k);
    const Solved after = at(1.0);
    EXPECT_EQ(before.posture.turns, after.posture.turns);
    EXPECT_EQ(before.posture.moves, after.posture.moves);
}

TEST(PoseSolver, LockedJointsAndStiffOnes)
{
    const Skeleton skeleton = bodies::chain(4);
    PoseRequest request = tip_to(skeleton, {1.8, 0, 2.6});
    Posture base = skeleton.rest();
    base.turns.row(1) << 0.1, 0.2, 0.3;
    request.base = base;
    request.locked = {false, true, false, false};
    const Solved locked = solve(skeleton, request);
    EXPECT_EQ(locked.posture.turns.row(1), base.turns.row(1));
    EXPECT_LT(locked.report.gaps[0], 3e-3);

    std::vector<Joint> joints(4);
    joints[0].stiffness = 100;
    const Skeleton stiff = bodies::chain(4, joints);
    const auto first = [&](const Skeleton& of) {
        return solve(of, tip_to(of, {1.8, 0, 2.6})).posture.turns.row(0).norm();
    };
    EXPECT_LT(first(stiff), 0.1 * first(skeleton));
}

namespace {

Points tails_of(const Skeleton& skeleton, const Posture& posture)
{
    const Poses poses = skeleton.poses(posture);
    Points tails(skeleton.bone_count(), 3);
    for (int b = 0; b < skeleton.bone_count(); ++b)
        tails.row(b) = apply(poses[b], skeleton.tail(b)).transpose();
    return tails;
}

/// Takes the tip of a chain along goals, each solve on its own.
/// \return the longest way of a joint between two of them.
double longest_step(const Skeleton& skeleton, const std::vector<Vector3>& goals)
{
    double longest = 0.0;
    Points last;
    for (const Vector3& goal : goals) {
        const Solved solved = solve(skeleton, tip_to(skeleton, goal));
        EXPECT_TRUE(solved.report.converged) << goal.transpose();
        const Points here = tails_of(skeleton, solved.posture);
        if (last.rows() > 0)
            longest = std::max(longest, (here - last).rowwise().norm().maxCoeff());
        last = here;
    }
    return longest;
}

/// A hip with two legs that mirror each other, knees ahead by `knee`, and a spine: the feet are bones 3 and
/// 6, the chest is bone 8.
Skeleton legs_and_spine(double knee)
{
    std::vector<Vector3> heads{{0, 0, 1}}, tails{{0, 0, 1.2}};
    std::vector<int> parents{-1};
    const auto add = [&](const std::vector<Vector3>& joints) {
        for (std::size_t k = 0; k + 1 < joints.size(); ++k) {
            parents.push_back(k == 0 ? 0 : static_cast<int>(parents.size()) - 1);
            heads.push_back(joints[k]);
            tails.push_back(joints[k + 1]);
        }
    };
    for (double side : {1.0, -1.0})
        add({{0.1 * side, 0, 1}, {0.12 * side, -knee, 0.55}, {0.12 * side, 0, 0.1}, {0.12 * side, -0.2, 0}});
    add({{0, 0, 1.2}, {0, 0.02, 1.4}, {0, 0, 1.6}});
    return {shapes::points_of(heads), shapes::points_of(tails), parents};
}

} // namespace

TEST(PoseSolver, JointsMoveSmoothlyWithTheHand)
{
    const Skeleton arm(shapes::points_of({{0, 0, 0}, {1, 0.1, 0}}),
                       shapes::points_of({{1, 0.1, 0}, {2, 0, 0}}), {-1, 0});
    std::vector<Vector3> circle;
    for (int degrees = 0; degrees <= 360; ++degrees) {
        const double a = degrees * shapes::pi / 180;
        circle.emplace_back(1.2 + 0.5 * std::cos(a), 0.5 * std::sin(a), 0.3);
    }
    EXPECT_LT(longest_step(arm, circle), 0.02);
    for (const Skeleton& chain : {bodies::chain(4), bodies::zigzag(4)}) {
        shapes::Random random(5);
        for (int k = 0; k < 200; ++k) {
            const Vector3 goal = 3.5 * random.vector();
            EXPECT_LT(longest_step(chain, {goal, goal + 0.005 * random.vector().normalized()}), 0.02) << k;
        }
    }
}

TEST(PoseSolver, BothSidesOfAFigureBendAlikeAndForward)
{
    for (double knee : {0.02, 0.08})
        for (int dragged : {0, 8}) {
            const Skeleton skeleton = legs_and_spine(knee);
            Points last;
            for (int k = 0; k <= 40; ++k) {
                PoseRequest request;
                for (int bone : {dragged, 3, 6}) // as whole bones
                    for (const Vector3& from : {skeleton.head(bone), skeleton.tail(bone),
                                                Vector3(skeleton.head(bone) + 0.1 * Vector3::UnitX()),
                                                Vector3(skeleton.head(bone) - 0.1 * Vector3::UnitX())}) {
                        const Vector3 way =
                                          0.01 * k * Vector3(0, dragged ? -0.8 : 0.0, dragged ? -0.8 : -1.0),
                                      move = bone == dragged ? way : Vector3(Vector3::Zero());
                        request.targets.push_back({bone, from, from + move, bone == dragged ? 1.0 : 1e3});
                    }
                request.moving_roots.assign(skeleton.bone_count(), false);
                request.moving_roots[0] = true;
                const Solved solved = solve(skeleton, request);
                EXPECT_TRUE(solved.report.converged) << k;
                const Points tails = tails_of(skeleton, solved.posture);
                for (int b = 1; b <= 3; ++b) {
                    const Vector3 left = tails.row(b).transpose(), right = tails.row(b + 3).transpose();
                    EXPECT_LT((left - right.cwiseProduct(Vector3(-1, 1, 1))).norm(), 1e-6) << k;
                }
                EXPECT_LT(tails(1, 1), -knee + 1e-9) << k; // ahead
                EXPECT_GT(tails(1, 0), 0.1) << k;          // and on its own side
                // The first centimetres from an almost straight leg move a knee far, whoever bends it.
                if (k > 4) {
                    EXPECT_LT((tails - last).rowwise().norm().maxCoeff(), 0.03) << k;
                }
                last = tails;
            }
        }
}

TEST(PoseSolver, NothingToDoIsTheBasePosture)
{
    const Skeleton skeleton = bodies::chain(3);
    const Solved solved = solve(skeleton, {});
    EXPECT_EQ(solved.posture.turns, skeleton.rest().turns);
    EXPECT_TRUE(solved.report.converged);
}

} // namespace sinew::test_pose_solver

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/arap_kernels.h"

#include "native/local_global/arap/arap_problem.h"
#include "native/local_global/arap/cell_fits.h"
#include "native/operators/fits/rotation_fit.h"
#include "tests/native/differences.h"
#include "tests/native/local_global/arap/graphs.h"
#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <memory>

namespace sinew::test_arap_kernels {

/// Matrices one after the other, `rows` numbers a column.
std::vector<double> packed(const std::vector<Matrix3>& matrices, int rows = 3)
{
    std::vector<double> numbers(3 * rows * matrices.size() + 1, 0.0);
    for (std::size_t i = 0; i < matrices.size(); ++i)
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 3; ++row)
                numbers[rows * (3 * i + column) + row] = matrices[i](row, column);
    return numbers;
}

Matrix3 matrix(const std::vector<double>& packed, int i) { return Eigen::Map<const Matrix3>(&packed[9 * i]); }

std::vector<double> packed(const Points& points)
{
    std::vector<double> numbers(points.data(), points.data() + points.size());
    numbers.push_back(0.0);
    return numbers;
}

/// A graph with random rotations and a random deformation.
struct Example
{
    SurfaceMesh mesh = shapes::sphere(2);
    ArapSystem graph;
    std::vector<double> base, points, rotations;

    Example(bool rims, double smoothness)
        : graph(graphs::of(mesh, {graphs::poles(mesh)[0]}, smoothness, rims, true))
    {
        shapes::Random random(3);
        std::vector<Matrix3> turns;
        for (int i = 0; i < graph.size(); ++i)
            turns.push_back(random.rotation());
        base = packed(mesh.points());
        points = packed(random.shaken(mesh.points(), 0.1));
        rotations = packed(turns);
    }
    GraphView view() const
    {
        return {.edges = graph.chunks().edges.data(),
                .ends = graph.chunks().ends.data(),
                .weights = graph.chunks().weights.data(),
                .triangles = graph.chunks().triangles.data(),
                .rims = graph.cells().rims,
                .rigidity = graph.cells().rigidity.data(),
                .free = graph.free_count(),
                .base = base.data(),
                .points = points.data(),
                .smoothing = graph.cells().smoothing};
    }
};

TEST(ArapKernels, the_wide_ones_agree_with_the_plain_ones_to_the_last_bit)
{
    for (bool rims : {false, true})
        for (double smoothness : {0.0, 0.02}) {
            const Example example(rims, smoothness);
            const GraphView view = example.view();
            const double* const R = example.rotations.data();
            for (const GraphChunk& chunk : example.graph.chunks().all) {
                const int count = chunk.end - chunk.begin;
                const double* const own = R + 9 * chunk.begin;
                std::vector<double> expected;
                for (const ArapKernels* kernels : every_kernels<ArapKernels>()) {
                    std::vector<double> S(covariance_columns * (count + 1)), torque(3 * count);
                    std::vector<double> turned(9 * count), fitted(9 * count);
                    std::vector<double> gradient(3 * example.graph.free_count());
                    const std::unique_ptr<bool[]> safe(new bool[count]);
                    kernels->covariances(view, chunk, S.data());
                    kernels->torques(view, chunk, S.data(), R, torque.data());
                    kernels->add_neighbours(view, chunk, R, S.data());
                    kernels->turn(torque.data(), own, count, turned.data());
                    kernels->fit(S.data(), own, 1e-8, count, fitted.data(), safe.get());
                    std::vector<double> all{kernels->energy(view, chunk, R, gradient.data())};
                    for (int i = 0; i < count; ++i) {
                        const Matrix3 pulls = covariance(S.data(), i);
                        all.insert(all.end(), pulls.data(), pulls.data() + 9);
                    }
                    for (const auto& part : {torque, turned, fitted, gradient})
                        all.insert(all.end(), part.begin(), part.end());
                    if (kernels == &ArapKernels::baseline)
                        expected = all;
                    EXPECT_EQ(all, expected);
                }
            }
        }
}

TEST(ArapKernels, fit_finds_the_closest_rotations_from_any_guess_and_says_where_it_cannot)
{
    shapes::Random random(4);
    for (int count : {1, 3, 4, 15, 16, 17, 1000}) {
        std::vector<Matrix3> S, before;
        for (int i = 0; i < count; ++i) {
            before.push_back(random.rotation());
            switch (i % 5) {
            case 0: // near the guess, as in most steps
                S.push_back(before.back() + 0.01 * random.matrix());
                break;
            case 1: // flat, as a surface's cells are
                S.push_back(random.rotation() * Vector3(1, 0.8, 0).asDiagonal() * random.rotation());
                break;
            case 2: // turned over
                S.push_back(random.rotation() * Vector3(1, 0.8, -0.3).asDiagonal() * random.rotation());
                break;
            case 3: // on a line
                S.push_back(random.vector() * random.vector().transpose());
                break;
            default:
                S.push_back(random.matrix());
            }
        }
        std::vector<double> fitted(9 * count);
        const std::unique_ptr<bool[]> safe(new bool[count]);
        for (const ArapKernels* kernels : every_kernels<ArapKernels>()) {
            kernels->fit(packed(S, 4).data(), packed(before).data(), 0.0, count, fitted.data(), safe.get());
            for (int i = 0; i < count; ++i) {
                EXPECT_TRUE(safe[i] || i % 5 == 3 || i % 5 == 4) << i; // lines have a double eigenvalue
                if (!safe[i])
                    continue;
                const Matrix3 R = matrix(fitted, i), best = fit_rotation_svd(S[i]);
                EXPECT_LT((R * R.transpose() - Matrix3::Identity()).norm(), 1e-13);
                EXPECT_NEAR(R.determinant(), 1.0, 1e-13);
                EXPECT_NEAR((R.transpose() * S[i]).trace(), (best.transpose() * S[i]).trace(),
                            1e-13 * S[i].norm());
            }
        }
    }
}

TEST(ArapKernels, turn_is_a_rotation_by_the_vector_to_second_order_and_by_two_arctan_a_half_at_most)
{
    shapes::Random random(5);
    for (double size : {1e-6, 1e-3, 0.5, 1.0, 30.0})
        for (int trial = 0; trial < 20; ++trial) {
            const Vector3 omega = size * random.vector().normalized();
            const Matrix3 R = random.rotation();
            const std::vector<double> before = packed(std::vector{R});
            std::vector<double> after(9);
            widest_kernels<ArapKernels>().turn(omega.data(), before.data(), 1, after.data());
            const Eigen::AngleAxisd found(Matrix3(matrix(after, 0) * R.transpose()));
            const double cut = std::min(size, 1.0);
            EXPECT_NEAR(found.angle(), 2 * std::atan(0.5 * cut), 1e-9);
            EXPECT_NEAR(found.axis().dot(omega.normalized()), 1.0, size < 1e-5 ? 1e-6 : 1e-9);
        }
}

TEST(ArapKernels, torques_are_the_slope_of_the_fit)
{
    for (double smoothness : {0.0, 0.02}) {
        const Example example(false, smoothness);
        const GraphView view = example.view();
        const GraphChunk& chunk = example.graph.chunks().all.front();
        const int count = chunk.end - chunk.begin;
        std::vector<double> S(covariance_columns * (count + 1)), t(3 * count);
        widest_kernels<ArapKernels>().covariances(view, chunk, S.data());
        widest_kernels<ArapKernels>().torques(view, chunk, S.data(), example.rotations.data(), t.data());
        widest_kernels<ArapKernels>().add_neighbours(view, chunk, example.rotations.data(), S.data());
        for (int i = 0; i < count; i += 7) {
            const Matrix3 pulls = covariance(S.data(), i);
            for (int axis = 0; axis < 3; ++axis) {
                const auto turned = [&](double angle) {
                    const Matrix3 T = Eigen::AngleAxisd(angle, Vector3::Unit(axis)).toRotationMatrix();
                    return ((T * matrix(example.rotations, chunk.begin + i)).transpose() * pulls).trace();
                };
                EXPECT_NEAR(t[3 * i + axis], central_difference(turned, 1e-6), 1e-8);
            }
        }
    }
}

} // namespace sinew::test_arap_kernels

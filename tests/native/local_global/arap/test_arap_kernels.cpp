// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/arap_kernels.h"

#include "native/local_global/arap/arap_problem.h"
#include "native/local_global/arap/cell_fits.h"
#include "native/operators/fits/rotation_fit.h"
#include "tests/native/local_global/arap/graphs.h"
#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <memory>

namespace sinew::test_arap_kernels {

/// Matrices one after the other, `rows` numbers a column.
std::vector<double> flat(const std::vector<Matrix3>& matrices, int rows)
{
    std::vector<double> numbers(3 * rows * matrices.size() + 1, 0.0);
    for (std::size_t i = 0; i < matrices.size(); ++i)
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 3; ++row)
                numbers[rows * (3 * i + column) + row] = matrices[i](row, column);
    return numbers;
}
std::vector<double> packed(const std::vector<Matrix3>& matrices) { return flat(matrices, 3); }
std::vector<double> lanes_of(const std::vector<Matrix3>& matrices) { return flat(matrices, 4); }

Matrix3 matrix(const std::vector<double>& packed, int i)
{
    return Eigen::Map<const Eigen::Matrix<double, 3, 3>>(packed.data() + 9 * i);
}

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
        : graph(graphs::of(mesh, {{shapes::where(mesh, [](const Vector3& p) { return p.z() < -0.8; }), {}}},
                           smoothness, rims, true))
    {
        shapes::Random random(3);
        Points moved = mesh.points();
        std::vector<Matrix3> turns;
        for (int i = 0; i < graph.size(); ++i) {
            moved.row(i) += 0.1 * random.vector().transpose();
            turns.push_back(random.rotation());
        }
        base = packed(mesh.points());
        points = packed(moved);
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
    const auto every = every_kernels<ArapKernels>();
    for (bool rims : {false, true})
        for (double smoothness : {0.0, 0.02}) {
            const Example example(rims, smoothness);
            const int free = example.graph.free_count();
            const GraphView view = example.view();
            const std::vector<double>& R = example.rotations;
            for (const GraphChunk& chunk : example.graph.chunks().all) {
                const int count = chunk.end - chunk.begin;
                const double* const own = R.data() + 9 * chunk.begin;
                std::vector<std::vector<double>> S(every.size()), torque(S), turned(S), fitted(S),
                    gradient(S);
                std::vector<double> energy(every.size());
                for (std::size_t k = 0; k < every.size(); ++k) {
                    const ArapKernels& kernels = *every[k];
                    S[k].resize(covariance_columns * (count + 1));
                    kernels.covariances(view, chunk, S[k].data());
                    torque[k].resize(3 * count);
                    kernels.torques(view, chunk, S[k].data(), R.data(), torque[k].data());
                    kernels.add_neighbours(view, chunk, R.data(), S[k].data());
                    turned[k].resize(9 * count);
                    kernels.turn(torque[k].data(), own, count, turned[k].data());
                    fitted[k].resize(9 * count);
                    const std::unique_ptr<bool[]> safe(new bool[count]);
                    kernels.fit(S[k].data(), own, 1e-8, count, fitted[k].data(), safe.get());
                    gradient[k].resize(3 * free);
                    energy[k] = kernels.energy(view, chunk, R.data(), gradient[k].data());
                    for (int i = 0; i < count; ++i) // fourth lanes hold what happened to stand there
                        for (int column = 0; column < 3; ++column)
                            S[k][covariance_columns * i + 4 * column + 3] = 0.0;
                    S[k].resize(covariance_columns * count);
                    EXPECT_EQ(S[0], S[k]);
                    EXPECT_EQ(torque[0], torque[k]);
                    EXPECT_EQ(turned[0], turned[k]);
                    EXPECT_EQ(fitted[0], fitted[k]);
                    EXPECT_EQ(gradient[0], gradient[k]);
                    EXPECT_EQ(energy[0], energy[k]);
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
            kernels->fit(lanes_of(S).data(), packed(before).data(), 0.0, count, fitted.data(), safe.get());
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
                const double step = 1e-6;
                const auto turned = [&](double angle) {
                    const Matrix3 T = Eigen::AngleAxisd(angle, Vector3::Unit(axis)).toRotationMatrix();
                    return ((T * matrix(example.rotations, chunk.begin + i)).transpose() * pulls).trace();
                };
                EXPECT_NEAR(t[3 * i + axis], (turned(step) - turned(-step)) / (2 * step), 1e-8);
            }
        }
    }
}

} // namespace sinew::test_arap_kernels

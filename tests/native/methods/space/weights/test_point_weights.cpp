// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/weights/point_weights.h"

#include "native/methods/space/cage/green.h"
#include "native/methods/space/cage/mean_value.h"
#include "tests/native/methods/space/cage/cages.h"
#include "tests/native/refusals.h"

#include <gtest/gtest.h>

#include <string>

namespace sinew::test_point_weights {

namespace {

RowMatrix random_rows(int count, int columns)
{
    shapes::Random random(3);
    return random.dense(count, columns);
}

PointWeights filled(const RowMatrix& W, const PointWeightOptions& options, int at_once = PointWeights::part)
{
    shapes::Random random(8);
    PointWeights weights(static_cast<int>(W.rows()), random.dense(static_cast<int>(W.cols()), 3),
                         static_cast<int>(W.cols()), options);
    for (Eigen::Index i = 0; i < W.rows(); i += at_once)
        weights.set_rows(static_cast<int>(i), W.middleRows(i, std::min<Eigen::Index>(at_once, W.rows() - i)));
    return weights;
}

constexpr auto single = WeightPrecision::single_precision;
constexpr auto both = WeightPrecision::double_precision;

} // namespace

TEST(PointWeights, keep_what_they_are_given)
{
    for (const int count : {1, 7, 64, 200}) {
        const RowMatrix W = random_rows(count, 37);
        EXPECT_EQ(filled(W, {both, 0.0}).dense(), W);
        EXPECT_EQ(filled(W, {single, 0.0}).dense(), W.cast<float>().cast<double>());
        EXPECT_EQ(filled(W, {both, 1e-300}).dense(), W);
        EXPECT_EQ(filled(W, {both, 0.0}).sparse().toDense(), W);
        EXPECT_EQ(filled(W, {both, 1e-300}, 3 * PointWeights::part).dense(), W);
        EXPECT_EQ(filled(W, {single, 0.0}, 3 * PointWeights::part).dense(), W.cast<float>().cast<double>());
    }
}

TEST(PointWeights, apply_is_the_product)
{
    const RowMatrix W = random_rows(203, 37);
    shapes::Random random(4);
    const Points moves = random.dense(37, 3), rest = random.dense(203, 3);
    const Points exact = rest + W * moves;
    for (const double threshold : {0.0, 1e-300}) {
        Points out(203, 3);
        filled(W, {both, threshold}).apply(moves, view(rest), out.data());
        EXPECT_LT(shapes::distance(out, exact), 1e-14);
        filled(W, {single, threshold}).apply(moves, view(rest), out.data());
        EXPECT_LT(shapes::distance(out, exact), 37 * 6e-8); // half a unit of each term
        std::vector<float> floats(3 * 203);
        filled(W, {single, threshold}).apply(moves, view(rest), floats.data());
        for (int k = 0; k < 3 * 203; ++k)
            EXPECT_EQ(floats[k], static_cast<float>(out.data()[k]));
    }
}

TEST(PointWeights, moves_of_any_length_fit_single_numbers)
{
    const RowMatrix W = random_rows(20, 5);
    const Points moves = 1e200 * shapes::Random(4).dense(5, 3), rest = Points::Zero(20, 3);
    Points out(20, 3);
    filled(W, {single, 0.0}).apply(moves, view(rest), out.data());
    EXPECT_LT(shapes::distance(out * 1e-200, W * moves * 1e-200), 1e-6);
}

TEST(PointWeights, those_kept_make_up_for_those_dropped)
{
    const SurfaceMesh cage = shapes::bumpy_sphere(2);
    const Points points = shapes::points_around(cage, 300, 0.9);
    MeanValue full(Cage(cage), {both, 0.0}), thin(Cage(cage), {both, 1e-2}), mild(Cage(cage), {both, 2e-3});
    full.bind(view(points));
    mild.bind(view(points));
    const SpaceReport report = thin.bind(view(points));
    const RowMatrix W = full.weights().dense(), V = thin.weights().dense(), U = mild.weights().dense();
    EXPECT_LT(report.weight_bytes, full.weights().bytes());
    EXPECT_GT((V.array() == 0.0).count(), V.size() / 4);
    EXPECT_LT((V.rowwise().sum().array() - 1.0).abs().maxCoeff(), 1e-12);
    int exact_rows = 0;
    for (Eigen::Index i = 0; i < U.rows(); ++i)
        exact_rows +=
            (U.row(i).array() == 0.0).any() && (U.row(i) * cage.points() - points.row(i)).norm() < 1e-10;
    EXPECT_GT(exact_rows, 5) << "linear precision where it costs little";
    EXPECT_NEAR(report.dropped, (V - W).cwiseAbs().rowwise().sum().maxCoeff(), 1e-12);

    const Points pose = shapes::Random(6).shaken(cage.points(), 0.1);
    EXPECT_LE(shapes::distance(warped_by(thin, view(pose)), warped_by(full, view(pose))),
              report.dropped * shapes::distance(pose, cage.points()) * (1 + 1e-9))
        << "the bound that is told";
}

TEST(PointWeights, thin_green_coordinates_keep_translations_and_are_off_by_what_is_told)
{
    const SurfaceMesh cage = shapes::bumpy_sphere(2);
    const Points points = shapes::points_around(cage, 300, 1.3); // some outside
    Green thin(Cage(cage), {{both, 1e-3}, GreenOutside::nearest, -1});
    const SpaceReport report = thin.bind(view(points));
    const auto off = [&](const Pose& pose) {
        const Points moved = shapes::transformed(cage.points(), pose);
        return shapes::distance(warped_by(thin, view(moved)), shapes::transformed(points, pose));
    };
    EXPECT_LT(off(shapes::shift(1, 2, 3)), 1e-10);
    // Sixty degrees move no control, and no normal as long as the cage, farther than its size.
    EXPECT_LE(off(shapes::turn({1, 2, 3}, 60)), report.dropped * shapes::size(cage.points()));
    EXPECT_GT(report.dropped, 0.0);
}

TEST(PointWeights, rows_of_too_few_large_ones_keep_smaller_ones)
{
    const SurfaceMesh cage = shapes::octahedron();
    Points x(3, 3);
    x << 0.999, 0, 0, 0.6, 0.3, 0.05, 0, 0, 0;
    MeanValue thin(Cage(cage), {both, 0.2}); // at the centre all weights are 1/6
    thin.bind(view(x));
    const RowMatrix V = thin.weights().dense();
    EXPECT_LT((V.rowwise().sum().array() - 1.0).abs().maxCoeff(), 1e-12);
    EXPECT_GE((V.row(2).array() > 0.0).count(), 4) << "at the centre, where none reaches the threshold";
}

TEST(PointWeights, refuse_thresholds_outside_their_range)
{
    for (const double threshold : {-0.1, 1.0, std::nan("")})
        EXPECT_THROW(filled(random_rows(2, 3), {both, threshold}), InvalidOption);
}

TEST(PointWeights, name_both_sizes_where_memory_is_short)
{
    const SurfaceMesh cage = shapes::bumpy_sphere(2);
    const Points points = shapes::points_around(cage, 20'000, 0.9);
    const MemoryLimit limit(1 << 20);
    for (const double threshold : {0.0, 1e-6}) {
        const auto error =
            refusal<OutOfMemory>([&] { MeanValue(Cage(cage), {both, threshold}).bind(view(points)); });
        for (const char* part : {"1.0 MB", "weights"})
            EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
}

} // namespace sinew::test_point_weights

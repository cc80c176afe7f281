// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/ffd.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/lattice/lattices.h"
#include "tests/native/refusals.h"
#include "tests/native/wide_kernels.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace sinew::test_ffd {

namespace {

using namespace lattices;
constexpr auto bspline = LatticeBasis::bspline;
constexpr auto bezier = LatticeBasis::bezier;

SpaceVariant variant(const std::string& name, const Points& rest, const Counts& n,
                     const RestGridOptions& chosen)
{
    return {name, [=] { return std::make_shared<Ffd>(RestGrid(view(rest), n, chosen)); }};
}

SpaceTraits traits()
{
    const Counts n{5, 4, 6};
    const Points rest = box(n, {-1, -2, 0}, {1, 1, 2});
    SpaceTraits found{
        .name = "box",
        .variants = {},
        .control = rest,
        .points = in_box(600, {-1.5, -2.5, -0.5}, {1.5, 1.5, 2.5}),
        .similarity = 1e-12,
        .affine = 1e-12,
        .follow = 20.0, // outside, functions go on as lines: a cell away along each axis, they are this large
        .other = [=] {
            return std::make_shared<Ffd>(RestGrid(view(Points(2 * rest)), n, options(bspline)));
        }};
    for (int degree = 1; degree <= 5; ++degree)
        found.variants.push_back(
            variant("degree " + std::to_string(degree), rest, n, options(bspline, degree)));
    found.variants.push_back(variant("bezier", rest, n, options(bezier)));
    return found;
}

SpaceTraits bent_traits()
{
    const Counts n{4, 3, 5};
    SpaceTraits found = traits();
    const Points rest = bent(box(n, {-1, -2, 0}, {1, 1, 2}));
    found.name = "bent";
    found.control = rest;
    found.variants = {variant("cubic", rest, n, options(bspline)),
                      variant("bezier", rest, n, options(bezier))};
    // Inside the bent lattice: outside, lines of the map may cross, and a point takes the nearest parameters.
    found.points = bent(in_box(600, {-1, -2, 0}, {1, 1, 2}));
    found.similarity = found.affine = 1e-9; // Newton's method stops at 1e-10 of the size
    found.other = {};
    return found;
}

SpaceTraits blender_traits()
{
    const Counts n{5, 4, 6};
    SpaceTraits found = traits();
    found.name = "blender";
    found.variants.clear();
    for (const auto& [name, basis] : {std::pair{"linear", LatticeBasis::linear},
                                      {"cardinal", LatticeBasis::cardinal},
                                      {"catmull_rom", LatticeBasis::catmull_rom},
                                      {"spline", LatticeBasis::blender_spline}})
        found.variants.push_back(variant(name, found.control, n, options(basis)));
    found.similarity = found.affine = {};
    return found;
}

SpaceTraits hexahedra_traits()
{
    const SurfaceMesh mesh = boxes({2, 3, 2}, {-1, -2, 0}, {1, 1, 2});
    const Points rest = bent(mesh.points());
    SpaceTraits found = traits();
    found.name = "hexahedra";
    found.control = rest;
    found.variants.clear();
    for (int smooth = 0; smooth <= 2; ++smooth)
        found.variants.push_back(
            {"smooth " + std::to_string(smooth),
             [=] { return std::make_shared<Ffd>(Hexahedra(shapes::moved(mesh, rest), smooth)); }});
    found.similarity = found.affine = 1e-9; // places are found to 1e-9 of the size
    found.follow = 12.0; // outside, a point follows the affine map of the nearest cell
    found.other = [=] { return std::make_shared<Ffd>(Hexahedra(mesh, 1)); };
    return found;
}

std::unique_ptr<Ffd> ffd(const Points& rest, const Counts& n, const RestGridOptions& chosen,
                         const Points& points)
{
    auto made = std::make_unique<Ffd>(RestGrid(view(rest), n, chosen));
    made->bind(view(points));
    return made;
}

/// How far each point moves if control point `index` moves by one along x.
VectorX response(const Ffd& method, const Points& rest, int index)
{
    Points posed = rest;
    posed(index, 0) += 1.0;
    return (warped(method, posed) - method.points()).col(0);
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Ffd, SpaceContract,
                         testing::Values(traits(), bent_traits(), blender_traits(), hexahedra_traits()));

TEST(Ffd, centre_of_a_quadratic_unit_cube)
{
    const Points rest = box({3, 3, 3}), centre = Points::Constant(1, 3, 0.5);
    for (const LatticeBasis basis : {bezier, bspline})
        EXPECT_NEAR(response(*ffd(rest, {3, 3, 3}, options(basis, 2), centre), rest, 13)[0], 0.125, 1e-15);
}

TEST(Ffd, bezier_lattices_blend_by_bernstein_polynomials)
{
    const auto bernstein = [](int i, int n, double t) {
        return std::exp(std::lgamma(n + 1.0) - std::lgamma(i + 1.0) - std::lgamma(n - i + 1.0)) *
               std::pow(t, i) * std::pow(1 - t, n - i);
    };
    const Points points = in_box(30, {0, 0, 0}, {1, 1, 1});
    for (const Counts& n : {Counts{2, 3, 4}, Counts{5, 6, 2}, Counts{9, 1, 16}}) {
        const Points rest = box(n);
        const auto method = ffd(rest, n, options(bezier), points);
        for (int index = 0; index < rest.rows(); index += 7) {
            const Counts at{index % n[0], index / n[0] % n[1], index / (n[0] * n[1])};
            const VectorX moved = response(*method, rest, index);
            for (int p = 0; p < points.rows(); ++p) {
                double expected = 1.0;
                for (int axis = 0; axis < 3; ++axis)
                    expected *= bernstein(at[axis], n[axis] - 1, points(p, axis));
                EXPECT_NEAR(moved[p], expected, 1e-12); // powers of a half lose some digits at 16 points
            }
        }
    }
}

TEST(Ffd, one_moved_point_reaches_degree_plus_one_spans_and_blends_with_continuous_derivatives)
{
    for (int degree = 1; degree <= 5; ++degree) {
        const Counts n{12, 1, 1};
        Points line(20001, 3);
        for (int i = 0; i < line.rows(); ++i)
            line.row(i) << i / 20000.0, 0.5, 0.5;
        const Points rest = box(n);
        const VectorX f = response(*ffd(rest, n, options(bspline, degree), line), rest, 6);
        int reached = 0;
        for (int i = 0; i < f.size(); ++i)
            reached += f[i] > 0.0 ? 1 : 0;
        // Spans near the ends are shorter, since the places of the points are even.
        const AxisBasis axis(bspline, 12, degree, LatticeOutside::follow);
        const double begin = axis.place(std::max(6 - degree, 0)), end = axis.place(std::min(7, 12 - degree));
        EXPECT_NEAR(reached / 20000.0, (end - begin) / 11.0, 0.002) << degree;
        // The derivative of order degree is piecewise constant, so that of one order less has no jump.
        VectorX derivative = f;
        double before = 1.0;
        for (int order = 1; order < degree && order <= 2; ++order) {
            const VectorX next =
                (derivative.tail(derivative.size() - 1) - derivative.head(derivative.size() - 1)) * 20000.0;
            const double step =
                (next.tail(next.size() - 1) - next.head(next.size() - 1)).cwiseAbs().maxCoeff();
            before = next.cwiseAbs().maxCoeff();
            derivative = next;
            EXPECT_LT(step, 0.01 * before) << degree << " order " << order;
        }
    }
}

TEST(Ffd, frozen_borders_end_the_deformation_with_continuous_derivatives)
{
    const Counts n{11, 1, 1};
    const Points rest = box(n);
    constexpr double h = 1e-3;
    for (int k = 0; k <= 2; ++k) {
        Points line(6, 3);
        for (int i = 0; i < 6; ++i)
            line.row(i) << 1.0 - 4 * h + i * h, 0.5, 0.5; // four inside, one on the border, one outside
        const auto method = ffd(rest, n, options(bspline, 3, LatticeOutside::freeze, k), line);
        Points posed = rest;
        posed.col(0).array() += 1.0; // all
        const VectorX moved = (warped(*method, posed) - line).col(0);
        EXPECT_EQ(moved[4], 0.0);
        EXPECT_EQ(moved[5], 0.0);
        // Inside, the move grows with the power k + 1 of the distance.
        const double power = std::log(moved[0] / moved[2]) / std::log(2.0);
        EXPECT_NEAR(power, k + 1.0, 0.1) << k;
        EXPECT_GT(moved[0], 0.0);
    }
}

TEST(Ffd, all_planes_frozen_are_refused)
{
    const Points rest = box({4, 4, 4});
    const auto make = [&](int k) {
        return RestGrid(view(rest), {4, 4, 4}, options(bspline, 3, LatticeOutside::freeze, k));
    };
    EXPECT_NO_THROW(make(0));
    EXPECT_THROW(make(1), InvalidOption);
    EXPECT_THROW(make(-1), InvalidOption);
}

TEST(Ffd, blenders_functions_are_those_of_its_curves_and_constant_far_away)
{
    const Counts n{4, 1, 1};
    const Points rest = box(n);
    Points line(7, 3);
    const double x[] = {-7, -0.4, 0.1, 0.5, 0.95, 1.3, 9};
    for (int i = 0; i < 7; ++i)
        line.row(i) << x[i], 0.0, 3.0;
    for (const auto& [basis, a] :
         {std::pair{LatticeBasis::cardinal, 0.71}, {LatticeBasis::catmull_rom, 0.5}}) {
        const auto method = ffd(rest, n, options(basis), line);
        VectorX sum = VectorX::Zero(7);
        for (int c = 0; c < 4; ++c) {
            const VectorX moved = response(*method, rest, c);
            sum += moved;
            for (int i = 0; i < 7; ++i) {
                const double u = std::clamp(3 * x[i], -9.0, 9.0), cell = std::floor(u), t = u - cell;
                double expected = 0.0;
                for (int k = -1; k <= 2; ++k) {
                    const double d = std::abs(t - k); // the kernel by the distance of the neighbour
                    const double w = d < 1 ? (2 - a) * d * d * d + (a - 3) * d * d + 1
                                           : -a * d * d * d + 5 * a * d * d - 8 * a * d + 4 * a;
                    expected += std::clamp(static_cast<int>(cell) + k, 0, 3) == c ? w : 0.0;
                }
                EXPECT_NEAR(moved[i], expected, 1e-13) << x[i];
            }
        }
        EXPECT_LT((sum.array() - 1.0).abs().maxCoeff(), 1e-14);
    }
}

TEST(Ffd, lattices_of_few_points_follow_what_they_have)
{
    const Points points = in_box(50, {-0.5, -0.5, -0.5}, {1.5, 1.5, 1.5});
    for (const LatticeBasis basis : {bspline, bezier, LatticeBasis::linear, LatticeBasis::blender_spline})
        for (const Counts& n :
             {Counts{1, 1, 1}, Counts{2, 1, 1}, Counts{1, 3, 1}, Counts{2, 2, 1}, Counts{1, 2, 5}}) {
            const Points rest = box(n);
            const auto method = ffd(rest, n, options(basis), points);
            const Points moved = rest.rowwise() + Eigen::RowVector3d(1, 2, 3);
            EXPECT_LT(
                shapes::distance(warped(*method, moved), points.rowwise() + Eigen::RowVector3d(1, 2, 3)),
                1e-13);
        }
}

TEST(Ffd, a_bent_lattice_places_points_by_its_own_map)
{
    // Points made by the map of a bent rest lattice must come out where the posed lattice's map has them.
    const Counts n{4, 4, 4};
    const Points straight = box(n), rest = bent(straight), shares = in_box(300, {0, 0, 0}, {1, 1, 1});
    for (const LatticeBasis basis : {bspline, bezier}) {
        const auto map = ffd(straight, n, options(basis), shares);
        const Points points = warped(*map, rest);
        const auto method = ffd(rest, n, options(basis), points);
        const Points posed = shapes::Random(3).shaken(rest, 0.3);
        EXPECT_LT(shapes::distance(warped(*method, posed), warped(*map, posed)), 1e-9);
    }
}

// Folded and flat ones are refused in tests/bindings/spaces/test_lattices.py.
TEST(Ffd, points_that_are_not_finite_are_named_and_too_many_are_refused)
{
    Points rest = box({3, 3, 3});
    rest(4, 1) = std::numeric_limits<double>::quiet_NaN();
    const auto make = [&] { RestGrid(view(rest), {3, 3, 3}, options(bspline)); };
    expect_elements(refusal<InvalidMesh>(make), Error::Element::vertex, {4});
    EXPECT_THROW(RestGrid(view(box({17, 1, 1})), {17, 1, 1}, options(bezier)), InvalidOption);
}

TEST(Ffd, mirrored_lattices_are_not_folded)
{
    const Points rest = box({3, 3, 3}, {1, 0, 0}, {-1, 1, 1}), points = in_box(20, {-1, 0, 0}, {1, 1, 1});
    const auto method = ffd(rest, {3, 3, 3}, options(bspline), points);
    EXPECT_LT(shapes::distance(warped(*method, 2 * rest), 2 * points), 1e-13);
}

TEST(Ffd, names_the_points_outside)
{
    Points points = in_box(4, {0.1, 0.1, 0.1}, {0.9, 0.9, 0.9});
    points(2, 1) = 1.01;
    Ffd method(RestGrid(view(box({4, 4, 4})), {4, 4, 4}, options(bspline)));
    EXPECT_EQ(method.bind(view(points)).outside, std::vector{2});
    Ffd cells(Hexahedra(boxes({2, 2, 2}), 1));
    EXPECT_EQ(cells.bind(view(points)).outside, std::vector{2});
}

TEST(Ffd, every_kernel_gives_the_same_bits)
{
    shapes::Random random(7);
    const MatrixX moves = random.dense(3, 16 * 16 * 16), local = random.dense(8, 3);
    for (const int width : {1, 2, 4, 5, 16}) {
        const MatrixX rows = random.dense(width * 6, 3);
        BlendCell cell{};
        for (int axis = 0; axis < 3; ++axis)
            cell.axes[axis] = {rows.col(axis).data(), width, 5};
        cell.moves = moves.data();
        cell.strides[0] = 48;
        cell.strides[1] = 768;
        std::array<double, 24> expected{}, found{};
        BlendKernels::baseline.blend(cell, local.data(), expected.data());
        for (const BlendKernels* kernels : wide_kernels<BlendKernels>()) {
            kernels->blend(cell, local.data(), found.data());
            EXPECT_EQ(found, expected) << width;
        }
    }
}

TEST(Hexahedra, are_found_in_boxes_and_between_them)
{
    EXPECT_EQ(find_hexahedra(boxes({1, 1, 1})).size(), 1u);
    EXPECT_EQ(find_hexahedra(boxes({3, 2, 4})).size(), 24u);
    EXPECT_TRUE(find_hexahedra(shapes::octahedron()).empty());
    EXPECT_THROW(Hexahedra(shapes::octahedron(), 1), InvalidMesh);
    EXPECT_THROW(Hexahedra(boxes({1, 1, 1}), 5), InvalidOption);
}

TEST(Hexahedra, subdivision_keeps_a_box_and_is_the_tensor_product_of_cubic_splines_inside)
{
    const SurfaceMesh mesh = boxes({4, 4, 4}, {0, 0, 0}, {4, 4, 4});
    const RefinedCells finer = refined(find_hexahedra(mesh), mesh.vertex_count());
    EXPECT_EQ(finer.cells.size(), 8 * 64u);
    const Points points = finer.weights * mesh.points();
    EXPECT_LT((finer.weights * VectorX::Ones(125) - VectorX::Ones(points.rows())).cwiseAbs().maxCoeff(),
              1e-14);
    EXPECT_NEAR(points.minCoeff(), 0.0, 1e-15);
    EXPECT_NEAR(points.maxCoeff(), 4.0, 1e-15);
    const int middle = 2 + 5 * (2 + 5 * 2);
    const double along[3] = {1.0 / 8, 6.0 / 8, 1.0 / 8};
    for (int n = 0; n < 27; ++n) {
        const int at = 1 + n % 3 + 5 * (1 + n / 3 % 3 + 5 * (1 + n / 9));
        EXPECT_NEAR(finer.weights.coeff(middle, at), along[n % 3] * along[n / 3 % 3] * along[n / 9], 1e-15);
    }
}

TEST(Hexahedra, folded_cells_are_named)
{
    const SurfaceMesh mesh = boxes({2, 1, 1});
    Points points = mesh.points();
    points(1, 0) = 1.5; // the corner between the two cells goes beyond the second one
    const InvalidMesh folded = refusal<InvalidMesh>([&] { Hexahedra(shapes::moved(mesh, points), 0); });
    EXPECT_TRUE(std::find(folded.elements().begin(), folded.elements().end(), 1) != folded.elements().end());
}

} // namespace sinew::test_ffd

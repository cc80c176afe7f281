// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic.h"
#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

#include <array>
#include <map>

namespace sinew::test_grid {

namespace {

using cages::largest;

HarmonicOptions lattice(HarmonicQuality quality = HarmonicQuality::fast)
{
    HarmonicOptions options;
    options.weights = cages::doubles;
    options.quality = quality;
    options.solver = HarmonicSolver::lattice;
    return options;
}

RowMatrix weights(const SurfaceMesh& cage, const Points& points, const HarmonicOptions& options = lattice())
{
    return cages::weights<Harmonic>(cage, points, options);
}

void expect_barycentric(const RowMatrix& w, const SurfaceMesh& cage, const Points& points)
{
    cages::expect_barycentric(w, cage, points, 1e-12);
}

/// The box [0, size], each side a grid of squares, or of twice as many triangles.
SurfaceMesh box(std::array<int, 3> cells, const Vector3& size, bool triangles)
{
    std::map<std::array<int, 3>, int> number;
    std::vector<Vector3> p;
    shapes::Polygons faces;
    const auto vertex = [&](const std::array<int, 3>& at) {
        const auto [entry, is_new] = number.try_emplace(at, static_cast<int>(p.size()));
        if (is_new)
            p.emplace_back(size[0] * at[0] / cells[0], size[1] * at[1] / cells[1],
                           size[2] * at[2] / cells[2]);
        return entry->second;
    };
    for (int axis = 0; axis < 3; ++axis)
        for (int side = 0; side < 2; ++side) {
            const int u = (axis + (side ? 1 : 2)) % 3, v = (axis + (side ? 2 : 1)) % 3;
            for (int i = 0; i < cells[u]; ++i)
                for (int j = 0; j < cells[v]; ++j) {
                    const auto corner = [&](int du, int dv) {
                        std::array<int, 3> at;
                        at[axis] = side * cells[axis];
                        at[u] = i + du;
                        at[v] = j + dv;
                        return vertex(at);
                    };
                    const int a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
                    if (triangles) {
                        faces.push_back({a, b, c});
                        faces.push_back({a, c, d});
                    } else {
                        faces.push_back({a, b, c, d});
                    }
                }
        }
    return shapes::mesh(p, faces);
}

/// Of the vertices of a box [0, 1]^3: the eight functions that are linear along each axis, at some points.
RowMatrix trilinear(const Points& points)
{
    RowMatrix values = RowMatrix::Ones(points.rows(), 8);
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        for (int v = 0; v < 8; ++v)
            for (int axis = 0; axis < 3; ++axis)
                values(i, v) *= v >> axis & 1 ? points(i, axis) : 1 - points(i, axis);
    return values;
}

/// The time of a lattice is that of its nodes inside and of the vertices: what is slender has few nodes.
const Vector3 slender(1, .4, .4);

/// A slender sphere of triangles with shallow bumps: 8 of them at level 0, 128 and 66 vertices at level 2.
SurfaceMesh bumpy(int level)
{
    const SurfaceMesh round = shapes::bumpy_sphere(level, 0.01);
    return shapes::moved(round, round.points() * slender.asDiagonal());
}

/// Within the ball of that radius, made as slender.
Points in_bumpy(int count, double radius) { return cages::in_ball(count, radius) * slender.asDiagonal(); }

SpaceTraits traits()
{
    const SurfaceMesh cage = bumpy(1);
    return {
        .name = "HarmonicGrid",
        .variants = {cages::variant<Harmonic>("lattice", cage, lattice())},
        .control = cage.points(),
        .points = in_bumpy(200, 0.5),
        .affine = 3e-12,
        .outside = Vector3(3, 0, 0),
        .refuses_outside = true,
        .other = [cage] { return std::make_shared<Harmonic>(Cage(cage), lattice(HarmonicQuality::medium)); }};
}

} // namespace

INSTANTIATE_TEST_SUITE_P(HarmonicGrid, SpaceContract, testing::Values(traits()));

TEST(HarmonicGrid, sums_to_trilinear_functions_in_a_box_of_squares)
{
    // They are bilinear on every square, so on the cage they are the hats with their values at the vertices,
    // and harmonic inside.
    struct Case
    {
        std::array<int, 3> cells;
        double tolerance;
    };
    for (const Case& at : {Case{{4, 2, 2}, 3e-4},   // 1e-4 where levels meet, and what cycles leave
                           Case{{1, 1, 1}, 1e-4}}) { // the differences are exact: what cycles leave
        const SurfaceMesh cage = box(at.cells, slender, false);
        Points x = cages::in_cube(500);
        x.row(0) << 0.5, 0.5, 1e-7;
        const RowMatrix expected = trilinear(x);
        x *= slender.asDiagonal();
        const RowMatrix w = weights(cage, x);
        EXPECT_LT(largest(w * trilinear(cage.points() * slender.cwiseInverse().asDiagonal()) - expected),
                  at.tolerance);
        expect_barycentric(w, cage, x);
    }
}

TEST(HarmonicGrid, agrees_with_the_boundary_both_ways)
{
    struct Case
    {
        SurfaceMesh cage;
        Points points;
        double most; ///< that both may be off, so that it says something
    };
    for (const auto& [cage, x, most] : {Case{bumpy(1), in_bumpy(400, 0.7), 0.1},
                                        Case{shapes::u_prism(), cages::inside_u_prism(400, 0.05), 0.011}}) {
        HarmonicOptions options = lattice();
        options.solver = HarmonicSolver::boundary;
        Harmonic boundary(Cage(cage), options), grid(Cage(cage), lattice());
        const double boundary_error = boundary.bind(view(x)).error, grid_error = grid.bind(view(x)).error;
        const RowMatrix w = grid.weights().dense();
        const double difference = largest(boundary.weights().dense() - w);
        EXPECT_LT(difference, boundary_error + grid_error);
        EXPECT_LT(boundary_error + grid_error, most);
        EXPECT_GT(difference, 1e-5); // they are two
    }
}

TEST(HarmonicGrid, is_chosen_beyond_600_triangles)
{
    HarmonicOptions automatic = lattice();
    automatic.solver = HarmonicSolver::automatic;
    Points x(1, 3);
    x << .43, .03, .06;
    const SurfaceMesh smaller = box({74, 1, 1}, {1, .1, .1}, true),
                      larger = box({75, 1, 1}, {1, .1, .1}, true);
    EXPECT_EQ(smaller.triangles().size(), 596U);
    EXPECT_EQ(larger.triangles().size(), 604U);
    EXPECT_GT(largest(weights(smaller, x, automatic) - weights(smaller, x)), 0);
    EXPECT_EQ(weights(larger, x, automatic), weights(larger, x));
}

TEST(HarmonicGrid, is_barycentric_and_without_extremum_in_fine_cages_and_close_to_them)
{
    const SurfaceMesh cage = bumpy(3); // 512 triangles
    Points x = in_bumpy(600, 0.97);
    // Just inside of faces, edges and vertices.
    shapes::Random random(2);
    for (int i = 0; i < 300; ++i) {
        const Triangle& t = cage.triangles()[static_cast<std::size_t>(random.below(512))];
        Vector3 hats(random.unit(), i % 3 == 0 ? 0 : random.unit(), i % 3 == 1 ? 0 : random.unit());
        hats /= hats.sum();
        const Vector3 at =
            hats[0] * cage.point(t[0]) + hats[1] * cage.point(t[1]) + hats[2] * cage.point(t[2]);
        x.row(i) = (1 - std::pow(10.0, -2 - i % 7)) * at.transpose();
    }
    x.bottomRows(200) = in_bumpy(200, 0.7);
    auto star = x.bottomRows(7);
    star.rowwise() = Eigen::RowVector3d(.31, -.09, .07);
    constexpr double step = 0.06; // three of the lattice
    for (int k = 0; k < 3; ++k) {
        star(1 + 2 * k, k) += step;
        star(2 + 2 * k, k) -= step;
    }
    const RowMatrix w = weights(cage, x), around = w.bottomRows(7);
    expect_barycentric(w, cage, x);
    EXPECT_LT(w.maxCoeff(), 1);
    EXPECT_LT(w.bottomRows(200).maxCoeff(), 0.2); // far less than the 1 at a vertex
    const Eigen::RowVectorXd mean = around.bottomRows(6).colwise().mean();
    EXPECT_LT((mean - around.row(0)).cwiseAbs().maxCoeff(), 0.02 * around.row(0).maxCoeff());
}

TEST(HarmonicGrid, gives_the_data_on_the_cage)
{
    const SurfaceMesh cage = bumpy(1);
    const int n = cage.vertex_count();
    EXPECT_LT(largest(weights(cage, cage.points()) - RowMatrix::Identity(n, n)), 1e-9);
    Points x(2, 3);
    x << 0, .3, .3, 1e-8, .3, .3; // the middle of a square, and before it
    const RowMatrix w = weights(box({2, 2, 2}, slender, false), x);
    EXPECT_NEAR(w.row(0).maxCoeff(), .25, 1e-9);
    EXPECT_LT(largest(w.row(1) - w.row(0)), 1e-5); // 1e-8 of a square of 1/5, and the mend
}

TEST(HarmonicGrid, follows_limbs_thinner_than_a_step)
{
    // A rod of a hundredth of a step: no node lies inside. On its axis the four sides count alike.
    const SurfaceMesh cage = box({200, 1, 1}, {1, 1e-4, 1e-4}, true);
    Points x(3, 3);
    x << .5, 5e-5, 5e-5, .2525, 2e-5, 7e-5, .9, 9e-5, 1e-5;
    const RowMatrix w = weights(cage, x);
    expect_barycentric(w, cage, x);
    for (Eigen::Index v = 0; v < w.cols(); ++v)
        for (int i = 0; i < 3; ++i)
            if (std::abs(cage.point(static_cast<int>(v)).x() - x(i, 0)) > 0.011) {
                EXPECT_LT(w(i, v), 1e-8); // what the mend may give to faint vertices
            }
    // Two arms a thousandth apart do not feel each other.
    const SurfaceMesh arms = shapes::joined(cage, cage, {0, 1.1e-4, 0});
    const RowMatrix both = weights(arms, x);
    EXPECT_LT(largest(both.leftCols(w.cols()) - w), 1e-8);
    EXPECT_LT(largest(both.rightCols(w.cols())), 1e-8);
}

TEST(HarmonicGrid, is_close_to_the_boundary_in_a_thin_rod)
{
    const SurfaceMesh cage = box({20, 1, 1}, {1, .05, .05}, true); // five steps thick
    const SurfaceMesh thin = box({20, 1, 1}, {1, .009, .009}, true); // less than one
    for (const SurfaceMesh* rod : {&cage, &thin}) {
        Points x(4, 3);
        const double wide = rod->points().col(1).maxCoeff();
        x << .52, .5 * wide, .5 * wide, .31, .3 * wide, .6 * wide, .77, .8 * wide, .7 * wide, .5, .1 * wide,
            .5 * wide;
        HarmonicOptions options = lattice(HarmonicQuality::medium);
        options.solver = HarmonicSolver::boundary;
        const RowMatrix expected = weights(*rod, x, options);
        Harmonic grid(Cage(*rod), lattice());
        const double error = grid.bind(view(x)).error;
        EXPECT_LT(largest(grid.weights().dense() - expected), 0.1);
        EXPECT_LT(largest(grid.weights().dense() - expected), 2 * error + 1e-3);
    }
}

TEST(HarmonicGrid, names_points_outside_or_falls_back_on_mean_values)
{
    const SurfaceMesh cage = box({1, 1, 1}, slender, false);
    Points x(6, 3);
    x << .5, .2, .2, 2, .2, .2, .2, .36, .16, .5, .2, -4e-5, 1e9, 0, 0, .3, .4 + 4e-8, .28;
    cages::expect_outside<Harmonic>(cage, lattice(), x, {1, 3, 4, 5});
}

TEST(HarmonicGrid, tells_inside_from_outside_as_the_winding_number_does)
{
    // Spikes of neighbours a third apart.
    const SurfaceMesh round = cages::bumpy(3, 0.6, 3),
                      cage = shapes::moved(round, round.points() * slender.asDiagonal());
    const Points x = shapes::points_around(cage, 2000, 1);
    HarmonicOptions options = lattice();
    options.outside = CageOutside::mean_value;
    Harmonic harmonic(Cage(cage), options);
    const std::vector<int> outside = harmonic.bind(view(x)).outside;
    const Cage same(cage);
    const CageSurface surface(same);
    std::vector<int> expected;
    for (int i = 0; i < 2000; ++i)
        if (std::abs(surface.winding(x.row(i).transpose()) - 1) > 0.5)
            expected.push_back(i);
    EXPECT_EQ(outside, expected);
}

TEST(HarmonicGrid, is_refused_above_the_memory_limit)
{
    const Points x = in_bumpy(10, 0.5);
    for (const std::int64_t bytes : {1 << 20, 8 << 20, 20 << 20}) { // lattice, its links, the work
        const MemoryLimit limit(bytes);
        EXPECT_THROW(weights(cages::bumpy(1, 1.0, 1), x), OutOfMemory);
    }
    EXPECT_NO_THROW(weights(bumpy(1), x));
}

TEST(HarmonicGrid, of_several_strips_has_the_same_bits_on_one_thread)
{
    const Points x = in_bumpy(1000, 0.95);
    const RowMatrix many = weights(bumpy(2), x); // 66 vertices: five strips
    const ThreadLimit limit(1);
    EXPECT_EQ(weights(bumpy(2), x), many);
}

TEST(HarmonicGrid, lives_with_flat_and_touching_faces)
{
    const SurfaceMesh round = bumpy(1);
    Points points = round.points();
    points.row(0) = points.row(round.triangles()[0][0] == 0 ? round.triangles()[0][1] : 0);
    const SurfaceMesh flat = shapes::moved(round, points);
    const Points x = in_bumpy(100, 0.8);
    expect_barycentric(weights(flat, x), flat, x);
    // Two boxes that share a wall: none of one's weights in the other.
    const SurfaceMesh cube = box({2, 2, 2}, slender, true);
    const SurfaceMesh touching = shapes::joined(cube, cube, {1, 0, 0});
    const Points inside = cages::in_cube(200, 1e-3) * slender.asDiagonal();
    const RowMatrix w = weights(touching, inside);
    expect_barycentric(w, touching, inside);
    EXPECT_LT(largest(w.rightCols(cube.vertex_count())), 1e-3); // what the cycles leave
}

} // namespace sinew::test_grid

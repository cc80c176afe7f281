// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/cells/cell_grid.h"

#include "tests/native/methods/space/nonlinear/legs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

namespace sinew::test_cell_grid {

namespace {

double volume(const CellGrid& grid)
{
    double sum = 0.0;
    for (const Cell& cell : grid.cells())
        sum += std::pow(2 * cell.half, 3);
    return sum;
}

} // namespace

TEST(CellGrid, fills_a_solid_with_about_as_many_cells_as_wanted)
{
    const SurfaceMesh ball = shapes::sphere(4);
    for (const int wanted : {100, 1000, 5000}) {
        const CellGrid grid(ball, wanted, 3, {});
        EXPECT_NEAR(grid.size(), wanted, 0.3 * wanted);
        EXPECT_GT(volume(grid), 4.0 / 3.0 * shapes::pi * 0.98); // the mesh is inside of the sphere
    }
    EXPECT_NEAR(volume(CellGrid(ball, 20000, 3, {})), 4.0 / 3.0 * shapes::pi, 0.7);
}

TEST(CellGrid, neighbours_differ_by_one_level_at_most_and_sides_of_a_cell_inside_are_covered_once)
{
    const CellGrid grid(shapes::sphere(4), 3000, 4, {});
    std::set<long> sizes;
    for (const Cell& cell : grid.cells())
        sizes.insert(std::lround(1e6 * cell.half));
    EXPECT_GE(sizes.size(), 3);
    std::vector<double> covered(grid.size(), 0.0);
    for (const CellFace& face : grid.faces()) {
        const double one = grid.cells()[face.cell[0]].half, other = grid.cells()[face.cell[1]].half;
        EXPECT_LT(std::abs(std::log2(one / other)), 1 + 1e-9);
        EXPECT_EQ(face.half, std::min(one, other)) << "the smaller of the two sides";
        for (const int c : face.cell) { // the middle of the side is on both
            covered[c] += 4 * face.half * face.half;
            const Vector3 apart = (face.middle - grid.cells()[c].centre).cwiseAbs();
            EXPECT_NEAR(apart[face.axis], grid.cells()[c].half, 1e-9);
            EXPECT_LE(apart.maxCoeff(), grid.cells()[c].half + 1e-9);
        }
    }
    int whole = 0;
    for (int c = 0; c < grid.size(); ++c) {
        const double surface = 24 * grid.cells()[c].half * grid.cells()[c].half;
        EXPECT_LE(covered[c], surface * (1 + 1e-9));
        whole += covered[c] > surface * (1 - 1e-9);
    }
    EXPECT_GT(whole, grid.size() / 4);
}

TEST(CellGrid, legs_side_by_side_are_not_linked)
{
    const SurfaceMesh mesh = legs::pair();
    int touching = 0;
    for (int wanted = 60; wanted <= 600; wanted += 20) {
        const CellGrid grid(mesh, wanted, 2, {});
        std::vector<int> legs_in(grid.size(), 0); // 1 for one leg, 2 for the other
        for (int v = 0; v < mesh.vertex_count(); ++v)
            if (const int side = legs::side(mesh.point(v)); side != 0)
                legs_in[grid.cell_at(mesh.point(v))] |= side < 0 ? 1 : 2;
        if (std::ranges::count(legs_in, 3) > 0)
            continue; // cells that are too large to tell them apart
        const auto differ = [&](int a, int b) { return legs_in[a] + legs_in[b] == 3 && legs_in[a] % 3 != 0; };
        for (const CellFace& face : grid.faces())
            EXPECT_FALSE(differ(face.cell[0], face.cell[1])) << wanted;
        for (int a = 0; a < grid.size(); ++a)
            for (int b = 0; b < a; ++b) {
                const Cell &one = grid.cells()[a], &other = grid.cells()[b];
                const Vector3 apart = (one.centre - other.centre).cwiseAbs();
                touching += differ(a, b) && apart.maxCoeff() < 1.01 * (one.half + other.half) &&
                            apart.sum() < 1.01 * apart.maxCoeff();
            }
    }
    EXPECT_GT(touching, 20) << "cells of both touch somewhere, so the test says something";
}

TEST(CellGrid, loose_pieces_are_joined_to_held_ones_that_are_near)
{
    const SurfaceMesh near = shapes::joined(shapes::sphere(3), shapes::sphere(2), {2.7, 0, 0});
    CellGrid grid(near, 400, 2, {});
    const std::size_t before = grid.faces().size();
    std::vector<char> held(grid.size(), 0);
    held[grid.cell_at({-1, 0, 0})] = 1;
    EXPECT_TRUE(grid.join_loose_pieces(held).empty());
    ASSERT_EQ(grid.faces().size(), before + 1);
    EXPECT_EQ(grid.faces().back().axis, -1);
    held[grid.cell_at({2.7, 0, 0})] = 1;
    CellGrid other(near, 400, 2, {});
    other.join_loose_pieces(held);
    EXPECT_EQ(other.faces().size(), before) << "each has a handle of its own";

    const SurfaceMesh far = shapes::joined(shapes::sphere(3), shapes::sphere(2), {4, 0, 0});
    CellGrid apart(far, 400, 2, {});
    held.assign(apart.size(), 0);
    held[apart.cell_at({-1, 0, 0})] = 1;
    const std::vector<int> loose = apart.join_loose_pieces(held);
    EXPECT_FALSE(loose.empty());
    for (const int cell : loose)
        EXPECT_GT(apart.cells()[cell].centre[0], 2.0);
}

TEST(CellGrid, weights_are_smooth_and_sum_to_one_after_division)
{
    const SurfaceMesh ball = shapes::sphere(4);
    const CellGrid grid(ball, 1500, 3, {});
    // Along a line just inside of the surface, weights change little from point to point.
    Points line(4000, 3);
    for (int k = 0; k < line.rows(); ++k) {
        const double angle = 2 * shapes::pi * k / static_cast<double>(line.rows());
        line.row(k) << 0.95 * std::cos(angle), 0.95 * std::sin(angle) * 0.8, 0.57 * std::sin(angle);
    }
    std::vector<int> outside;
    const auto shares = grid.shares(view(line), outside);
    EXPECT_TRUE(outside.empty());
    const auto normalised = [&](int k) {
        std::map<int, double> result;
        double sum = 0.0;
        for (const auto& share : shares[k])
            sum += share.weight;
        for (const auto& share : shares[k])
            result[share.map] = share.weight / sum;
        return result;
    };
    double most = 0.0;
    for (int k = 1; k < line.rows(); ++k) {
        std::map<int, double> change = normalised(k);
        for (const auto& [cell, weight] : normalised(k - 1))
            change[cell] -= weight;
        double sum = 0.0;
        for (const auto& [cell, weight] : change)
            sum += std::abs(weight);
        most = std::max(most, sum);
    }
    // A step is a thousandth of the ball, and a side of a cell about a tenth: without jumps, weights change
    // by some slopes times a hundredth.
    EXPECT_LT(most, 0.15);
}

TEST(CellGrid, takes_a_point_a_line_and_a_sheet)
{
    for (const SurfaceMesh& mesh : {SurfaceMesh(Points::Zero(1, 3), {}, {}), shapes::grid(10, 10),
                                    SurfaceMesh(shapes::grid_points(50, 0), {}, {}), shapes::messy()}) {
        const CellGrid grid(mesh, 300, 2, {});
        EXPECT_GE(grid.size(), 1);
        std::vector<int> outside;
        for (const auto& shares : grid.shares(view(mesh.points()), outside))
            EXPECT_FALSE(shares.empty());
        std::vector<int> loose; // cells hold all faces; without any, all points
        if (!mesh.triangles().empty())
            for (int v = 0; v < mesh.vertex_count(); ++v)
                if (std::ranges::none_of(mesh.triangles(),
                                         [v](const Triangle& t) { return std::ranges::count(t, v) > 0; }))
                    loose.push_back(v);
        EXPECT_EQ(outside, loose);
    }
}

} // namespace sinew::test_cell_grid

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/handles/handle_fields.h"

#include "native/operators/laplacian.h"
#include "tests/native/refusals.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>

namespace sinew::test_handle_fields {

namespace {

/// The fields of handles on a mesh, and what they are made of.
struct Bound
{
    Bound(const SurfaceMesh& mesh, const std::vector<Handle>& handles, Field field)
        : parts(connected_components(mesh)), regions(handles, parts)
    {
        auto L = std::make_shared<SparseMatrix>(laplacian_matrix(mesh, Discretization::cotan));
        system.factorize(std::move(L), regions);
        const HandleGroups groups(regions, parts);
        fields = field == Field::harmonic ? HandleFields(groups, regions, system)
                                          : HandleFields(groups, regions, mesh, field);
    }
    double operator()(int vertex, int handle) const
    {
        return fields.share(vertex, fields.groups().part_handle({vertex, handle}));
    }

    Components parts;
    Regions regions;
    ConstrainedSystem system;
    HandleFields fields;
};

/// An open tube along x of the radius 1, straight quads cut alike.
SurfaceMesh tube(int along, int around, double length)
{
    std::vector<Vector3> p;
    shapes::Polygons faces;
    for (int i = 0; i <= along; ++i)
        for (int j = 0; j < around; ++j) {
            const double angle = 2 * shapes::pi * j / around;
            p.emplace_back(length * i / along, std::cos(angle), std::sin(angle));
            if (i == along)
                continue;
            const int a = i * around + j, b = i * around + (j + 1) % around;
            faces.push_back({a, b, b + around});
            faces.push_back({a, b + around, a + around});
        }
    return shapes::mesh(p, faces);
}

constexpr std::array every{Field::harmonic, Field::geodesic, Field::euclidean};

} // namespace

TEST(HandleFields, are_linear_along_a_regular_tube)
{
    const SurfaceMesh mesh = tube(20, 12, 10);
    for (Field field : every) {
        const Bound bound(mesh, shapes::ends(mesh, 1.1), field);
        for (int v = 0; v < mesh.vertex_count(); ++v) {
            const double s = std::clamp((mesh.point(v).x() - 1) / 8, 0.0, 1.0);
            EXPECT_NEAR(bound(v, 1), s, 1e-12);
            EXPECT_NEAR(bound(v, 0), 1 - s, 1e-12);
        }
    }
}

TEST(HandleFields, of_harmonic_kind_stay_between_their_handles_where_angles_are_obtuse)
{
    // Rows of flat triangles, whose long edges have negative weights. The plain equation leaves [0, 1] there.
    std::vector<Vector3> p;
    shapes::Polygons faces;
    constexpr int rows = 6, columns = 8;
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j)
            p.emplace_back(4.0 * j + (i % 2 ? 3.6 : 0.0), i, 0.3 * ((i + j) % 3));
    for (int i = 0; i + 1 < rows; ++i)
        for (int j = 0; j + 1 < columns; ++j) {
            const int a = i * columns + j;
            faces.push_back({a, a + 1, a + columns});
            faces.push_back({a + 1, a + columns + 1, a + columns});
        }
    const SurfaceMesh mesh = shapes::mesh(p, faces);
    const std::vector<Handle> handles{{{18}, {}}, {{20}, {}}, {{27}, {0.4}}};
    const Bound bound(mesh, handles, Field::harmonic);
    MatrixX ones = MatrixX::Zero(3, 1);
    ones(1, 0) = 1.0;
    const RowMatrix plain = bound.system.spread(ones);
    EXPECT_LT(plain.minCoeff(), -0.1);
    for (int v = 0; v < mesh.vertex_count(); ++v)
        for (int h = 0; h < 3; ++h) {
            EXPECT_GE(bound(v, h), -1e-12);
            EXPECT_LE(bound(v, h), 1 + 1e-12);
        }
}

TEST(HandleFields, by_straight_distances_are_shares_of_their_inverses)
{
    const SurfaceMesh mesh = shapes::joined(shapes::sphere(3), shapes::sphere(2), {2.5, 0, 0});
    const int n = 258;
    std::vector<Handle> handles{{{}, {}}, {{1}, {}}, {{4, n + 5}, {}}, {{40, 41}, {.5, .9}}};
    for (int v = 50; v < 250; v += 3) // more than one leaf of the tree; and what reaches across the gap
        handles[0].vertices.push_back(v);
    handles[0].vertices.push_back(n + 1);
    const Bound bound(mesh, handles, Field::euclidean);
    double edge = 0.0;
    for (const auto& [a, b] : mesh.edges())
        edge += (mesh.point(a) - mesh.point(b)).norm() / static_cast<double>(mesh.edges().size());
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        if (bound.regions.hard(v) >= 0)
            continue;
        std::array<double, 4> closeness{};
        double sum = 0.0;
        for (int h = 0; h < 4; ++h) {
            double nearest = std::numeric_limits<double>::infinity();
            for (std::size_t k = 0; k < handles[h].vertices.size(); ++k) {
                const int at = handles[h].vertices[k];
                const double weight = handles[h].weights.empty() ? 1.0 : handles[h].weights[k];
                if ((at < n) == (v < n))
                    nearest = std::min(nearest, (mesh.point(at) - mesh.point(v)).norm() +
                                                    edge * (1 - weight) / weight);
            }
            sum += closeness[h] = 1.0 / nearest;
        }
        for (int h : v < n ? std::vector{0, 1, 2, 3} : std::vector{0, 2})
            EXPECT_NEAR(bound(v, h), closeness[h] / sum, 1e-13);
    }
}

TEST(HandleFields, are_one_on_their_handle_and_share_the_rest)
{
    const SurfaceMesh mesh = shapes::joined(shapes::sphere(3), shapes::sphere(2), {5, 0, 0});
    const int n = 258, all = mesh.vertex_count();
    const std::vector<Handle> handles{
        {{0, n}, {}}, {{1}, {}}, {{4, n + 5}, {}}, {{40, 41, 42}, {.5, .5, .9}}};
    for (Field field : every) {
        const Bound bound(mesh, handles, field);
        for (int v = 0; v < all; ++v) {
            const std::vector<int> own = v < n ? std::vector{0, 1, 2, 3} : std::vector{0, 2};
            double sum = 0.0;
            for (int h : own) {
                EXPECT_GE(bound(v, h), -1e-14);
                EXPECT_LE(bound(v, h), 1 + 1e-14);
                sum += bound(v, h);
                if (const int hard = bound.regions.hard(v); hard >= 0) {
                    EXPECT_EQ(bound(v, h), hard == h ? 1.0 : 0.0);
                }
            }
            EXPECT_NEAR(sum, 1.0, 1e-14);
        }
    }
}

TEST(HandleFields, of_soft_handles_reach_those_of_hard_ones_as_the_weight_nears_one)
{
    const SurfaceMesh mesh = shapes::hill(8, 8);
    std::vector<Handle> handles = shapes::ends(mesh, 1.5);
    for (Field field : every) {
        const Bound hard(mesh, handles, field);
        double before = 1.0;
        for (double weight : {0.5, 0.99, 0.9999, 1 - 1e-8}) {
            std::vector<Handle> soft = handles;
            soft[1].weights.assign(soft[1].vertices.size(), weight);
            const Bound bound(mesh, soft, field);
            double gap = 0.0;
            for (int v = 0; v < mesh.vertex_count(); ++v)
                gap = std::max(gap, std::abs(bound(v, 1) - hard(v, 1)));
            EXPECT_LT(gap, 0.5 * before);
            before = gap;
        }
        EXPECT_LT(before, 1e-7);
        handles[1].weights.assign(handles[1].vertices.size(), 1e-300);
        EXPECT_LT(Bound(mesh, handles, field)(40, 1), 1e-9);
        handles[1].weights.clear();
    }
}

TEST(HandleFields, blend_what_they_share_and_keep_what_all_have_in_common)
{
    const SurfaceMesh mesh = shapes::joined(shapes::hill(8, 8), shapes::hill(6, 6), {0, 20, 0});
    const std::vector<Handle> handles{{{0, 1, 9}, {}}, {{80, 79}, {}}, {{40}, {}}, {{90}, {}}};
    const Bound bound(mesh, handles, Field::harmonic);
    const RowMatrix values = shapes::Random(1).dense(4, 5), alike = values.row(0).replicate(4, 1);
    RowMatrix found = RowMatrix::Constant(mesh.vertex_count(), 5, 7.0);
    bound.fields.blend(values, found);
    for (int v = 0; v < mesh.vertex_count(); ++v) {
        VectorX expected = VectorX::Zero(5);
        for (int h = 0; h < 4; ++h)
            if ((h < 3) == (v < 81))
                expected += bound(v, h) * values.row(h).transpose();
        EXPECT_LT((found.row(v).transpose() - expected).norm(), 1e-14);
    }
    bound.fields.blend(alike, found);
    for (int v = 0; v < mesh.vertex_count(); ++v)
        EXPECT_EQ(found.row(v), alike.row(0));
}

TEST(HandleFields, leave_parts_without_a_handle_alone)
{
    const SurfaceMesh mesh = shapes::joined(shapes::sphere(1), shapes::sphere(1), {5, 0, 0});
    for (Field field : every) {
        const Bound bound(mesh, {{{0}, {}}, {{1}, {}}}, field);
        RowMatrix found = RowMatrix::Constant(36, 2, 7.0);
        bound.fields.blend(RowMatrix::Zero(2, 2), found);
        EXPECT_EQ(found.topRows(18).cwiseAbs().maxCoeff(), 0.0);
        EXPECT_EQ(found.bottomRows(18), RowMatrix::Constant(18, 2, 7.0));
    }
}

TEST(HandleFields, above_the_memory_limit_are_refused)
{
    const SurfaceMesh mesh = shapes::hill(40, 40);
    const Bound bound(mesh, shapes::ends(mesh, 1.5), Field::geodesic);
    const MemoryLimit limit(1000);
    for (Field field : {Field::geodesic, Field::euclidean})
        EXPECT_THROW(HandleFields(bound.fields.groups(), bound.regions, mesh, field), OutOfMemory);
    EXPECT_THROW(HandleFields(bound.fields.groups(), bound.regions, bound.system), OutOfMemory);
}

} // namespace sinew::test_handle_fields

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/ffd.h"

#include "tests/native/methods/space/contract.h"
#include "tests/native/methods/space/lattice/lattices.h"
#include "tests/native/refusals.h"

#include <gtest/gtest.h>

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

} // namespace

// What they do to points is in tests/bindings/spaces/test_lattices.py.
INSTANTIATE_TEST_SUITE_P(Ffd, SpaceContract,
                         testing::Values(traits(), bent_traits(), blender_traits(), hexahedra_traits()));

TEST(Ffd, names_the_points_outside)
{
    Points points = in_box(4, {0.1, 0.1, 0.1}, {0.9, 0.9, 0.9});
    points(2, 1) = 1.01;
    Ffd method(RestGrid(view(box({4, 4, 4})), {4, 4, 4}, options(bspline)));
    EXPECT_EQ(method.bind(view(points)).outside, std::vector{2});
    Ffd cells(Hexahedra(boxes({2, 2, 2}), 1));
    EXPECT_EQ(cells.bind(view(points)).outside, std::vector{2});
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

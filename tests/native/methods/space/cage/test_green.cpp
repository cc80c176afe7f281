// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/green.h"

#include "tests/native/methods/space/cage/cages.h"

#include <gtest/gtest.h>

#include <algorithm>

namespace sinew::test_green {

namespace {

GreenOptions doubles(GreenOutside outside = GreenOutside::nearest, int exit_face = -1)
{
    return {cages::doubles, outside, exit_face};
}

struct Bound : Green
{
    Bound(const SurfaceMesh& cage, const Points& points) : Green(Cage(cage), doubles())
    {
        bind(view(points));
    }
};

Points warped(const Green& green, const Points& pose) { return warped_by(green, view(pose)); }

Points warped(const SurfaceMesh& cage, const Points& points, const Points& pose, const GreenOptions& options)
{
    Green green(Cage(cage), options);
    green.bind(view(points));
    return warped(green, pose);
}

Points posed(const SurfaceMesh& cage, const Pose& pose) { return shapes::transformed(cage.points(), pose); }

const Vector3 x0(0.1, 0.2, 0.3);

SpaceTraits traits()
{
    const SurfaceMesh cage = shapes::u_prism();
    return {.name = "Green",
            .variants = {cages::variant<Green>("nearest", cage, doubles())},
            .control = cage.points(),
            .points = shapes::points_around(cage, 600, 1.0),
            .similarity = 1e-11,
            .follow = 3.0, // normals turn with the faces at the vertex
            .other = [cage] { return std::make_shared<Green>(Cage(cage), doubles(GreenOutside::face, 1)); }};
}

/// A cube of 6 n^2 quads on a bumpy sphere, none of them flat.
SurfaceMesh quad_ball(int n, double bumps)
{
    std::vector<Vector3> points;
    shapes::Polygons faces;
    const auto corner = [&](const Vector3& on_cube) {
        const Vector3 p = on_cube.normalized();
        for (std::size_t i = 0; i < points.size(); ++i)
            if ((points[i] - p).norm() < 1e-9)
                return static_cast<int>(i);
        points.push_back(p);
        return static_cast<int>(points.size()) - 1;
    };
    for (int axis = 0; axis < 3; ++axis)
        for (const double side : {-1.0, 1.0})
            for (int i = 0; i < n; ++i)
                for (int j = 0; j < n; ++j) {
                    const auto at = [&](int a, int b) {
                        Vector3 p;
                        p[axis] = side;
                        p[(axis + 1) % 3] = 2.0 * a / n - 1.0;
                        p[(axis + 2) % 3] = 2.0 * b / n - 1.0;
                        return corner(p);
                    };
                    std::vector<int> face{at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
                    if (side < 0.0)
                        std::reverse(face.begin(), face.end());
                    faces.push_back(face);
                }
    shapes::Random random(12);
    for (Vector3& p : points)
        p += bumps * random.vector();
    return shapes::mesh(points, faces);
}

GreenOptions patches(GreenOutside outside = GreenOutside::nearest, int exit_face = -1)
{
    return {cages::doubles, outside, exit_face, GreenFaces::quads};
}

SpaceTraits with_patches()
{
    const SurfaceMesh cage = quad_ball(2, 0.2);
    return {.name = "quads",
            .variants = {cages::variant<Green>("quads", cage, patches())},
            .control = cage.points(),
            .points = shapes::points_around(cage, 600, 1.0),
            .similarity = 1e-12,
            .follow = 3.0,
            .other = [cage] { return std::make_shared<Green>(Cage(cage), doubles()); }};
}

SpaceTraits with_both()
{
    SpaceTraits chosen = with_patches();
    const SurfaceMesh cage = shapes::u_prism(); // its ends are triangles, its sides quads
    chosen.name = "both";
    chosen.variants = {cages::variant<Green>("both", cage, patches(GreenOutside::refuse))};
    chosen.control = cage.points();
    chosen.points = cages::inside_u_prism(600, 1e-3);
    chosen.outside = Vector3(1.5, 2, 0.5);
    chosen.refuses_outside = true;
    chosen.other = [cage] { return std::make_shared<Green>(Cage(cage), doubles()); };
    return chosen;
}

SpaceTraits refusing()
{
    SpaceTraits chosen = traits();
    const SurfaceMesh cage = shapes::u_prism();
    chosen.name = "refusing";
    chosen.variants = {cages::variant<Green>("refusing", cage, doubles(GreenOutside::refuse))};
    chosen.points = cages::inside_u_prism(600, 1e-3);
    chosen.outside = Vector3(1.5, 2, 0.5);
    chosen.refuses_outside = true;
    return chosen;
}

} // namespace

INSTANTIATE_TEST_SUITE_P(Green, SpaceContract,
                         testing::Values(traits(), refusing(), with_patches(), with_both()));

TEST(Green, has_the_known_answers_to_a_shear_and_a_stretch)
{
    Points x(1, 3);
    x << x0.transpose();
    const Bound green(shapes::octahedron(), x);
    Matrix3 shear = Matrix3::Identity(), stretch = Matrix3::Identity();
    shear(0, 1) = 0.5;
    stretch(2, 2) = 2.0;
    const Eigen::RowVector3d sheared =
        warped(green, posed(shapes::octahedron(), shapes::affine(shear))).row(0);
    const Eigen::RowVector3d stretched =
        warped(green, posed(shapes::octahedron(), shapes::affine(stretch))).row(0);
    EXPECT_LT((sheared - Eigen::RowVector3d(.171221, .182365, .303175)).norm(), 1e-6); // the digits given
    EXPECT_LT((stretched - Eigen::RowVector3d(.124066, .244992, .482952)).norm(), 1e-6);
}

/// Faces as triangles, and quads as bilinear patches.
class GreenOfFaces : public testing::TestWithParam<GreenFaces>
{
protected:
    static GreenOptions options(GreenOutside outside = GreenOutside::nearest, int exit_face = -1)
    {
        return {cages::doubles, outside, exit_face, GetParam()};
    }
};

INSTANTIATE_TEST_SUITE_P(, GreenOfFaces, testing::Values(GreenFaces::triangles, GreenFaces::quads),
                         [](const auto& info) {
                             return info.param == GreenFaces::quads ? "quads" : "triangles";
                         });

TEST_P(GreenOfFaces, reproduce_similarities_inside_outside_and_on_the_cage)
{
    const SurfaceMesh two = shapes::joined(shapes::cube(), shapes::octahedron(), {4, 1, 0});
    for (const SurfaceMesh& cage : {shapes::cube(), shapes::octahedron(), quad_ball(2, 0.2),
                                    quad_ball(4, 0.05), shapes::u_prism(), shapes::bumpy_sphere(2), two}) {
        const Points near = shapes::points_near(cage, {0.0, 1e-13, 1e-11, 1e-9, 1e-4});
        Points all(400 + near.rows(), 3);
        all << shapes::points_around(cage, 200, 1.0), shapes::points_around(cage, 200, 2.0), near;
        const Pose pose = shapes::affine(2.5 * shapes::rotation({1, 2, -1}, 130), {3, -1, 2});
        EXPECT_LT(
            shapes::distance(warped(cage, all, posed(cage, pose), options()), shapes::transformed(all, pose)),
            1e-10);
    }
}

TEST_P(GreenOfFaces, are_harmonic_and_sum_to_one)
{
    // phi and psi are harmonic functions: the mean of six neighbours is the middle, to h^4.
    constexpr double h = 0.01;
    Points star = x0.transpose().replicate(7, 1);
    for (int k = 0; k < 6; ++k)
        star(1 + k, k / 2) += k % 2 ? h : -h;
    for (const SurfaceMesh& cage : {shapes::bumpy_sphere(1), quad_ball(2, 0.2)}) {
        Green green(Cage(cage), options());
        green.bind(view(star));
        const RowMatrix W = green.weights().dense();
        EXPECT_LT((W.leftCols(cage.vertex_count()).rowwise().sum().array() - 1.0).abs().maxCoeff(), 1e-14);
        const RowMatrix laplacian = W.middleRows(1, 6).colwise().sum() - 6.0 * W.row(0);
        EXPECT_LT(laplacian.cwiseAbs().maxCoeff(), 1e-7); // h^4 / 12 times a fourth derivative of some 10
    }
}

TEST_P(GreenOfFaces, continue_through_one_face_if_asked)
{
    const SurfaceMesh cage = shapes::cube();
    Points x(2, 3);
    x << 0.5, 0.5, 1.5, 0.5, 0.5, -0.5; // above the top, below the bottom
    Points pose = cage.points();
    pose.row(6) += Eigen::RowVector3d(0.3, -0.2, 0.4);
    EXPECT_EQ(Green(Cage(cage), options()).bind(view(x)).outside, (std::vector<int>{0, 1}));
    const Points nearest = warped(cage, x, pose, options()),
                 top = warped(cage, x, pose, options(GreenOutside::face, 1));
    EXPECT_GT((nearest.row(1) - top.row(1)).norm(), 0.1);
    EXPECT_EQ(warped(cage, x, pose, options(GreenOutside::face, 1)), top);
    if (GetParam() == GreenFaces::quads) {
        EXPECT_LT((nearest.row(0) - top.row(0)).norm(), 1e-15);
    }
    EXPECT_THROW(Green(Cage(cage), options(GreenOutside::face, 6)), InvalidOption);
    EXPECT_THROW(Green(Cage(cage), options(GreenOutside::face, -1)), InvalidOption);
}

TEST_P(GreenOfFaces, stay_finite_far_away)
{
    Points x(3, 3);
    x << 1e2, 3, 5, 1e100, -1e100, 3, 0, 0, -1e300;
    for (const SurfaceMesh& cage : {shapes::bumpy_sphere(1), quad_ball(2, 0.2)}) {
        Green green(Cage(cage), options());
        green.bind(view(x));
        EXPECT_TRUE(green.weights().dense().allFinite());
    }
}

TEST_P(GreenOfFaces, take_poses_that_flatten_faces_and_dented_cages)
{
    const Points x = shapes::points_around(shapes::cube(), 50, 1.2);
    Points dented = shapes::cube().points();
    dented.row(6) = 0.9 * dented.row(4) + 0.05 * (dented.row(5) + dented.row(7));
    for (const SurfaceMesh& cage : {shapes::cube(), shapes::moved(shapes::cube(), dented)}) {
        Points pose = cage.points();
        pose.row(6) = pose.row(5);
        EXPECT_TRUE(warped(cage, x, pose, options()).allFinite());
        pose.setZero();
        EXPECT_LT(warped(cage, x, pose, options()).cwiseAbs().maxCoeff(), 1e-14)
            << "a cage in one point takes all there";
        pose = 1e100 * cage.points();
        EXPECT_TRUE(warped(cage, x, pose, options()).allFinite());
        pose = 1e-100 * cage.points();
        EXPECT_LT(warped(cage, x, pose, options()).cwiseAbs().maxCoeff(), 1e-14);
        const Pose turn = shapes::affine(0.5 * shapes::rotation({1, 1, 0}, 40));
        EXPECT_LT(
            shapes::distance(warped(cage, x, posed(cage, turn), options()), shapes::transformed(x, turn)),
            1e-12);
    }
}

TEST(Green, passes_a_face_smoothly)
{
    // Through the face that the outside is continued by, the map is analytic: no jump, no kink.
    const SurfaceMesh cage = shapes::bumpy_sphere(1);
    const Triangle& t = cage.triangles()[7];
    const Vector3 foot = (cage.point(t[0]) + cage.point(t[1]) + cage.point(t[2])) / 3.0;
    const Vector3 normal =
        (cage.point(t[1]) - cage.point(t[0])).cross(cage.point(t[2]) - cage.point(t[0])).normalized();
    std::vector<Vector3> list;
    constexpr double step = 1e-3;
    for (int k = -4; k <= 4; ++k)
        list.push_back(foot + k * step * normal);
    for (const double h : {1e-15, -1e-15, 1e-13, -1e-13, 1e-10, -1e-10})
        list.push_back(foot + h * normal);
    const Bound green(cage, shapes::points_of(list));
    Points pose = cage.points();
    shapes::Random random(9);
    for (Eigen::Index v = 0; v < pose.rows(); ++v)
        pose.row(v) += 0.2 * random.vector().transpose();
    const Points x = warped(green, pose);
    for (Eigen::Index i = 9; i < x.rows(); ++i)
        EXPECT_LT((x.row(i) - x.row(4)).norm(), 1e-9); // ten times the distance
    for (int k = 0; k + 4 < 9; ++k) {
        const auto fourth = x.row(k) - 4 * x.row(k + 1) + 6 * x.row(k + 2) - 4 * x.row(k + 3) + x.row(k + 4);
        EXPECT_LT(fourth.norm(), 1e-9); // step^4 times a fourth derivative of 1,000; a kink gives some 1e-4
    }
}

TEST(Green, takes_points_on_faces_for_inside)
{
    for (const SurfaceMesh& mesh : {shapes::bumpy_sphere(1), shapes::u_prism()}) {
        shapes::Random random(8);
        std::vector<Vector3> on;
        for (const Triangle& t : mesh.triangles())
            for (int k = 0; k < 20; ++k) {
                const double s = random.unit(), r = (1.0 - s) * random.unit();
                on.push_back(s * mesh.point(t[0]) + r * mesh.point(t[1]) + (1.0 - s - r) * mesh.point(t[2]));
            }
        const Points points = shapes::points_of(on);
        Green green{Cage(mesh), doubles(GreenOutside::refuse)};
        EXPECT_TRUE(green.bind(view(points)).outside.empty());
        Points warped = warped_by(green, view(mesh.points()));
        EXPECT_LT((warped - points).cwiseAbs().maxCoeff(), 1e-11); // moved in by 1e-12 of the cage's size
    }
}

TEST(Green, leaves_out_faces_without_area)
{
    const SurfaceMesh cage = cages::cube_with_a_flat_triangle();
    const Points x = shapes::points_around(cage, 100, 0.8);
    const Bound green(cage, x);
    const Pose pose = shapes::affine(0.5 * shapes::rotation({1, 1, 0}, 40));
    EXPECT_LT(shapes::distance(warped(green, posed(cage, pose)), shapes::transformed(x, pose)), 1e-9);
}

TEST(Green, winds_twice_where_parts_overlap)
{
    const SurfaceMesh cage = shapes::joined(shapes::cube(), shapes::cube(), {0.5, 0.4, 0.3});
    Points x(2, 3);
    x << 0.7, 0.7, 0.7, 0.2, 0.2, 0.2;
    Green green(Cage(cage), doubles());
    EXPECT_TRUE(green.bind(view(x)).outside.empty());
    const Pose pose = shapes::affine(1.5 * shapes::rotation({0, 1, 1}, 70), {1, 2, 3});
    EXPECT_LT(shapes::distance(warped(green, posed(cage, pose)), shapes::transformed(x, pose)), 1e-12);
}

TEST(GreenQuads, pass_a_patch_without_a_kink)
{
    const SurfaceMesh cage = quad_ball(2, 0.2);
    const auto face = cage.face(9);
    const Vector3 a = cage.point(face[0]), b = cage.point(face[1]), c = cage.point(face[2]),
                  d = cage.point(face[3]);
    const Vector3 foot = 0.25 * (a + b + c + d), normal = (c - a).cross(d - b).normalized();
    std::vector<Vector3> list;
    constexpr double step = 1e-4;
    for (int k = -2; k <= 2; ++k)
        list.push_back(foot + k * step * normal);
    for (const double h : {1e-15, -1e-15, 1e-12, -1e-12, 1e-10, -1e-10})
        list.push_back(foot + h * normal);
    Points pose = cage.points();
    shapes::Random random(9);
    for (Eigen::Index v = 0; v < pose.rows(); ++v)
        pose.row(v) += 0.2 * random.vector().transpose();
    const Points x = warped(cage, shapes::points_of(list), pose, patches());
    for (Eigen::Index i = 5; i < x.rows(); ++i)
        EXPECT_LT((x.row(i) - x.row(2)).norm(), 2e-8); // ten times the distance that it is moved in
    const auto inner = x.row(1) - x.row(0), outer = x.row(4) - x.row(3);
    EXPECT_LT((inner - outer).norm() / step, 1e-2); // the second derivative is some ten per unit
}

TEST(GreenQuads, of_triangles_are_the_triangles)
{
    const SurfaceMesh cage = shapes::bumpy_sphere(1);
    const Points x = shapes::points_around(cage, 100, 1.3);
    Points pose = cage.points();
    pose.row(3) *= 1.5;
    EXPECT_EQ(warped(cage, x, pose, patches()), warped(cage, x, pose, doubles()));
}

} // namespace sinew::test_green

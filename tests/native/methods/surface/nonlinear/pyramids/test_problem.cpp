// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/pyramids/problem.h"

#include "native/methods/surface/nonlinear/pyramids/morph.h"
#include "tests/native/differences.h"
#include "tests/native/shapes.h"
#include "tests/native/wide_kernels.h"

#include <gtest/gtest.h>

namespace sinew::test_problem {

namespace {

struct Scene
{
    SurfaceMesh mesh;
    Rings rings;
    Rings::Weights weights;
    PyramidStiffness stiffness;
    std::vector<bool> moving;
    PyramidCells cells;
    PyramidShape shape;
    Points noisy, pulls;

    explicit Scene(const SurfaceMesh& of)
        : mesh(of), rings(mesh), weights(rings.mean_value_weights(view(mesh.points()))),
          stiffness(mesh, rings, weights, 0.05), moving(some(rings)),
          cells(rings, weights.shares, stiffness, moving, {{2, 0, 0.5}}), noisy(mesh.points()),
          pulls(Points::Constant(1, 3, 0.3))
    {
        cells.keep(view(mesh.points()), shape);
        shapes::Random random(4);
        for (int i = 0; i < noisy.rows(); ++i)
            if (moving[i])
                noisy.row(i) += 0.2 * random.vector().transpose();
    }

    static std::vector<bool> some(const Rings& rings)
    {
        std::vector<bool> moving(rings.size());
        for (int i = 0; i < rings.size(); ++i)
            moving[i] = rings.valence(i) > 0 && (i == 2 || i % 5 != 0);
        return moving;
    }
    Points at(const Points& points) const
    {
        Points x(cells.moving_count(), 3);
        for (int p = 0; p < x.rows(); ++p)
            x.row(p) = points.row(cells.order()[p]);
        return x;
    }
};

} // namespace

// Its minimum is in tests/bindings/oracles/test_oracles_pyramid.py.
TEST(PyramidProblem, gradient_is_that_of_the_energy)
{
    const Scene own(shapes::hill(8, 7));
    for (const bool scaled : {false, true}) {
        PyramidBuffers buffers;
        PyramidProblem problem(own.cells, own.shape, scaled, own.noisy, own.pulls, buffers);
        Points x = own.at(own.noisy), g, scratch;
        problem.evaluate(x, g);
        const auto F = [&](const Points& there) { return problem.evaluate(there, scratch); };
        expect_gradient(F, x, g, 1e-5, 1e-7 * g.norm(), 3);
    }
}

TEST(PyramidProblem, kernels_agree_to_the_last_bit)
{
    const Scene own(shapes::sphere(3));
    const PyramidKernels* const wide = kernels_with<PyramidKernels>(Instructions::avx2);
    if (!wide)
        GTEST_SKIP() << "no wide instructions here";
    PyramidBuffers buffers;
    PyramidProblem problem(own.cells, own.shape, false, own.noisy, own.pulls, buffers);
    PyramidView seen = own.cells.view();
    seen.edges = own.shape.edges.data();
    seen.tips = own.shape.tips.data();
    seen.points = buffers.points.data();
    const int cells = std::min(own.cells.cell_count(), 200);
    std::vector<double> results[2];
    for (const PyramidKernels* kernels : {&PyramidKernels::baseline, wide}) {
        std::vector<double> S(12 * 201), f(buffers.forces.size()), sums(buffers.sums.size()), g(3 * 201);
        kernels->covariances(seen, 0, cells, S.data());
        f.back() = kernels->forces(seen, 0, cells, buffers.rotations.data(), f.data(), sums.data());
        kernels->gather(seen, 0, std::min(cells, own.cells.moving_count()), f.data(), sums.data(), g.data());
        std::vector<double>& all = results[kernels == wide];
        for (int c = 0; c < cells; ++c)
            for (int k = 0; k < 12; ++k)
                if (k % 4 < 3) // the fourth lanes hold whatever is behind
                    all.push_back(S[12 * c + k]);
        all.insert(all.end(), f.begin(), f.end());
        all.insert(all.end(), sums.begin(), sums.end());
        all.insert(all.end(), g.begin(), g.end());
    }
    EXPECT_EQ(results[0], results[1]);
}

TEST(PyramidMorph, mixes_weights_heights_and_edges)
{
    const SurfaceMesh mesh = shapes::hill(8, 7);
    const Scene own(mesh);
    const Points other =
        shapes::Random(9).shaken(shapes::transformed(mesh.points(), shapes::turn({1, 2, 3}, 50)), 0.05);
    const PyramidMorph morph(own.rings, own.weights.shares, other);
    const Rings::Weights its = own.rings.mean_value_weights(view(other));
    PyramidShape shape;
    std::vector<Eigen::Quaterniond> turns;
    for (const double t : {0.0, 0.3, 1.0}) {
        morph.mix(own.cells, own.rings, view(mesh.points()), view(mesh.points()), t, shape, turns);
        for (int c = 0; c < own.cells.cell_count(); ++c) {
            const int i = own.cells.order()[c], first = own.rings.offsets()[i];
            const Matrix3 turn = own.rings.turn(view(mesh.points()), view(other), i).toRotationMatrix();
            // By weights that are mixed, the tip of the mixed edges is the mixture of the tips.
            Vector3 off = Vector3::Map(shape.tips.data() + 3 * c);
            for (int a = first; a < own.rings.offsets()[i + 1]; ++a) {
                const int j = own.rings.neighbours()[a];
                const Vector3 p = (1 - t) * (mesh.point(j) - mesh.point(i)),
                              q = t * turn.transpose() * (other.row(j) - other.row(i)).transpose(),
                              edge =
                                  Vector3::Map(shape.edges.data() + 3 * (own.cells.offsets()[c] + a - first));
                EXPECT_LT((edge - p - q).norm(), 1e-14);
                const double before = own.weights.shares[a], after = its.shares[a];
                off += t * (before - after) * edge + before * p + after * q;
            }
            EXPECT_LT(off.norm(), 1e-14);
        }
    }
}

} // namespace sinew::test_problem

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/caging/wrap.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Surface_mesh.h>
#include <CGAL/alpha_wrap_3.h>

#include <cmath>

namespace sinew {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Mesh = CGAL::Surface_mesh<Kernel::Point_3>;

/// Reports progress while the wrap shrinks. How many facets it will visit is not known before.
struct Ticker : CGAL::Alpha_wraps_3::internal::Wrapping_default_visitor
{
    const Progress& progress;
    int visited = 0;

    explicit Ticker(const Progress& progress) : progress(progress) {}

    template <class Wrapper, class Gate>
    void before_facet_treatment(const Wrapper&, const Gate&)
    {
        if (visited++ % 512 == 0)
            progress.tick(1.0 - std::exp(-visited / 30'000.0), "wrapping");
    }
};

} // namespace

TriangleSoup wrapped(const TriangleSoup& target, double alpha, double offset, const Progress& progress)
{
    std::vector<Kernel::Point_3> points;
    for (const Vector3& p : target.points)
        points.emplace_back(p.x(), p.y(), p.z());
    Mesh mesh;
    Ticker ticker(progress);
    CGAL::alpha_wrap_3(points, target.triangles, alpha, offset, mesh, CGAL::parameters::default_values(),
                       CGAL::parameters::visitor(ticker));
    TriangleSoup wrap;
    for (const auto v : mesh.vertices())
        wrap.points.emplace_back(mesh.point(v).x(), mesh.point(v).y(), mesh.point(v).z());
    for (const auto f : mesh.faces()) {
        Triangle triangle;
        int k = 0;
        for (const auto v : mesh.vertices_around_face(mesh.halfedge(f)))
            triangle[k++] = static_cast<int>(v);
        wrap.triangles.push_back(triangle);
    }
    return wrap;
}

} // namespace sinew

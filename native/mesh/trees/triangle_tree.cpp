// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/trees/triangle_tree.h"

#include "native/mesh/trees/winding_tree.h"

#include <CGAL/AABB_traits.h>
#include <CGAL/AABB_tree.h>
#include <CGAL/AABB_triangle_primitive.h>
#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>
#include <numeric>

namespace sinew {

namespace {

using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
using Point = Kernel::Point_3;

Point exact(const Vector3& p) { return {p.x(), p.y(), p.z()}; }

Kernel::Triangle_3 exact(const Corners& t) { return {exact(t[0]), exact(t[1]), exact(t[2])}; }

/// Whether one of two triangles with the common edge (a, b) is folded onto the other.
bool folded(const Vector3& a, const Vector3& b, const Vector3& apex, const Vector3& other)
{
    return CGAL::coplanar(exact(a), exact(b), exact(apex), exact(other)) &&
           CGAL::coplanar_orientation(exact(a), exact(b), exact(apex), exact(other)) == CGAL::POSITIVE;
}

} // namespace

bool is_flat(const Corners& triangle) { return exact(triangle).is_degenerate(); }

bool triangles_meet(const Corners& a, const Triangle& a_indices, const Corners& b, const Triangle& b_indices)
{
    // `alone_a` and `alone_b` begin as 0 + 1 + 2; less two shared corners, the third is left.
    int shared = 0, alone_a = 3, alone_b = 3, at_a = 0, at_b = 0;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (a_indices[i] == b_indices[j]) {
                ++shared;
                alone_a -= i;
                alone_b -= j;
                at_a = i;
                at_b = j;
            }
    if (shared == 3)
        return true;
    if (shared == 2)
        return folded(a[(alone_a + 1) % 3], a[(alone_a + 2) % 3], a[alone_a], b[alone_b]);
    const Kernel::Triangle_3 s = exact(a), t = exact(b);
    if (shared == 0)
        return CGAL::do_intersect(s, t);
    const Kernel::Segment_3 across_a(exact(a[(at_a + 1) % 3]), exact(a[(at_a + 2) % 3]));
    const Kernel::Segment_3 across_b(exact(b[(at_b + 1) % 3]), exact(b[(at_b + 2) % 3]));
    return CGAL::do_intersect(across_a, t) || CGAL::do_intersect(across_b, s);
}

std::vector<std::array<int, 2>> meeting_pairs(const std::vector<Vector3>& points,
                                              const std::vector<Triangle>& triangles)
{
    struct Box
    {
        Eigen::AlignedBox3d box;
        int triangle;
    };
    std::vector<Box> boxes;
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t) {
        const Corners corners = corners_of(points, triangles[t]);
        if (is_flat(corners))
            continue;
        boxes.push_back({{}, t});
        for (const Vector3& corner : corners)
            boxes.back().box.extend(corner);
    }
    std::ranges::sort(boxes, {}, [](const Box& b) { return std::pair(b.box.min().x(), b.triangle); });
    std::vector<std::array<int, 2>> pairs;
    for (std::size_t i = 0; i < boxes.size(); ++i)
        for (std::size_t j = i + 1; j < boxes.size() && boxes[j].box.min().x() <= boxes[i].box.max().x();
             ++j) {
            const auto [s, t] = std::minmax(boxes[i].triangle, boxes[j].triangle);
            if (boxes[i].box.intersects(boxes[j].box) &&
                triangles_meet(corners_of(points, triangles[s]), triangles[s],
                               corners_of(points, triangles[t]), triangles[t]))
                pairs.push_back({s, t});
        }
    std::ranges::sort(pairs);
    return pairs;
}

double winding_number(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles,
                      const Vector3& at)
{
    double sum = 0.0;
    for (const Triangle& t : triangles)
        sum += solid_angle(corners_of(points, t), at);
    return sum / (4 * std::numbers::pi);
}

struct TriangleTree::Impl
{
    using Iterator = std::vector<Kernel::Triangle_3>::const_iterator;
    using Tree = CGAL::AABB_tree<CGAL::AABB_traits<Kernel, CGAL::AABB_triangle_primitive<Kernel, Iterator>>>;

    std::vector<Kernel::Triangle_3> triangles;
    std::vector<int> numbers; ///< of the triangles, among all
    Tree tree;
};

TriangleTree::TriangleTree(const std::vector<Vector3>& points, const std::vector<Triangle>& triangles)
    : impl_(hidden<Impl>())
{
    for (int i = 0; i < static_cast<int>(triangles.size()); ++i)
        if (const Kernel::Triangle_3 t = exact(corners_of(points, triangles[i])); !t.is_degenerate()) {
            impl_->triangles.push_back(t);
            impl_->numbers.push_back(i);
        }
    impl_->tree.rebuild(impl_->triangles.cbegin(), impl_->triangles.cend());
    impl_->tree.build(); // now: otherwise the first threads that ask would build it
    impl_->tree.accelerate_distance_queries();
}

bool TriangleTree::meets(const Corners& triangle) const
{
    const Kernel::Triangle_3 t = exact(triangle);
    return !t.is_degenerate() && impl_->tree.do_intersect(t);
}

bool TriangleTree::meets(const Vector3& from, const Vector3& to) const
{
    const Kernel::Segment_3 segment(exact(from), exact(to));
    return !segment.is_degenerate() && impl_->tree.do_intersect(segment);
}

TriangleTree::Place TriangleTree::closest_place(const Vector3& point) const
{
    const auto [found, triangle] = impl_->tree.closest_point_and_primitive(exact(point));
    return {{found.x(), found.y(), found.z()}, impl_->numbers[triangle - impl_->triangles.cbegin()]};
}

int TriangleTree::crossings(const Vector3& from, const Vector3& direction) const
{
    std::vector<Impl::Iterator> crossed;
    impl_->tree.all_intersected_primitives(
        Kernel::Ray_3(exact(from), Kernel::Vector_3(direction.x(), direction.y(), direction.z())),
        std::back_inserter(crossed));
    int count = 0;
    for (const Impl::Iterator triangle : crossed) {
        const auto corner = [&](int k) {
            const Point& p = triangle->vertex(k);
            return Vector3(p.x(), p.y(), p.z());
        };
        const double along = (corner(1) - corner(0)).cross(corner(2) - corner(0)).dot(direction);
        count += (along > 0) - (along < 0);
    }
    return count;
}

bool TriangleTree::empty() const { return impl_->triangles.empty(); }

} // namespace sinew

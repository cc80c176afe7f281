// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/riders/touching.h"

#include "native/mesh/box_tree.h"
#include "native/mesh/closest_triangle.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

constexpr double gap = 0.02; ///< of the extent of the smaller part

/// Where two of some parts touch. Answers about the triangles of a part are prepared when it is first asked.
class Contacts
{
public:
    explicit Contacts(const std::vector<Part>& parts) : parts_(parts), surfaces_(parts.size()) {}

    /// Vertices of the mesh that are close together, one of each part; {-1, -1} if they do not touch.
    std::array<int, 2> between(int a, int b)
    {
        nearest_ = gap * std::min(parts_[a].extent(), parts_[b].extent());
        found_ = {-1, -1};
        look(a, b);
        look(b, a);
        return found_;
    }

private:
    struct Surface
    {
        explicit Surface(const Part& part)
            : points(part.points.front().data(), static_cast<Eigen::Index>(part.points.size()), 3),
              closest(points, part.triangles)
        {
        }
        PointsView points;
        ClosestTriangle closest;
    };

    /// Looks for a vertex of part a that is nearer to part b than all before.
    void look(int a, int b)
    {
        const Part &part = parts_[a], &other = parts_[b];
        if (!surfaces_[b])
            surfaces_[b] = std::make_unique<Surface>(other);
        for (std::size_t v = 0; v < part.points.size(); ++v) {
            const Vector3& point = part.points[v];
            if (!(other.box.squaredExteriorDistance(point) < nearest_ * nearest_))
                continue;
            const int found = surfaces_[b]->closest.to(point, nearest_);
            if (found < 0)
                continue;
            const Triangle& t = other.triangles[found];
            nearest_ = std::sqrt(
                squared_distance(point, other.points[t[0]], other.points[t[1]], other.points[t[2]]));
            const int corner = *std::ranges::min_element(
                t, {}, [&](int k) { return (other.points[k] - point).squaredNorm(); });
            found_ = {part.vertices[v], other.vertices[corner]};
        }
    }

    const std::vector<Part>& parts_;
    std::vector<std::unique_ptr<Surface>> surfaces_;
    double nearest_ = 0.0;
    std::array<int, 2> found_{};
};

} // namespace

std::vector<Part> JoinedParts::of(const SurfaceMesh& mesh) const
{
    std::vector<Part> all = parts_of(mesh, parts);
    for (const auto& [from, to] : links) {
        Part& part = all[parts.labels[from]];
        const auto local = [&](int v) {
            return static_cast<int>(std::ranges::lower_bound(part.vertices, v) - part.vertices.begin());
        };
        part.links.push_back({local(from), local(to)});
    }
    return all;
}

JoinedParts joined_where_they_touch(const Components& parts, const std::vector<Part>& all,
                                    const std::vector<Seat>& seats)
{
    JoinedParts joined;
    std::vector<int> leader(all.size());
    std::iota(leader.begin(), leader.end(), 0);
    const auto first_of = [&](int part) {
        while (leader[part] != part)
            part = leader[part] = leader[leader[part]];
        return part;
    };
    std::map<int, std::vector<int>> riders_of;
    for (const Seat& seat : seats)
        if (all[seat.part].area > 0.0)
            riders_of[seat.host].push_back(seat.part);
    Contacts contacts(all);
    for (auto& [host, riders] : riders_of) {
        std::ranges::sort(riders);
        std::vector<BoxTree::Box> boxes;
        for (const int rider : riders)
            boxes.push_back(all[rider].box);
        const BoxTree tree(boxes);
        for (std::size_t i = 1; i < riders.size(); ++i) {
            const Part& part = all[riders[i]];
            const double near = gap * part.extent(); // at least that of the smaller one
            tree.visit_by_bound(
                static_cast<int>(i), near * near,
                [&](const BoxTree::Box& box, bool) { return part.box.squaredExteriorDistance(box); },
                [&](int j) {
                    const std::array<int, 2> contact = contacts.between(riders[i], riders[j]);
                    if (contact[0] >= 0) {
                        const auto [low, high] = std::minmax({first_of(riders[i]), first_of(riders[j])});
                        leader[high] = low;
                        joined.links.push_back(contact);
                    }
                    return near * near;
                });
        }
    }
    std::vector<int> numbers(all.size(), -1);
    for (int part = 0; part < parts.count; ++part) // rising, so numbers follow the lowest vertices, too
        numbers[part] = first_of(part) == part ? joined.parts.count++ : numbers[first_of(part)];
    for (const int part : parts.labels)
        joined.parts.labels.push_back(numbers[part]);
    return joined;
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/touching.h"

#include "native/core/parallel.h"
#include "native/mesh/trees/box_tree.h"
#include "native/mesh/trees/closest_triangle.h"

#include <algorithm>
#include <array>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <numeric>
#include <utility>

namespace sinew {

namespace {

constexpr double gap = 0.02;       ///< of the extent of the smaller part
constexpr double peer_share = 0.5; ///< of the extent of the host

/// Where two of some parts touch. Answers about a part are prepared when it is first asked. Any number of
/// threads may ask at once.
class Contacts
{
public:
    explicit Contacts(const std::vector<Part>& parts)
        : parts_(parts), surfaces_(parts.size()), made_(parts.size())
    {
    }

    /// Triangles between vertices of the mesh that bridge the gaps where two parts touch.
    std::vector<Triangle> between(int a, int b)
    {
        const double near = gap * std::min(parts_[a].extent(), parts_[b].extent());
        std::vector<Triangle> bridges;
        look(a, b, near, bridges);
        look(b, a, near, bridges);
        return bridges;
    }

private:
    struct Surface
    {
        explicit Surface(const Part& part)
            : points(part.points.front().data(), static_cast<Eigen::Index>(part.points.size()), 3),
              closest(points, part.triangles), tree(part.points, part.triangles), boxes(boxes_of(part))
        {
        }
        static std::vector<BoxTree::Box> boxes_of(const Part& part)
        {
            std::vector<BoxTree::Box> boxes(part.triangles.size());
            for (std::size_t t = 0; t < boxes.size(); ++t)
                for (const int v : part.triangles[t])
                    boxes[t].extend(part.points[v]);
            return boxes;
        }
        PointsView points;
        ClosestTriangle closest;
        TriangleTree tree;
        BoxTree boxes; ///< one per triangle
    };

    const Surface& surface(int part)
    {
        std::call_once(made_[part], [&] { surfaces_[part] = std::make_unique<Surface>(parts_[part]); });
        return *surfaces_[part];
    }

    /// Adds the bridges from vertices of part a that are near part b, or whose edges cross it.
    void look(int a, int b, double near, std::vector<Triangle>& bridges)
    {
        const Part &part = parts_[a], &other = parts_[b];
        std::vector<int> triangles, vertices; // of part a in the box of b
        surface(a).boxes.visit_by_bound(
            std::numeric_limits<int>::max(), near * near,
            [&](const BoxTree::Box& box, bool) { return other.box.squaredExteriorDistance(box); },
            [&](int t) {
                triangles.push_back(t);
                vertices.insert(vertices.end(), part.triangles[t].begin(), part.triangles[t].end());
                return near * near;
            });
        std::ranges::sort(vertices);
        vertices.erase(std::ranges::unique(vertices).begin(), vertices.end());
        std::vector<std::array<int, 2>> from; // a vertex, and a triangle of the other part
        for (const int v : vertices)
            if (const int t = surface(b).closest.to(part.points[v], near); t >= 0)
                from.push_back({v, t});
        for (const int t : triangles)
            for (int k = 0; k < 3; ++k) {
                const int v = part.triangles[t][k], w = part.triangles[t][(k + 1) % 3];
                if (v < w && surface(b).tree.meets(part.points[v], part.points[w]))
                    for (const int end : {v, w})
                        from.push_back({end, surface(b).tree.closest_place(part.points[end]).triangle});
            }
        std::ranges::sort(from);
        from.erase(std::ranges::unique(from).begin(), from.end());
        for (const auto& [v, t] : from) {
            const int vertex = part.vertices[v];
            const auto& [i, j, k] = other.triangles[t];
            bridges.push_back({vertex, other.vertices[i], other.vertices[j]});
            bridges.push_back({vertex, other.vertices[j], other.vertices[k]});
        }
    }

    const std::vector<Part>& parts_;
    std::vector<std::unique_ptr<Surface>> surfaces_;
    std::vector<std::once_flag> made_;
};

/// Lets parts ride on what their hosts ride on, where these are attached parts of about their size that they
/// touch.
void leave_peers(const std::vector<Part>& parts, std::vector<Attachment>& attachments, Contacts& contacts)
{
    std::vector<Attachment*> attachment_of(parts.size(), nullptr);
    for (Attachment& attachment : attachments) {
        attachment_of[attachment.part] = &attachment;
        const Attachment* host = attachment_of[attachment.host];
        const Part &part = parts[attachment.part], &other = parts[attachment.host];
        if (host && part.area > 0.0 && part.extent() > peer_share * other.extent() &&
            !contacts.between(attachment.part, attachment.host).empty()) {
            attachment.host = host->host;
            attachment.beneath.clear(); // to be asked again
        }
    }
}

/// Pairs of parts with an area that ride on the same one and have boxes that are near each other.
std::vector<std::array<int, 2>> near_pairs(const std::vector<Part>& parts,
                                           const std::vector<Attachment>& attachments)
{
    std::map<int, std::vector<int>> attached_to;
    for (const Attachment& attachment : attachments)
        if (parts[attachment.part].area > 0.0)
            attached_to[attachment.host].push_back(attachment.part);
    std::vector<std::array<int, 2>> pairs;
    for (const auto& [host, attached_parts] : attached_to) {
        std::vector<BoxTree::Box> boxes;
        for (const int attached_part : attached_parts)
            boxes.push_back(parts[attached_part].box);
        const BoxTree tree(boxes);
        for (int i = 1; i < static_cast<int>(attached_parts.size());
             ++i) { // by falling area, so the later is smaller
            const Part& part = parts[attached_parts[i]];
            const double near = gap * part.extent();
            tree.visit_by_bound(
                i, near * near,
                [&](const BoxTree::Box& box, bool) { return part.box.squaredExteriorDistance(box); },
                [&](int j) {
                    pairs.push_back({attached_parts[i], attached_parts[j]});
                    return near * near;
                });
        }
    }
    return pairs;
}

/// Labels by which parts that are linked are one.
Components joined_labels(const Components& labels, const std::vector<std::array<int, 2>>& linked)
{
    std::vector<int> leader(labels.count);
    std::iota(leader.begin(), leader.end(), 0);
    const auto first_of = [&](int part) {
        while (leader[part] != part)
            part = leader[part] = leader[leader[part]];
        return part;
    };
    for (const auto& [a, b] : linked) {
        const auto [low, high] = std::minmax({first_of(a), first_of(b)});
        leader[high] = low;
    }
    Components joined;
    std::vector<int> numbers(labels.count);
    for (int part = 0; part < labels.count; ++part) // rising, so numbers follow the lowest vertices, too
        numbers[part] = first_of(part) == part ? joined.count++ : numbers[first_of(part)];
    for (const int part : labels.labels)
        joined.labels.push_back(numbers[part]);
    return joined;
}

} // namespace

std::vector<int> join_where_they_touch(const SurfaceMesh& mesh, HostedParts& hosted, double length,
                                       const Progress& progress)
{
    progress.tick(0.0, "finding free parts that touch");
    Contacts contacts(hosted.parts);
    leave_peers(hosted.parts, hosted.attachments, contacts);
    std::vector<int> hosts(hosted.parts.size(), -1);
    for (const Attachment& attachment : hosted.attachments)
        hosts[attachment.part] = attachment.host;
    const std::vector<std::array<int, 2>> pairs = near_pairs(hosted.parts, hosted.attachments);
    std::vector<std::vector<Triangle>> bridges(pairs.size());
    parallel_for(
        static_cast<int>(pairs.size()),
        [&](int i) { bridges[i] = contacts.between(pairs[i][0], pairs[i][1]); }, 8);
    std::vector<std::array<int, 2>> linked;
    for (std::size_t i = 0; i < pairs.size(); ++i)
        if (!bridges[i].empty())
            linked.push_back(pairs[i]);
    if (linked.empty())
        return hosts;

    HostedParts joined;
    joined.labels = joined_labels(hosted.labels, linked);
    joined.parts = parts_of(mesh, joined.labels);
    for (const std::vector<Triangle>& some : bridges)
        for (Triangle bridge : some) {
            Part& part = joined.parts[joined.labels.labels[bridge[0]]];
            for (int& v : bridge)
                v = static_cast<int>(std::ranges::lower_bound(part.vertices, v) - part.vertices.begin());
            part.bridges.push_back(bridge);
        }
    joined.surfaces.resize(joined.parts.size());
    const auto now = [&](int part) { return joined.labels.labels[hosted.parts[part].vertices.front()]; };
    const auto is_as_before = [&](int part) {
        return joined.parts[now(part)].vertices.size() == hosted.parts[part].vertices.size();
    };
    std::vector<char> has_host(joined.parts.size(), 0);
    // By falling area, so the first piece of a part comes after the host's.
    for (Attachment& attachment : hosted.attachments) {
        if (std::exchange(has_host[now(attachment.part)], 1))
            continue;
        const Part& part = joined.parts[now(attachment.part)];
        std::unique_ptr<HostSurface>& surface = joined.surfaces[now(attachment.host)];
        if (!surface)
            surface = std::make_unique<HostSurface>(joined.parts[now(attachment.host)]);
        if (!is_as_before(attachment.part))
            attachment.samples = samples_of(part, length);
        if (attachment.beneath.empty() || !is_as_before(attachment.part) || !is_as_before(attachment.host)) {
            surface->prepare_tree();
            attachment.beneath = places_beneath(part, attachment.samples, *surface);
        }
        attachment.part = now(attachment.part);
        attachment.host = now(attachment.host);
        joined.attachments.push_back(std::move(attachment));
    }
    hosted = std::move(joined);
    return hosts;
}

} // namespace sinew

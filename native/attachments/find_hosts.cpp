// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/find_hosts.h"

#include "native/attachments/sampling.h"
#include "native/core/parallel.h"
#include "native/mesh/trees/box_tree.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <mutex>
#include <optional>
#include <span>

namespace sinew {

namespace {

constexpr int judging_samples = 96;
constexpr int samples_of_small = 100, samples_of_large = 400;

/// \param values  are put into another order.
double median(std::span<double> values)
{
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::ranges::nth_element(values, middle);
    return values.size() % 2 ? *middle : (*middle + *std::max_element(values.begin(), middle)) / 2;
}

/// All parts that are driven, as one surface.
struct DrivenSurface
{
    std::vector<int> hosts, firsts; ///< parts, and the number of the first triangle of each
    std::unique_ptr<TriangleTree> tree;

    explicit DrivenSurface(const std::vector<bool>& driven, const HostSurfaces& surfaces)
    {
        std::vector<Vector3> points;
        std::vector<Triangle> triangles;
        for (int p = 0; p < static_cast<int>(surfaces.size()); ++p) {
            if (!driven[p] || !surfaces[p])
                continue;
            hosts.push_back(p);
            firsts.push_back(static_cast<int>(triangles.size()));
            const int first = static_cast<int>(points.size());
            for (const Triangle& t : surfaces[p]->triangles())
                triangles.push_back({first + t[0], first + t[1], first + t[2]});
            const std::vector<Vector3>& own = surfaces[p]->part().points;
            points.insert(points.end(), own.begin(), own.end());
        }
        tree = std::make_unique<TriangleTree>(points, triangles);
    }

    /// Which of the hosts has a triangle.
    std::size_t owner(int triangle) const
    {
        return static_cast<std::size_t>(std::ranges::upper_bound(firsts, triangle) - firsts.begin() - 1);
    }
};

class HostSearch
{
public:
    HostSearch(const std::vector<Part>& parts, const std::vector<bool>& driven, double length,
               HostSurfaces& surfaces)
        : parts_(parts), driven_(driven), length_(length), surfaces_(surfaces), made_(parts.size())
    {
        for (int p = 0; p < static_cast<int>(parts.size()); ++p)
            if (!driven[p])
                attachments_.push_back({p, -1, 0, {}, {}});
        std::ranges::stable_sort(attachments_, std::ranges::greater(),
                                 [&](const Attachment& attachment) { return parts[attachment.part].area; });
        std::vector<BoxTree::Box> boxes;
        for (const Attachment& attachment : attachments_)
            boxes.push_back(parts[attachment.part].box);
        boxes_.emplace(boxes);
    }

    std::vector<Attachment> run(const Progress& progress)
    {
        const DrivenSurface ground(driven_, surfaces_);
        if (ground.hosts.empty() || ground.tree->empty())
            return {};
        progress.tick(0.0, "finding what lies beneath free parts");
        std::vector<double> halves(attachments_.size());
        each([&](int i) { halves[i] = put_on(ground, i); });
        progress.tick(0.0, "finding what free parts ride on");
        each([&](int i) {
            move_to_larger(i, halves[i]);
            Attachment& attachment = attachments_[i];
            if (attachment.beneath.empty()) {
                tree_of(attachment.host);
                attachment.beneath =
                    places_beneath(parts_[attachment.part], attachment.samples, *surfaces_[attachment.host]);
            }
        });
        return std::move(attachments_);
    }

private:
    template <class Body>
    void each(Body&& body)
    {
        parallel_for(static_cast<int>(attachments_.size()), body, 8);
    }

    const TriangleTree& tree_of(int part)
    {
        std::call_once(made_[part], [&] {
            if (!surfaces_[part])
                surfaces_[part] = std::make_unique<HostSurface>(parts_[part]);
            surfaces_[part]->prepare_tree();
        });
        return surfaces_[part]->tree();
    }

    /// Attaches a part to the driven one that is nearest. \return half the median distance from the driven
    /// ones.
    double put_on(const DrivenSurface& ground, int i)
    {
        Attachment& attachment = attachments_[i];
        const Part& part = parts_[attachment.part];
        attachment.samples = samples_of(part, length_);
        for (int v : attachment.samples)
            attachment.beneath.push_back(ground.tree->closest_place(part.points[v]));
        std::array<double, judging_samples> gaps;
        const std::span<double> judged = gaps_of(i, gaps, [&](std::size_t s, const Vector3& point) {
            return (point - attachment.beneath[s].point).norm();
        });
        const auto nearest = std::ranges::min_element(judged) - judged.begin();
        const std::size_t owner = ground.owner(attachment.beneath[nearest].triangle);
        attachment.host = ground.hosts[owner];
        for (TriangleTree::Place& place : attachment.beneath) {
            if (ground.owner(place.triangle) != owner) {
                attachment.beneath.clear(); // another driven part was nearer there: to be asked again
                break;
            }
            place.triangle -= ground.firsts[owner];
        }
        return median(judged) / 2;
    }

    /// Attaches a part to the larger one whose median distance is the least, if that is below `half`. Lower
    /// bounds are the median distance from its box, and the distance of the part's box from one around
    /// several.
    void move_to_larger(int i, double half)
    {
        Attachment& attachment = attachments_[i];
        const Part& part = parts_[attachment.part];
        BoxTree::Box around = part.box;
        around.min().array() -= half;
        around.max().array() += half;
        const auto end =
            std::ranges::partition_point(attachments_, [&](const Attachment& other) { // by falling area
                const double area = parts_[other.part].area;
                return area > 1.0001 * part.area && area > 0.0;
            });
        double best = half;
        std::array<double, judging_samples> gaps;
        const auto bound = [&](const BoxTree::Box& box, bool is_single) {
            ++attachment.looks;
            if (!is_single)
                return box.exteriorDistance(part.box);
            if (!box.intersects(around))
                return std::numeric_limits<double>::infinity();
            return median(gaps_of(
                i, gaps, [&](std::size_t, const Vector3& point) { return box.exteriorDistance(point); }));
        };
        boxes_->visit_by_bound(static_cast<int>(end - attachments_.begin()), half, bound, [&](int other) {
            const int larger = attachments_[other].part;
            const double found = median(gaps_of(i, gaps, [&](std::size_t, const Vector3& point) {
                return (tree_of(larger).closest(point) - point).norm();
            }));
            if (found < best) {
                best = found;
                attachment.host = larger;
                attachment.beneath.clear();
            }
            return best;
        });
    }

    /// What gap(sample, point) says of the samples by which a part is judged.
    template <class Gap>
    std::span<double> gaps_of(int i, std::array<double, judging_samples>& gaps, Gap&& gap) const
    {
        const Attachment& attachment = attachments_[i];
        const std::size_t count = std::min<std::size_t>(attachment.samples.size(), judging_samples);
        for (std::size_t s = 0; s < count; ++s)
            gaps[s] = gap(s, parts_[attachment.part].points[attachment.samples[s]]);
        return {gaps.data(), count};
    }

    const std::vector<Part>& parts_;
    const std::vector<bool>& driven_;
    double length_;
    HostSurfaces& surfaces_;
    std::vector<std::once_flag> made_; ///< the trees of the parts
    std::vector<Attachment> attachments_;
    std::optional<BoxTree> boxes_; ///< one per attachment
};

} // namespace

std::vector<int> samples_of(const Part& part, double length)
{
    return farthest_points(part.points, part.extent() > length ? samples_of_large : samples_of_small,
                           part.centre());
}

std::vector<TriangleTree::Place> places_beneath(const Part& part, const std::vector<int>& samples,
                                                const HostSurface& host)
{
    std::vector<TriangleTree::Place> beneath;
    for (int v : samples)
        beneath.push_back(host.tree().closest_place(part.points[v]));
    return beneath;
}

std::vector<Attachment> find_hosts(const std::vector<Part>& parts, const std::vector<bool>& driven,
                                   double length, HostSurfaces& surfaces, const Progress& progress)
{
    surfaces.clear();
    surfaces.resize(parts.size());
    parallel_for(
        static_cast<int>(parts.size()),
        [&](int p) {
            if (driven[p] && parts[p].area > 0.0)
                surfaces[p] = std::make_unique<HostSurface>(parts[p]);
        },
        1);
    return HostSearch(parts, driven, length, surfaces).run(progress);
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/riders/seat.h"

#include "native/core/parallel.h"
#include "native/riders/sampling.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace sinew {

namespace {

constexpr int judging_samples = 96;
constexpr int samples_of_small = 100, samples_of_large = 400;

double median(std::vector<double> values)
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

/// How far a sample is from what lies beneath it.
double gap(const Part& part, const Seat& seat, std::size_t sample)
{
    return (part.points[seat.samples[sample]] - seat.beneath[sample].point).norm();
}

/// A part near a rider that is larger, and a lower bound of its median distance.
struct Candidate
{
    double least;
    int part;
};

class Seating
{
public:
    Seating(const std::vector<Part>& parts, const std::vector<bool>& driven, double length,
            HostSurfaces& surfaces)
        : parts_(parts), driven_(driven), length_(length), surfaces_(surfaces)
    {
        for (int p = 0; p < static_cast<int>(parts.size()); ++p)
            if (!driven[p])
                seats_.push_back({p, -1, {}, {}});
        std::ranges::stable_sort(seats_, std::ranges::greater(),
                                 [&](const Seat& seat) { return parts[seat.part].area; });
        halves_.resize(seats_.size());
        candidates_.resize(seats_.size());
    }

    std::vector<Seat> run(const Progress& progress)
    {
        const DrivenSurface ground(driven_, surfaces_);
        if (ground.hosts.empty() || ground.tree->empty())
            return {};
        progress.tick(0.0, "finding what lies beneath free parts");
        each([&](int i) { put_on(ground, i); });
        progress.tick(0.0, "finding what free parts ride on");
        each([&](int i) { list_candidates(i); });
        prepare([&](int i, std::vector<char>& needed) {
            for (const Candidate& candidate : candidates_[i])
                needed[candidate.part] = 1;
        });
        each([&](int i) { move_to_candidate(i); });
        prepare(
            [&](int i, std::vector<char>& needed) { needed[seats_[i].host] |= seats_[i].beneath.empty(); });
        each([&](int i) {
            Seat& seat = seats_[i];
            if (seat.beneath.empty())
                for (int v : seat.samples)
                    seat.beneath.push_back(
                        surfaces_[seat.host]->tree().closest_place(parts_[seat.part].points[v]));
        });
        return std::move(seats_);
    }

private:
    template <class Body>
    void each(Body&& body)
    {
        parallel_for(static_cast<int>(seats_.size()), body, 8);
    }

    /// Makes the trees of the parts that `mark(seat, needed)` marks.
    template <class Mark>
    void prepare(Mark&& mark)
    {
        std::vector<char> needed(parts_.size(), 0);
        for (int i = 0; i < static_cast<int>(seats_.size()); ++i)
            mark(i, needed);
        parallel_for(
            static_cast<int>(parts_.size()),
            [&](int p) {
                if (!needed[p])
                    return;
                if (!surfaces_[p])
                    surfaces_[p] = std::make_unique<HostSurface>(parts_[p]);
                surfaces_[p]->prepare_tree();
            },
            1);
    }

    /// Seats a part on the driven one that is nearest.
    void put_on(const DrivenSurface& ground, int i)
    {
        Seat& seat = seats_[i];
        const Part& part = parts_[seat.part];
        seat.samples = farthest_points(
            part.points, part.extent() > length_ ? samples_of_large : samples_of_small, part.centre());
        for (int v : seat.samples)
            seat.beneath.push_back(ground.tree->closest_place(part.points[v]));
        std::vector<double> gaps;
        for (std::size_t s = 0; s < std::min<std::size_t>(seat.samples.size(), judging_samples); ++s)
            gaps.push_back(gap(part, seat, s));
        const auto nearest = std::ranges::min_element(gaps) - gaps.begin();
        const std::size_t owner = ground.owner(seat.beneath[nearest].triangle);
        seat.host = ground.hosts[owner];
        halves_[i] = median(gaps) / 2;
        for (TriangleTree::Place& place : seat.beneath) {
            if (ground.owner(place.triangle) != owner) {
                seat.beneath.clear(); // another driven part was nearer there: to be asked again
                break;
            }
            place.triangle -= ground.firsts[owner];
        }
    }

    void list_candidates(int i)
    {
        const Part& part = parts_[seats_[i].part];
        Eigen::AlignedBox3d around = part.box;
        around.min().array() -= halves_[i];
        around.max().array() += halves_[i];
        for (const Seat& other : seats_) { // by falling area
            const Part& larger = parts_[other.part];
            if (larger.area <= 1.0001 * part.area || larger.area == 0.0)
                break;
            if (!larger.box.intersects(around))
                continue;
            std::vector<double> gaps;
            for (std::size_t s = 0; s < judged(i); ++s)
                gaps.push_back(larger.box.exteriorDistance(part.points[seats_[i].samples[s]]));
            if (const double least = median(gaps); least < halves_[i])
                candidates_[i].push_back({least, other.part});
        }
        std::ranges::stable_sort(candidates_[i], {}, &Candidate::least);
    }

    void move_to_candidate(int i)
    {
        Seat& seat = seats_[i];
        double best = halves_[i];
        for (const Candidate& candidate : candidates_[i]) {
            if (candidate.least >= best)
                break;
            std::vector<double> gaps;
            for (std::size_t s = 0; s < judged(i); ++s) {
                const Vector3& point = parts_[seat.part].points[seat.samples[s]];
                gaps.push_back((surfaces_[candidate.part]->tree().closest(point) - point).norm());
            }
            if (const double found = median(gaps); found < best) {
                best = found;
                seat.host = candidate.part;
                seat.beneath.clear();
            }
        }
    }

    std::size_t judged(int i) const
    {
        return std::min<std::size_t>(seats_[i].samples.size(), judging_samples);
    }

    const std::vector<Part>& parts_;
    const std::vector<bool>& driven_;
    double length_;
    HostSurfaces& surfaces_;
    std::vector<Seat> seats_;
    std::vector<double> halves_; ///< half the median distance from the driven parts
    std::vector<std::vector<Candidate>> candidates_;
};

} // namespace

std::vector<Seat> find_seats(const std::vector<Part>& parts, const std::vector<bool>& driven, double length,
                             HostSurfaces& surfaces, const Progress& progress)
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
    return Seating(parts, driven, length, surfaces).run(progress);
}

} // namespace sinew

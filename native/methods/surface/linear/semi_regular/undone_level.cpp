// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/semi_regular/undone_level.h"

#include "native/core/memory.h"
#include "native/methods/surface/linear/semi_regular/corners.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <span>
#include <tuple>
#include <utility>

namespace sinew {

namespace {

enum class Role : char { none, kept, edge, face };

constexpr int middle = -2; ///< the mark of a triangle between three edge points
constexpr double pi = std::numbers::pi;

/// The roles of the vertices of some parts of a mesh.
class Roles
{
public:
    Roles(const JoinedCorners& corners, int vertices)
        : corners_(corners), mark_(corners.first.size() - 1, JoinedCorners::none),
          role_(vertices, Role::none), parents_(vertices, {JoinedCorners::none, JoinedCorners::none})
    {
    }

    Role operator()(int vertex) const { return role_[vertex]; }
    /// The corner of the kept vertex of a face, or `middle`.
    int mark(int face) const { return mark_[face]; }
    /// The two kept vertices beside an edge point.
    const std::array<int, 2>& parents(int vertex) const { return parents_[vertex]; }
    int beside(int edge_point, int kept) const
    {
        const auto [a, b] = parents_[edge_point];
        return a == kept ? b : a;
    }
    /// The kept vertices around a face point.
    void around(int face_point, std::vector<int>& kept) const
    {
        corners_.fan(face_point, kept);
        for (int& c : kept)
            c = corners_.vertex[corners_.across(c)];
    }
    /// Those around the edge points of a triangle in the middle.
    std::array<int, 3> around_middle(int face) const
    {
        std::array<int, 3> kept{};
        for (int k = 0; k < 3; ++k) {
            const int twin = corners_.twin[corners_.first[face] + k];
            kept[k] =
                twin == JoinedCorners::none ? JoinedCorners::none : corners_.vertex[corners_.previous(twin)];
        }
        return kept;
    }

    /// Colours a part and keeps the best valid choice.
    /// \param faces  of the part.
    Undoing choose(std::span<const int> faces, std::span<const int> vertices, int least)
    {
        const int start = faces.front();
        const int begin = corners_.first[start], end = corners_.first[start + 1];
        std::vector<int> seeds;
        for (int c = begin; c < end; ++c)
            seeds.push_back(c);
        if (end - begin == 3)
            seeds.push_back(middle);
        using Rank = std::tuple<bool, bool, bool, int>; // what UndoneLevel prefers, in this order
        int best = JoinedCorners::none;
        Rank best_rank;
        for (int seed : seeds) {
            if (!colour(start, seed, faces) || !is_subdivision(faces, vertices))
                continue;
            const auto is_kept = [&](int v) { return role_[v] == Role::kept; };
            const Rank rank{!std::ranges::is_partitioned(vertices, is_kept), !has_quads_only(vertices),
                            !is_kept(vertices.front()), *std::ranges::find_if(vertices, is_kept)};
            if (best == JoinedCorners::none || rank < best_rank) {
                best = seed;
                best_rank = rank;
            }
        }
        if (best == JoinedCorners::none) {
            clear(vertices);
            return Undoing::irregular;
        }
        colour(start, best, faces);
        is_subdivision(faces, vertices);
        const auto kept = std::ranges::count(vertices, Role::kept, [&](int v) { return role_[v]; });
        if (kept >= least)
            return Undoing::undone;
        clear(vertices);
        return Undoing::small;
    }

private:
    std::span<const int> loop(int face) const
    {
        return {corners_.vertex.data() + corners_.first[face],
                corners_.vertex.data() + corners_.first[face + 1]};
    }

    void clear(std::span<const int> vertices)
    {
        for (int v : vertices)
            role_[v] = Role::none;
    }

    Role role_at(int corner) const
    {
        const int mark = mark_[corners_.face[corner]];
        if (mark == corner)
            return Role::kept;
        return mark != middle && loop(corners_.face[corner]).size() == 4 && corners_.across(mark) == corner
                   ? Role::face
                   : Role::edge;
    }

    /// The mark of the face across a side whose own mark is known.
    int mark_across(int corner) const
    {
        const int mark = mark_[corners_.face[corner]], twin = corners_.twin[corner];
        if (mark == corner)
            return corners_.next(twin);
        if (mark == corners_.next(corner))
            return twin;
        if (loop(corners_.face[corner]).size() == 3)
            return mark == middle ? corners_.previous(twin) : middle;
        return mark == corners_.previous(corner) ? corners_.across(twin) : corners_.previous(twin);
    }

    /// Marks all faces, from one on. Returns whether they agree.
    bool colour(int start, int seed, std::span<const int> faces)
    {
        for (int f : faces) {
            mark_[f] = JoinedCorners::none;
            for (int v : loop(f))
                role_[v] = Role::none;
        }
        mark_[start] = seed;
        queue_.assign(1, start);
        while (!queue_.empty()) {
            const int f = queue_.back();
            queue_.pop_back();
            for (int c = corners_.first[f]; c < corners_.first[f + 1]; ++c) {
                Role& role = role_[corners_.vertex[c]];
                if (role != Role::none && role != role_at(c))
                    return false;
                role = role_at(c);
                if (corners_.twin[c] == JoinedCorners::none)
                    continue;
                const int other = corners_.face[corners_.twin[c]], mark = mark_across(c);
                if (mark_[other] != JoinedCorners::none && mark_[other] != mark)
                    return false;
                if (mark_[other] == JoinedCorners::none) {
                    mark_[other] = mark;
                    queue_.push_back(other);
                }
            }
        }
        return std::ranges::none_of(faces, [&](int f) { return mark_[f] == JoinedCorners::none; });
    }

    /// Checks what UndoneLevel asks for, and finds the parents of the edge points.
    bool is_subdivision(std::span<const int> faces, std::span<const int> vertices)
    {
        const bool triangles = loop(faces.front()).size() == 3;
        for (int v : vertices) {
            const bool closed = corners_.fan(v, fan_);
            const int count = static_cast<int>(fan_.size());
            if (role_[v] == Role::edge && count != (triangles ? closed ? 6 : 3 : closed ? 4 : 2))
                return false;
            if (role_[v] == Role::face && (!closed || count < 3))
                return false;
            if (role_[v] != Role::edge)
                continue;
            std::array<int, 2>& parents = parents_[v];
            parents = {JoinedCorners::none, JoinedCorners::none};
            for (int c : fan_)
                for (int w : {corners_.vertex[corners_.next(c)], corners_.vertex[corners_.previous(c)]}) {
                    if (role_[w] != Role::kept || w == parents[0] || w == parents[1])
                        continue;
                    if (parents[1] != JoinedCorners::none)
                        return false;
                    parents[parents[0] == JoinedCorners::none ? 0 : 1] = w;
                }
            if (parents[1] == JoinedCorners::none)
                return false;
            if (parents[0] > parents[1])
                std::swap(parents[0], parents[1]);
        }
        pairs_.clear();
        for (int v : vertices) {
            if (role_[v] == Role::edge)
                pairs_.push_back(parents_[v]);
            if (role_[v] == Role::face) {
                around(v, fan_);
                std::ranges::sort(fan_);
                if (std::ranges::adjacent_find(fan_) != fan_.end())
                    return false;
            }
        }
        std::ranges::sort(pairs_);
        if (std::ranges::adjacent_find(pairs_) != pairs_.end())
            return false;
        for (int f : faces)
            if (mark_[f] == middle)
                if (const auto [a, b, c] = around_middle(f);
                    std::min({a, b, c}) == JoinedCorners::none || a == b || b == c || c == a)
                    return false;
        return true;
    }

    bool has_quads_only(std::span<const int> vertices) const
    {
        return std::ranges::all_of(vertices,
                                   [&](int v) { return role_[v] != Role::face || corners_.count[v] == 4; });
    }

    const JoinedCorners& corners_;
    std::vector<int> mark_;
    std::vector<Role> role_;
    std::vector<std::array<int, 2>> parents_;
    std::vector<int> queue_, fan_;
    std::vector<std::array<int, 2>> pairs_;
};

/// Elements by part, in their order.
std::vector<std::vector<int>> by_part(int count, std::size_t parts, const auto& part_of)
{
    std::vector<std::vector<int>> lists(parts);
    for (int k = 0; k < count; ++k)
        if (const int p = part_of(k); p >= 0)
            lists[p].push_back(k);
    return lists;
}

/// One row of a rule as it is summed up.
class Row
{
public:
    void add(int vertex, double weight) { entries_.emplace_back(vertex, weight); }
    void mean(const std::vector<int>& vertices, double weight)
    {
        for (int v : vertices)
            add(v, weight / static_cast<double>(vertices.size()));
    }

    /// Appends the sums by rising vertex, and clears the row.
    void move_to(std::vector<int>& vertices, std::vector<double>& weights)
    {
        std::ranges::sort(entries_);
        int last = JoinedCorners::none;
        for (const auto& [v, w] : entries_) {
            if (v == last) {
                weights.back() += w;
            } else {
                vertices.push_back(v);
                weights.push_back(w);
            }
            last = v;
        }
        entries_.clear();
    }

private:
    std::vector<std::pair<int, double>> entries_;
};

/// The weights by which one step of subdivision makes a vertex of an undone part from those that are kept.
/// Borders are cubic B-splines, as `BoundarySmooth::all` has them.
class Rules
{
public:
    Rules(const JoinedCorners& corners, const Roles& roles) : corners_(corners), roles_(roles) {}

    void add(int v, Row& row)
    {
        const bool closed = corners_.fan(v, fan_);
        const bool triangles =
            corners_.first[corners_.face[fan_[0]] + 1] - corners_.first[corners_.face[fan_[0]]] == 3;
        if (roles_(v) == Role::face) {
            roles_.around(v, list_);
            row.mean(list_, 1.0);
        } else if (roles_(v) == Role::edge) {
            const auto [a, b] = roles_.parents(v);
            const double share = !closed ? 0.5 : triangles ? 0.375 : 0.25;
            row.add(a, share);
            row.add(b, share);
            if (closed && triangles)
                for (int c : fan_) {
                    if (roles_.mark(corners_.face[c]) == middle)
                        for (int w : roles_.around_middle(corners_.face[c]))
                            if (w != a && w != b)
                                row.add(w, 0.125);
                }
            else if (closed)
                for (int c : fan_)
                    if (const int w = corners_.vertex[corners_.next(c)]; roles_(w) == Role::face) {
                        roles_.around(w, list_);
                        row.mean(list_, 0.25);
                    }
        } else if (!closed) {
            row.add(v, 0.75);
            row.add(roles_.beside(corners_.vertex[corners_.next(fan_.front())], v), 0.125);
            row.add(roles_.beside(corners_.vertex[corners_.previous(fan_.back())], v), 0.125);
        } else {
            const double n = static_cast<double>(fan_.size());
            const double c = 0.375 + 0.25 * std::cos(2 * pi / n);
            const double share = triangles ? (0.625 - c * c) / n : 1.0 / (n * n);
            row.add(v, triangles ? 1.0 - n * share : (n - 2.0) / n);
            for (int corner : fan_) {
                row.add(roles_.beside(corners_.vertex[corners_.next(corner)], v), share);
                if (!triangles) {
                    roles_.around(corners_.vertex[corners_.across(corner)], list_);
                    row.mean(list_, share);
                }
            }
        }
    }

private:
    const JoinedCorners& corners_;
    const Roles& roles_;
    std::vector<int> fan_, list_;
};

/// The numbers of the tangents of a vertex: inside, those of the limit surface (D. Zorin, P. Schroeder et
/// al., "Subdivision for Modeling and Animation", SIGGRAPH 2000 course).
void tangents(const JoinedCorners& corners, int v, std::vector<int>& fan,
              std::vector<RingFrames::Neighbour>& found)
{
    found.clear();
    const bool closed = corners.fan(v, fan);
    const int faces = static_cast<int>(fan.size());
    if (!closed) {
        const int edges = faces + 1;
        for (int k = 0; k < edges; ++k) {
            const int w = k < faces ? corners.vertex[corners.next(fan[k])]
                                    : corners.vertex[corners.previous(fan.back())];
            const double along = k == 0 ? 1.0 : k == faces ? -1.0 : 0.0;
            found.push_back({w, along, edges == 2 ? 1.0 : std::sin(pi * k / faces)});
        }
        return;
    }
    const bool quads = corners.first[corners.face[fan[0]] + 1] - corners.first[corners.face[fan[0]]] == 4;
    const double step = 2 * pi / faces;
    const double edge =
        !quads ? 1.0 : 1.0 + std::cos(step) + std::cos(0.5 * step) * std::sqrt(2.0 * (9.0 + std::cos(step)));
    for (int k = 0; k < faces; ++k) {
        const double a = step * k, b = step * (k + 1);
        found.push_back({corners.vertex[corners.next(fan[k])], edge * std::cos(a), edge * std::sin(a)});
        if (quads)
            found.push_back({corners.vertex[corners.across(fan[k])], std::cos(a) + std::cos(b),
                             std::sin(a) + std::sin(b)});
    }
}

} // namespace

UndoneLevel undo_subdivision(const SurfaceMesh& mesh, const std::vector<int>& part,
                             std::vector<Undoing>& undoing, int least)
{
    const int n = mesh.vertex_count();
    const std::size_t parts = undoing.size();
    std::vector<char> sound(parts);
    for (std::size_t p = 0; p < parts; ++p)
        sound[p] = undoing[p] == Undoing::wanted;
    const JoinedCorners corners(mesh, part, sound);
    Roles roles(corners, n);
    const auto wanted = [&](int p) { return undoing[p] == Undoing::wanted ? p : -1; };
    const auto faces = by_part(mesh.face_count(), parts, [&](int f) {
        return corners.first[f] < corners.first[f + 1] ? wanted(part[mesh.face(f).front()]) : -1;
    });
    const auto vertices = by_part(n, parts, [&](int v) { return wanted(part[v]); });
    std::int64_t bytes = 0;
    std::vector<int> around;
    for (std::size_t p = 0; p < parts; ++p) {
        if (undoing[p] != Undoing::wanted)
            continue;
        undoing[p] =
            sound[p] && !faces[p].empty() ? roles.choose(faces[p], vertices[p], least) : Undoing::irregular;
        if (undoing[p] != Undoing::undone)
            continue;
        const int quads = mesh.face(faces[p].front()).size() == 4 ? 2 : 1;
        for (int v : vertices[p]) // the frame, the detail, and at least two weights that are kept twice
            bytes += static_cast<std::int64_t>(sizeof(RingFrames::Neighbour)) * corners.count[v] *
                         (corners.fan(v, around) ? quads : 1) +
                     72;
    }
    require_memory(bytes, "the levels");

    UndoneLevel level;
    std::vector<int> number(n, JoinedCorners::none);
    const auto is_undone = [&](int v) { return undoing[part[v]] == Undoing::undone; };
    for (int v = 0; v < n; ++v)
        if (!is_undone(v) || roles(v) == Role::kept) {
            number[v] = static_cast<int>(level.kept.size());
            level.kept.push_back(v);
        }
    const auto add_face = [&](const auto& loop) {
        level.counts.push_back(static_cast<int>(loop.size()));
        for (int v : loop)
            level.corners.push_back(number[v]);
    };
    for (int f = 0; f < mesh.face_count(); ++f)
        if (!is_undone(mesh.face(f).front()))
            add_face(mesh.face(f));
        else if (roles.mark(f) == middle)
            add_face(roles.around_middle(f));
    Rules rules(corners, roles);
    Row row;
    std::vector<int> offsets{0}, columns;
    std::vector<double> weights;
    std::vector<RingFrames::Neighbour> numbers;
    for (int v = 0; v < n; ++v) {
        if (!is_undone(v)) {
            row.add(v, 1.0);
        } else {
            if (roles(v) == Role::face) {
                roles.around(v, around);
                add_face(around);
            }
            rules.add(v, row);
            tangents(corners, v, around, numbers);
            level.made.push_back(v);
            level.frames.add(numbers);
        }
        row.move_to(columns, weights);
        offsets.push_back(static_cast<int>(columns.size()));
    }
    for (int& c : columns)
        c = number[c];
    level.rule = Eigen::Map<const SparseRows>(n, static_cast<Eigen::Index>(level.kept.size()),
                                              static_cast<Eigen::Index>(columns.size()), offsets.data(),
                                              columns.data(), weights.data());
    return level;
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/primo/prisms.h"

#include "native/core/parallel.h"
#include "native/operators/laplacian.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <numeric>
#include <tuple>
#include <utility>

namespace sinew {

namespace {

/// Bounds of a weight, as shares of the median; they keep the bodies connected, and the factor well
/// conditioned.
constexpr double least_weight = 1e-6, most_weight = 1e4;
constexpr int most_partners = 4; ///< of a face among the later faces at the same edge
/// The weight of a joint between a prism and the body of its corner, as a multiple of the median.
constexpr double anchor = 10.0;

/// The area vector of a polygon.
template <class Corner>
Vector3 area_vector(std::size_t count, Corner&& corner)
{
    Vector3 sum = Vector3::Zero();
    const Vector3 first = corner(0);
    for (std::size_t k = 1; k + 1 < count; ++k)
        sum += (corner(k) - first).cross(corner(k + 1) - first);
    return 0.5 * sum;
}

/// Ends of the chains of joined numbers.
struct Sets
{
    std::vector<int> parent;
    explicit Sets(std::size_t count) : parent(count) { std::iota(parent.begin(), parent.end(), 0); }
    int root(int i)
    {
        while (parent[i] != i)
            i = parent[i] = parent[parent[i]];
        return i;
    }
    void join(int a, int b) { parent[root(a)] = root(b); }
};

} // namespace

Prisms::Prisms(const SurfaceMesh& mesh, const Regions& regions, std::vector<double> height)
    : height_(std::move(height)), first_prism_(mesh.vertex_count() + 1, 0), body_of_(mesh.vertex_count(), -1)
{
    std::vector<int> faces; // of each body
    std::vector<int> corners;
    for (int f = 0; f < mesh.face_count(); ++f) {
        corners.clear();
        for (int v : mesh.face(f))
            if (std::ranges::find(corners, v) == corners.end())
                corners.push_back(v);
        if (corners.size() < 2 || regions.is_idle(corners[0]))
            continue;
        const bool held = std::ranges::all_of(corners, [&](int v) { return regions.hard(v) >= 0; });
        add_body(corners, held ? regions.hard(corners[0]) : -1);
        faces.push_back(f);
    }
    for (int v : corners_)
        ++first_prism_[v + 1];
    std::partial_sum(first_prism_.begin(), first_prism_.end(), first_prism_.begin());
    prisms_at_.resize(corners_.size());
    std::vector<int> next(first_prism_.begin(), first_prism_.end() - 1);
    for (int b = 0; b < size(); ++b)
        for (int v : this->corners(b))
            prisms_at_[next[v]++] = b;
    join_at_edges(mesh, faces);
    join_at_vertices();
    add_vertices(regions);
}

void Prisms::add_body(std::span<const int> corners, int handle)
{
    corners_.insert(corners_.end(), corners.begin(), corners.end());
    first_corner_.push_back(static_cast<int>(corners_.size()));
    handles_.push_back(handle);
}

void Prisms::join_at_edges(const SurfaceMesh& mesh, const std::vector<int>& faces)
{
    const PointsView points = view(mesh.points());
    std::vector<double> area(size());
    parallel_for(size(), [&](int b) {
        double longest = 0.0;
        const std::span<const int> own = corners(b);
        for (std::size_t k = 0; k < own.size(); ++k)
            longest =
                std::max(longest, (points.row(own[k]) - points.row(own[(k + 1) % own.size()])).squaredNorm());
        area[b] = std::max(this->area(points, b).norm(), needle * longest);
    });
    std::vector<std::array<int, 3>> sides; // both ends, and the body
    for (int b = 0; b < size(); ++b) {
        const std::span<const int> face = mesh.face(faces[b]);
        for (std::size_t k = 0; k < face.size(); ++k) {
            const auto [low, high] = std::minmax(face[k], face[(k + 1) % face.size()]);
            if (low != high)
                sides.push_back({low, high, b});
        }
    }
    std::ranges::sort(sides);
    std::vector<double> weights;
    for (std::size_t k = 0; k < sides.size(); ++k)
        for (std::size_t other = k + 1; other < sides.size() && other <= k + most_partners &&
                                        sides[other][0] == sides[k][0] && sides[other][1] == sides[k][1];
             ++other) {
            const auto [v, w, a] = sides[k];
            const int b = sides[other][2];
            if (a == b)
                continue;
            const double length = (points.row(v) - points.row(w)).squaredNorm();
            const double both = area[a] + area[b];
            joints_.push_back({{a, b}, {v, w}, both > 0 ? 2 * length / both : 0.0});
            weights.push_back(joints_.back().weight);
        }
    if (weights.empty())
        return;
    const auto middle = weights.begin() + static_cast<std::ptrdiff_t>(weights.size() / 2);
    std::ranges::nth_element(weights, middle);
    if (*middle > 0)
        typical_ = *middle;
    for (Joint& joint : joints_)
        joint.weight = std::clamp(joint.weight, least_weight * typical_, most_weight * typical_);
}

void Prisms::join_at_vertices()
{
    Sets fans(prisms_at_.size());
    const auto place = [&](int vertex, int body) {
        return static_cast<int>(std::find(prisms_at_.begin() + first_prism_[vertex], prisms_at_.end(), body) -
                                prisms_at_.begin());
    };
    for (const Joint& joint : joints_)
        for (int v : joint.end)
            fans.join(place(v, joint.body[0]), place(v, joint.body[1]));
    for (std::size_t v = 0; v + 1 < first_prism_.size(); ++v)
        for (int k = first_prism_[v] + 1; k < first_prism_[v + 1]; ++k)
            if (const int first = first_prism_[v]; fans.root(k) != fans.root(first)) {
                const int vertex = static_cast<int>(v);
                joints_.push_back({{prisms_at_[first], prisms_at_[k]}, {vertex, vertex}, typical_});
                fans.join(k, first);
            }
}

void Prisms::add_vertices(const Regions& regions)
{
    const auto add = [&](int v, int handle) {
        if (body_of_[v] >= 0)
            return;
        body_of_[v] = size();
        for (int b : prisms_at(v))
            if (handles_[b] < 0)
                joints_.push_back({{b, size()}, {v, v}, anchor * typical_});
        add_body({&v, 1}, handle);
    };
    for (int v = 0; v < regions.vertex_count(); ++v)
        if (regions.hard(v) >= 0 && std::ranges::any_of(prisms_at(v), [&](int b) { return handles_[b] < 0; }))
            add(v, regions.hard(v));
    for (const SoftConstraint& soft : regions.soft())
        add(soft.vertex, -1);
}

HandleGraph Prisms::graph(const Regions& regions) const
{
    std::vector<int> begin(size() + 1, 0);
    for (const Joint& joint : joints_)
        for (int b : joint.body)
            ++begin[b + 1];
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<std::pair<int, double>> all(begin.back());
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for (const Joint& joint : joints_)
        for (int side : {0, 1})
            all[next[joint.body[side]]++] = {joint.body[1 - side], joint.weight};
    GraphEdges edges;
    for (int b = 0; b < size(); ++b) {
        const auto own = std::span(all).subspan(begin[b], begin[b + 1] - begin[b]);
        std::ranges::sort(own);
        for (std::size_t k = 0; k < own.size(); ++k)
            if (k > 0 && own[k].first == own[k - 1].first) {
                edges.weights.back() += own[k].second;
            } else {
                edges.neighbours.push_back(own[k].first);
                edges.weights.push_back(own[k].second);
            }
        edges.offsets.push_back(static_cast<int>(edges.neighbours.size()));
    }
    GraphHandles held;
    held.hard = handles_;
    held.idle.assign(size(), 0);
    for (const SoftConstraint& soft : regions.soft()) {
        const std::size_t prisms = std::max<std::size_t>(prisms_at(soft.vertex).size(), 1);
        held.pulls.push_back({body_of_[soft.vertex], soft.handle,
                              soft.stiffness() * anchor * typical_ * static_cast<double>(prisms)});
    }
    return {std::move(edges), std::move(held)};
}

void Prisms::renumber(const std::vector<int>& old)
{
    const std::vector<int> renamed = new_numbers(old);
    const Prisms before = *this;
    first_corner_.assign(1, 0);
    corners_.clear();
    handles_.clear();
    for (int b : old)
        add_body(before.corners(b), before.handle(b));
    for (int& b : prisms_at_)
        b = renamed[b];
    for (int& b : body_of_)
        b = b < 0 ? b : renamed[b];
    for (Joint& joint : joints_)
        for (int& b : joint.body)
            b = renamed[b];
}

std::vector<BodyJoint> Prisms::joints() const
{
    std::vector<BodyJoint> result;
    for (const Joint& joint : joints_)
        result.push_back({{joint.body[0], joint.body[1]}, joint.weight});
    return result;
}

Vector3 Prisms::area(const PointsView& points, int body) const
{
    const std::span<const int> own = corners(body);
    return area_vector(own.size(), [&](std::size_t k) -> Vector3 { return points.row(own[k]); });
}

Vector3 Prisms::area(const Points& corners)
{
    return area_vector(static_cast<std::size_t>(corners.rows()),
                       [&](std::size_t k) -> Vector3 { return corners.row(static_cast<Eigen::Index>(k)); });
}

void Prisms::set_shape(const PointsView& points, PrismShape& shape) const
{
    shape.points = points;
    shape.centres.resize(size(), 3);
    shape.area.resize(size(), 3);
    shape.normals.resize(points.rows(), 3);
    parallel_for(size(), [&](int b) {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (int v : corners(b))
            sum += points.row(v);
        shape.centres.row(b) = is_vertex(b) ? sum : sum / static_cast<double>(corners(b).size());
        shape.area.row(b) = area(points, b).transpose();
    });
    parallel_for(static_cast<int>(points.rows()), [&](int v) {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (int b : prisms_at(v))
            sum += shape.area.row(b);
        const double length = sum.norm();
        shape.normals.row(v) = length > 0 ? sum / length : sum;
    });
}

JointShape Prisms::joint_shape(int joint, const PrismShape& shape) const
{
    const Joint& own = joints_[joint];
    const auto [v, w] = own.end;
    const Vector3 x_v = shape.points.row(v), x_w = shape.points.row(w);
    const Vector3 middle = 0.5 * (x_v + x_w);
    JointShape result;
    for (int side : {0, 1})
        result.lever[side] = middle - shape.centres.row(own.body[side]).transpose();
    if (is_vertex(own.body[1])) {
        result.form.setZero();
    } else if (v == w) {
        result.form = height_[v] * height_[v] / 3.0 * Matrix3::Identity();
    } else {
        const Vector3 n_v = height_[v] * shape.normals.row(v), n_w = height_[w] * shape.normals.row(w);
        const Vector3 along = 0.5 * (x_w - x_v), up = 0.5 * (n_v + n_w), skew = 0.5 * (n_w - n_v);
        result.form = (along * along.transpose() + up * up.transpose()) / 3.0 + skew * skew.transpose() / 9.0;
    }
    return result;
}

} // namespace sinew

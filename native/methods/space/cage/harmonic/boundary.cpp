// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/harmonic/boundary.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/aligned.h"
#include "native/core/simd/kernel_set.h"
#include "native/solvers/dense/kernels.h"

#include <Eigen/Geometry>
#include <Eigen/LU>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace sinew {

namespace {

constexpr double inward = 1e-9; ///< how far inside the cage the collocation points lie, in units of its size
constexpr double flattest = 1e-7; ///< least height of a triangle, as a share of its longest side
constexpr double least_pivot = 1e-7;
constexpr int far_group = 64; ///< number of triangles whose far fields are multiplied at once
constexpr int block_rows = 192; ///< about how many collocation points are assembled at once
constexpr int ticks = 16; ///< reports of progress during the assembly
constexpr int block_points = 256;

/// The hat values of the three points per panel, a quadrature rule that is exact for quadratics.
constexpr double rule(int point, int corner) { return point == corner ? 2.0 / 3.0 : 1.0 / 6.0; }

int padded(int count, int to) { return (count + to - 1) / to * to; }

void set(double (&to)[3], const Vector3& from)
{
    for (int k = 0; k < 3; ++k)
        to[k] = from[k];
}

LayerEdge edge_between(const double* corners, int from, int to)
{
    const double dx = corners[2 * to] - corners[2 * from], dy = corners[2 * to + 1] - corners[2 * from + 1];
    const double length = std::hypot(dx, dy), sx = dx / length, sy = dy / length;
    const double x = corners[2 * from], y = corners[2 * from + 1];
    return {from, to, sx, sy, sy, -sx, sy * x - sx * y, sx * x + sy * y, length};
}

/// Computes the geometry of a panel from its corners and edges.
void measure(LayerPanel& panel, const double* corners, const LayerEdge* edges)
{
    std::array<Eigen::Vector2d, 3> p, m;
    for (int k = 0; k < 3; ++k) {
        p[k] = {corners[2 * panel.corner[k]], corners[2 * panel.corner[k] + 1]};
        const LayerEdge& edge = edges[panel.edge[k]];
        m[k] = panel.turn[k] * Eigen::Vector2d(edge.mx, edge.my);
    }
    const Eigen::Vector2d ab = p[1] - p[0], ac = p[2] - p[0];
    panel.double_area = ab.x() * ac.y() - ab.y() * ac.x();
    for (int c = 0; c < 3; ++c) {
        panel.inverse_height[c] = edges[panel.edge[(c + 1) % 3]].length / panel.double_area;
        for (int k = 0; k < 3; ++k)
            panel.slope[c][k] = -panel.inverse_height[c] * m[(c + 1) % 3].dot(m[k]);
    }
}

/// Whether a point lies on a triangle, up to a tolerance.
bool holds(const LayerFace& face, const Vector3& point)
{
    constexpr double about = 1e-6;
    const Vector3 away = point - Vector3(face.origin);
    const double x = away.dot(Vector3(face.x)), y = away.dot(Vector3(face.y));
    bool inside = std::abs(away.dot(Vector3(face.n))) < about;
    for (int k = 0; k < 3; ++k)
        inside = inside && face.edge[k].offset - (face.edge[k].mx * x + face.edge[k].my * y) > -about;
    return inside;
}

} // namespace

/// Points relative to the cage's centre, in units of its size: all x, then all y, then all z. The last point
/// is repeated to fill the lanes.
struct HarmonicBoundary::Block
{
    Block(int points)
        : count(points), stride(padded(points, most_layer_points)), xyz(static_cast<std::size_t>(3 * stride))
    {
    }
    void set(int i, const Vector3& point)
    {
        for (int k = 0; k < 3; ++k)
            xyz[static_cast<std::size_t>(k * stride + i)] = point[k];
    }
    void fill()
    {
        for (int i = count; i < stride; ++i)
            set(i, {xyz[count - 1], xyz[stride + count - 1], xyz[2 * stride + count - 1]});
    }

    int count, stride;
    AlignedVector<double> xyz;
};

/// The points of a block that are near a triangle, and the single layer potentials of its unknowns there.
struct HarmonicBoundary::Near
{
    std::vector<int> points;
    AlignedVector<double> xyz, single; ///< `single` is (points, width)
    int width = 0;
};

HarmonicBoundary::HarmonicBoundary(const Cage& cage, int level, const Progress& progress)
    : pattern_(harmonic_pattern(level)), control_count_(cage.control_count()), size_(cage.size()),
      centre_(
          0.5 *
          (cage.rest().points().colwise().maxCoeff() + cage.rest().points().colwise().minCoeff()).transpose())
{
    data_ = harmonic_data(cage);
    place(cage);
    cut();
    const int count = static_cast<int>(triangles_.size()), n = unknowns();
    require_memory(DenseSystem::bytes(n, control_count_) +
                       static_cast<std::int64_t>(n + 3 * count) * (control_count_ + strip_width) * 8,
                   "the boundary of the cage");
    DenseSystem system(n, control_count_);
    const int group = std::max(1, block_rows / (3 * static_cast<int>(pattern_.panels.size())));
    const int groups = (count + group - 1) / group;
    const int slab = std::max(2, (groups + ticks - 1) / ticks);
    for (int first = 0; first < groups; first += slab) {
        progress.tick(0.3 * first / groups, "assembling the boundary");
        parallel_tasks(std::min(slab, groups - first), [&](int task) {
            const int begin = (first + task) * group;
            assemble(system, begin, std::min(begin + group, count));
        });
    }
    std::vector<double> diagonal(static_cast<std::size_t>(n));
    for (int i = 0; i < n; ++i)
        diagonal[static_cast<std::size_t>(i)] = std::abs(system.row(i)[i]);
    system.solve(Progress([&](double fraction, const char* stage) {
        progress.tick(0.3 + 0.6 * fraction, stage);
        return true;
    }));
    check(cage, system, diagonal);
    keep(system);
    measure_residual(progress);
}

void HarmonicBoundary::place(const Cage& cage)
{
    const SurfaceMesh& rest = cage.rest();
    const int count = static_cast<int>(cage.triangles().size());
    const std::size_t corners = pattern_.corners.size(), edges = pattern_.edges.size();
    triangles_.resize(static_cast<std::size_t>(count));
    corners_.resize(2 * static_cast<std::size_t>(count) * (3 + corners));
    edges_.resize(static_cast<std::size_t>(count) * (3 + edges));
    panels_.resize(static_cast<std::size_t>(count) * (1 + pattern_.panels.size()));
    std::vector<int> flat;
    for (int t = 0; t < count; ++t) {
        const Triangle& triangle = cage.triangles()[static_cast<std::size_t>(t)];
        std::array<Vector3, 3> p;
        for (int k = 0; k < 3; ++k)
            p[k] = (rest.point(triangle[k]) - centre_) / size_;
        const Vector3 area = (p[1] - p[0]).cross(p[2] - p[0]);
        const double longest = std::max({(p[1] - p[0]).norm(), (p[2] - p[1]).norm(), (p[0] - p[2]).norm()});
        if (!(area.norm() > flattest * longest * longest)) {
            flat.push_back(cage.given_face(rest.triangle_faces()[static_cast<std::size_t>(t)]));
            continue;
        }
        LayerFace& face = triangles_[static_cast<std::size_t>(t)].face;
        const Vector3 x = (p[1] - p[0]).normalized(), n = area.normalized(), y = n.cross(x);
        set(face.origin, p[0]);
        set(face.x, x);
        set(face.y, y);
        set(face.n, n);
        face.corners = face.edges = 3;
        face.panels = 1;
        double* corner = corners_.data() + 6 * static_cast<std::size_t>(t);
        LayerEdge* edge = edges_.data() + 3 * static_cast<std::size_t>(t);
        LayerPanel& panel = panels_[static_cast<std::size_t>(t)];
        for (int k = 0; k < 3; ++k) {
            corner[2 * k] = (p[k] - p[0]).dot(x);
            corner[2 * k + 1] = (p[k] - p[0]).dot(y);
            panel.corner[k] = panel.edge[k] = k;
            panel.turn[k] = 1.0;
        }
        for (int k = 0; k < 3; ++k)
            edge[k] = edge_between(corner, k, (k + 1) % 3);
        measure(panel, corner, edge);
        face.corner = corner;
        face.edge = edge;
        face.panel = &panel;

        const Vector3 middle = (p[0] + p[1] + p[2]) / 3.0;
        double radius = 0.0;
        for (int k = 0; k < 3; ++k)
            radius = std::max(radius, (p[k] - middle).norm());
        middles_.push_back(middle);
        reaches_.push_back(std::pow(pattern_.near_radii * radius, 2));
        LayerTriangle& whole = triangles_[static_cast<std::size_t>(t)];
        whole.diagonal = data_[static_cast<std::size_t>(t)].diagonal;
        if (whole.diagonal < 0)
            continue;
        const int k = whole.diagonal;
        const int j = (k + 1) % 3;
        const auto gradient = [&](int hat) -> Eigen::Vector2d {
            const LayerEdge& opposite = edge[(hat + 1) % 3];
            return -panel.inverse_height[hat] * Eigen::Vector2d(opposite.mx, opposite.my);
        };
        whole.product = gradient(k).dot(gradient(j));
        for (int e = 0; e < 3; ++e)
            whole.along[e] = gradient(k).dot(Eigen::Vector2d(edge[e].sx, edge[e].sy));
    }
    flat.erase(std::unique(flat.begin(), flat.end()), flat.end());
    if (!flat.empty())
        throw InvalidMesh("faces " + list_some(flat) +
                              " of the cage have no area, or parts without: dissolve or merge them",
                          Error::Element::face, flat);
}

void HarmonicBoundary::cut()
{
    const std::size_t count = triangles_.size();
    double* corner = corners_.data() + 6 * count;
    LayerEdge* edge = edges_.data() + 3 * count;
    LayerPanel* panel = panels_.data() + count;
    faces_.resize(count);
    for (std::size_t t = 0; t < count; ++t) {
        LayerFace& face = faces_[t];
        face = triangles_[t].face;
        const double* whole = face.corner;
        face.corners = static_cast<int>(pattern_.corners.size());
        face.edges = static_cast<int>(pattern_.edges.size());
        face.panels = static_cast<int>(pattern_.panels.size());
        face.corner = corner;
        face.edge = edge;
        face.panel = panel;
        double* const first = corner;
        for (const Vector3& hats : pattern_.corners) {
            for (int k = 0; k < 2; ++k)
                corner[k] = hats[0] * whole[k] + hats[1] * whole[2 + k] + hats[2] * whole[4 + k];
            corner += 2;
        }
        for (const auto& [from, to] : pattern_.edges)
            *edge++ = edge_between(first, from, to);
        for (const HarmonicPattern::Panel& piece : pattern_.panels) {
            std::copy(piece.corner.begin(), piece.corner.end(), panel->corner);
            std::copy(piece.edge.begin(), piece.edge.end(), panel->edge);
            std::copy(piece.turn.begin(), piece.turn.end(), panel->turn);
            measure(*panel++, face.corner, face.edge);
        }
    }
}

Vector3 HarmonicBoundary::inside_point(int triangle, const Vector3& hats) const
{
    const LayerFace& face = triangles_[static_cast<std::size_t>(triangle)].face;
    double x = 0.0, y = 0.0;
    for (int k = 0; k < 3; ++k) {
        x += hats[k] * face.corner[2 * k];
        y += hats[k] * face.corner[2 * k + 1];
    }
    Vector3 point;
    for (int k = 0; k < 3; ++k)
        point[k] = face.origin[k] + x * face.x[k] + y * face.y[k] - inward * face.n[k];
    return point;
}

/// Adds the double layer potential of a triangle's data to the weights.
/// \param fields  the first four rows of LayerKernels::both.
/// \param rows    (block.count, stride) the weights.
void HarmonicBoundary::add_double_layer(int triangle, const Block& block, const double* fields, double* rows,
                                        int stride) const
{
    const std::vector<HarmonicData::Entry>& entries = data_[static_cast<std::size_t>(triangle)].entries;
    for (int i = 0; i < block.count; ++i, rows += stride)
        for (const HarmonicData::Entry& entry : entries)
            rows[entry.control] += entry.share * fields[entry.part * block.stride + i];
}

void HarmonicBoundary::gather_near(int triangle, const Block& block, Near& near) const
{
    near.points.clear();
    if (pattern_.panels.size() == 1)
        return; // the flux of the triangle is linear, so its linear part is exact
    const Vector3& middle = middles_[static_cast<std::size_t>(triangle)];
    const double reach = reaches_[static_cast<std::size_t>(triangle)];
    const double* x = block.xyz.data();
    for (int i = 0; i < block.count; ++i) {
        const double dx = x[i] - middle[0], dy = x[block.stride + i] - middle[1];
        const double dz = x[2 * block.stride + i] - middle[2];
        if (dx * dx + dy * dy + dz * dz < reach)
            near.points.push_back(i);
    }
    if (near.points.empty())
        return;
    const int count = static_cast<int>(near.points.size()), stride = padded(count, most_layer_points);
    near.xyz.resize(static_cast<std::size_t>(3 * stride));
    for (int k = 0; k < 3; ++k)
        for (int i = 0; i < stride; ++i)
            near.xyz[static_cast<std::size_t>(k * stride + i)] =
                x[k * block.stride + near.points[static_cast<std::size_t>(std::min(i, count - 1))]];
    near.width = padded(pattern_.unknowns, 4);
    near.single.resize(static_cast<std::size_t>(stride * near.width));
    widest_kernels<LayerKernels>().single(faces_[static_cast<std::size_t>(triangle)], near.xyz.data(), stride,
                                          stride, near.single.data());
}

/// Assembles the rows of triangles [begin, end).
void HarmonicBoundary::assemble(DenseSystem& system, int begin, int end) const
{
    const int panels = static_cast<int>(pattern_.panels.size()), n = pattern_.unknowns;
    const int points = 3 * panels; // per triangle
    Block block((end - begin) * points);
    for (int t = begin; t < end; ++t)
        for (int p = 0; p < panels; ++p)
            for (int q = 0; q < 3; ++q) {
                Vector3 hats = Vector3::Zero();
                const HarmonicPattern::Panel& panel = pattern_.panels[static_cast<std::size_t>(p)];
                for (int c = 0; c < 3; ++c)
                    hats += rule(q, c) * pattern_.corners[static_cast<std::size_t>(panel.corner[c])];
                const int i = (t - begin) * points + 3 * p + q;
                block.set(i, inside_point(t, hats));
                for (int c = 0; c < 3; ++c)
                    data_[static_cast<std::size_t>(t)].add(hats, panel.area * rule(q, c),
                                                           system.right_side(t * n + panel.corner[c]));
            }
    block.fill();

    AlignedVector<double> fields(static_cast<std::size_t>(7 * block.stride));
    std::vector<double> twofold(static_cast<std::size_t>(block.count) *
                                static_cast<std::size_t>(control_count_));
    std::vector<int> place(static_cast<std::size_t>(block.count), -1); // index among the near points, or -1
    RowMatrix linear(n, 3);
    Near near;
    for (int s = 0; s < static_cast<int>(triangles_.size()); ++s) {
        widest_kernels<LayerKernels>().both(triangles_[static_cast<std::size_t>(s)], block.xyz.data(),
                                            block.stride, block.stride, fields.data());
        add_double_layer(s, block, fields.data(), twofold.data(), control_count_);
        gather_near(s, block, near);
        for (std::size_t k = 0; k < near.points.size(); ++k)
            place[static_cast<std::size_t>(near.points[k])] = static_cast<int>(k);
        for (int t = begin; t < end; ++t) {
            linear.setZero();
            for (int p = 0, i = (t - begin) * points; p < panels; ++p)
                for (int q = 0; q < 3; ++q, ++i) {
                    const HarmonicPattern::Panel& panel = pattern_.panels[static_cast<std::size_t>(p)];
                    const int k = place[static_cast<std::size_t>(i)];
                    for (int c = 0; c < 3; ++c) {
                        const double factor = panel.area * rule(q, c);
                        if (k < 0) {
                            for (int j = 0; j < 3; ++j)
                                linear(panel.corner[c], j) +=
                                    factor * fields[static_cast<std::size_t>((4 + j) * block.stride + i)];
                            continue;
                        }
                        double* row = system.row(t * n + panel.corner[c]) + s * n;
                        const double* single = near.single.data() + k * near.width;
                        for (int j = 0; j < n; ++j)
                            row[j] += factor * single[j];
                    }
                }
            for (int i = 0; i < n; ++i) {
                double* row = system.row(t * n + i) + s * n;
                for (int j = 0; j < n; ++j)
                    for (int c = 0; c < 3; ++c)
                        row[j] += linear(i, c) * pattern_.to_linear(c, j);
            }
        }
        for (int i : near.points)
            place[static_cast<std::size_t>(i)] = -1;
    }
    for (int t = begin; t < end; ++t)
        for (int p = 0, i = (t - begin) * points; p < panels; ++p)
            for (int q = 0; q < 3; ++q, ++i) {
                const HarmonicPattern::Panel& panel = pattern_.panels[static_cast<std::size_t>(p)];
                for (int c = 0; c < 3; ++c) {
                    double* right = system.right_side(t * n + panel.corner[c]);
                    const double* row = twofold.data() + static_cast<std::ptrdiff_t>(i) * control_count_;
                    const double factor = panel.area * rule(q, c);
                    for (int v = 0; v < control_count_; ++v)
                        right[v] -= factor * row[v];
                }
            }
}

void HarmonicBoundary::check(const Cage& cage, const DenseSystem& system,
                             const std::vector<double>& diagonal) const
{
    std::vector<int> bad;
    const std::vector<int>& faces = cage.rest().triangle_faces();
    const int n = pattern_.unknowns;
    for (int i = 0; i < system.size(); ++i) {
        const double pivot = system.pivot_sizes()[static_cast<std::size_t>(i)];
        const double* row = system.solution(i);
        const bool finite = std::all_of(row, row + control_count_, [](double x) { return std::isfinite(x); });
        if (pivot > least_pivot * diagonal[static_cast<std::size_t>(i)] && finite)
            continue;
        const int t = i / n;
        if (bad.empty() || finite) // after a pivot of zero nothing is finite, so only the first is named then
            bad.push_back(cage.given_face(faces[static_cast<std::size_t>(t)]));
        // The faces that it touches are named, too.
        for (std::size_t s = 0; s < middles_.size(); ++s)
            if (static_cast<int>(s) != t && holds(triangles_[s].face, middles_[static_cast<std::size_t>(t)]))
                bad.push_back(cage.given_face(faces[s]));
    }
    std::sort(bad.begin(), bad.end());
    bad.erase(std::unique(bad.begin(), bad.end()), bad.end());
    if (!bad.empty())
        throw InvalidMesh("faces " + list_some(bad) +
                              " of the cage touch or cross others, so that its inside has no meaning there",
                          Error::Element::face, bad);
}

void HarmonicBoundary::keep(const DenseSystem& system)
{
    const int n = pattern_.unknowns, count = static_cast<int>(triangles_.size());
    RowMatrix far(3 * far_group, control_count_);
    for (int first = 0; first < count; first += far_group) {
        const int size = std::min(far_group, count - first);
        for (int t = first; t < first + size; ++t) {
            const Eigen::Map<const RowMatrix, 0, Eigen::OuterStride<>> flux(
                system.solution(t * n), n, control_count_,
                Eigen::OuterStride<>(static_cast<Eigen::Index>(system.stride())));
            far.middleRows(3 * (t - first), 3) = pattern_.to_linear * flux;
            if (n > 3)
                flux_.emplace_back(system.solution(t * n), n, control_count_, system.stride());
        }
        far_flux_.emplace_back(far.data(), 3 * size, control_count_,
                               static_cast<std::size_t>(control_count_));
    }
}

/// Adds the weights to rows (block.count, stride).
void HarmonicBoundary::evaluate(const Block& block, double* rows, int stride) const
{
    AlignedVector<double> fields(static_cast<std::size_t>(7 * block.stride));
    AlignedVector<double> far(static_cast<std::size_t>(block.count * 3 * far_group));
    Near near;
    const int count = static_cast<int>(triangles_.size());
    for (int first = 0; first < count; first += far_group) {
        const int width = 3 * std::min(far_group, count - first);
        for (int t = first; t < std::min(count, first + far_group); ++t) {
            widest_kernels<LayerKernels>().both(triangles_[static_cast<std::size_t>(t)], block.xyz.data(),
                                                block.stride, block.stride, fields.data());
            add_double_layer(t, block, fields.data(), rows, stride);
            double* column = far.data() + 3 * (t - first);
            for (int i = 0; i < block.count; ++i)
                for (int k = 0; k < 3; ++k)
                    column[i * width + k] = fields[static_cast<std::size_t>((4 + k) * block.stride + i)];
            gather_near(t, block, near);
            if (near.points.empty())
                continue;
            for (int i : near.points)
                for (int k = 0; k < 3; ++k)
                    column[i * width + k] = 0.0;
            flux_[static_cast<std::size_t>(t)].multiply_add(near.single.data(), near.width,
                                                            static_cast<int>(near.points.size()), rows,
                                                            stride, near.points.data());
        }
        far_flux_[static_cast<std::size_t>(first / far_group)].multiply_add(far.data(), width, block.count,
                                                                            rows, stride);
    }
}

void HarmonicBoundary::evaluate(PointsView points, RowMatrix& weights, std::vector<double>& winding) const
{
    Block block(static_cast<int>(points.rows()));
    for (int i = 0; i < block.count; ++i)
        block.set(i, (points.row(i).transpose() - centre_) / size_);
    block.fill();
    const int stride = padded(control_count_, strip_width);
    AlignedVector<double> rows(static_cast<std::size_t>(block.count) * static_cast<std::size_t>(stride));
    evaluate(block, rows.data(), stride);
    weights = RowMatrix::Map(rows.data(), block.count, stride).leftCols(control_count_);

    // The flux of a constant is zero, so the sum of the weights is the solid angle of the cage, divided by 4
    // pi.
    winding.resize(static_cast<std::size_t>(block.count));
    for (int i = 0; i < block.count; ++i)
        winding[static_cast<std::size_t>(i)] = weights.row(i).sum();
}

void HarmonicBoundary::measure_residual(const Progress& progress)
{
    progress.tick(0.9, "measuring the residual");
    const int count = 4 * static_cast<int>(triangles_.size());
    const int chunks = (count + block_points - 1) / block_points;
    std::vector<double> squares(static_cast<std::size_t>(chunks)), largest(squares);
    parallel_chunks(count, block_points, [&](int begin, int end) {
        Block block(end - begin);
        const int stride = padded(control_count_, strip_width);
        RowMatrix rows = RowMatrix::Zero(block.count, stride);
        for (int i = begin; i < end; ++i) {
            const Vector3 hats = i % 4 == 3 ? Vector3(Vector3::Constant(1.0 / 3.0))
                                            : Vector3(Vector3::Constant(.05) + .85 * Vector3::Unit(i % 4));
            block.set(i - begin, inside_point(i / 4, hats));
            data_[static_cast<std::size_t>(i / 4)].add(hats, -1.0, rows.row(i - begin).data());
        }
        block.fill();
        evaluate(block, rows.data(), stride);
        squares[static_cast<std::size_t>(begin / block_points)] = rows.squaredNorm();
        largest[static_cast<std::size_t>(begin / block_points)] = rows.cwiseAbs().maxCoeff();
    });
    for (int k = 0; k < chunks; ++k) {
        residual_rms_ += squares[static_cast<std::size_t>(k)] / count;
        residual_max_ = std::max(residual_max_, largest[static_cast<std::size_t>(k)]);
    }
    residual_rms_ = std::sqrt(residual_rms_);
}

} // namespace sinew

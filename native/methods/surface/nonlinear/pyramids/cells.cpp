// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/pyramids/cells.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/mesh/components.h"

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

/// The density at which tips and sides have comparable weights: that of a part of this many vertices.
constexpr double reference_vertices = 1000.0;
/// The area of a vertex among equilateral triangles, in squares of their edges.
constexpr double vertex_area = 0.866;
/// At a crease, k_i |d_i|^2 is at most this many times c_i sum_j |e_ij|^2. Without the bound, creases would
/// become stiffer with each subdivision, and rotations would hardly pass them.
constexpr double most_crease = 2.0;
/// The smallest ring that is taken as it is, in shares of the mean square of all edges.
constexpr double least_ring = 1e-3;

/// That of each soft constraint, in units of its vertex's own entry in the Hessian.
std::vector<double> pull_stiffness(const Rings& rings, const PyramidStiffness& stiffness,
                                   const std::vector<SoftConstraint>& soft)
{
    std::vector<double> found;
    for (const SoftConstraint& pull : soft) {
        double diagonal = stiffness.tips[pull.vertex];
        for (int a = rings.offsets()[pull.vertex]; a < rings.offsets()[pull.vertex + 1]; ++a)
            diagonal += stiffness.sides[pull.vertex] + stiffness.sides[rings.neighbours()[a]];
        found.push_back(pull.stiffness() * diagonal);
    }
    return found;
}

} // namespace

PyramidStiffness::PyramidStiffness(const SurfaceMesh& mesh, const Rings& rings, const Rings::Weights& weights,
                                   double side)
    : tips(rings.size(), 1.0), sides(rings.size(), 0.0)
{
    const Components parts = connected_components(mesh);
    std::vector<double> areas(parts.count, 0.0);
    for (const Triangle& t : mesh.triangles())
        areas[parts.labels[t[0]]] +=
            0.5 * (mesh.point(t[1]) - mesh.point(t[0])).cross(mesh.point(t[2]) - mesh.point(t[0])).norm();
    std::vector<double> squares(rings.size(), 0.0), depths(rings.size(), 0.0);
    std::vector<double> sums(parts.count, 0.0);
    std::vector<int> counts(parts.count, 0);
    for (int i = 0; i < rings.size(); ++i) {
        if (rings.valence(i) == 0)
            continue;
        Vector3 tip = Vector3::Zero();
        for (int a = rings.offsets()[i]; a < rings.offsets()[i + 1]; ++a) {
            const Vector3 e = mesh.point(rings.neighbours()[a]) - mesh.point(i);
            tip -= weights.shares[a] * e;
            squares[i] += e.squaredNorm() / rings.valence(i);
        }
        depths[i] = tip.squaredNorm();
        sides[i] = side / rings.valence(i);
        sums[parts.labels[i]] += squares[i];
        ++counts[parts.labels[i]];
    }
    for (int i = 0; i < rings.size(); ++i) {
        const int part = parts.labels[i];
        if (!(sums[part] > 0))
            continue;
        const double square = std::max(squares[i], least_ring * sums[part] / counts[part]);
        const double wanted =
            areas[part] > 0 ? areas[part] / (reference_vertices * vertex_area * square) : 1.0;
        const double crease = most_crease * side * square;
        tips[i] = wanted * depths[i] > crease ? crease / depths[i] : wanted;
    }
    // The bending stiffness 1/16 k l^4 over the stretching stiffness, both per vertex, is half of t^2.
    const double area = *std::ranges::max_element(areas);
    smoothing = 1.0 / 16.0 / side * std::max(area, 1e-280) / (reference_vertices * vertex_area);
}

PyramidCells::PyramidCells(const Rings& rings, const std::vector<double>& shares,
                           const PyramidStiffness& stiffness, const std::vector<bool>& moving,
                           const std::vector<SoftConstraint>& soft)
{
    const std::vector<double> pulls = pull_stiffness(rings, stiffness, soft);
    factorize(rings, shares, stiffness, moving, soft, pulls);
    std::vector<int> places(rings.size(), -1);
    for (int p = 0; p < moving_; ++p)
        places[order_[p]] = p;
    for (int p = 0; p < moving_; ++p) // the others beside moving points
        for (int a = rings.offsets()[order_[p]]; a < rings.offsets()[order_[p] + 1]; ++a)
            if (int& place = places[rings.neighbours()[a]]; place < 0) {
                place = static_cast<int>(order_.size());
                order_.push_back(rings.neighbours()[a]);
            }
    const int cells = static_cast<int>(order_.size());
    for (int i = 0; i < rings.size(); ++i)
        if (places[i] < 0) {
            places[i] = static_cast<int>(order_.size());
            order_.push_back(i);
        }
    for (int p = 0; p < cells; ++p) {
        const int i = order_[p];
        for (int a = rings.offsets()[i]; a < rings.offsets()[i + 1]; ++a) {
            const int j = rings.neighbours()[a];
            ends_.push_back(places[j]);
            shares_.push_back(shares[a]);
        }
        offsets_.push_back(static_cast<int>(ends_.size()));
        sides_.push_back(stiffness.sides[i]);
        stiffness_.push_back(stiffness.tips[i]);
    }
    backs_.assign(ends_.size(), -1);
    parallel_for(cells, [&](int p) {
        for (int a = offsets_[p]; a < offsets_[p + 1]; ++a) {
            const int j = order_[ends_[a]];
            const auto first = rings.neighbours().begin() + rings.offsets()[j],
                       last = rings.neighbours().begin() + rings.offsets()[j + 1];
            if (ends_[a] < cells)
                backs_[a] =
                    offsets_[ends_[a]] + static_cast<int>(std::lower_bound(first, last, order_[p]) - first);
        }
    });
    for (std::size_t k = 0; k < soft.size(); ++k)
        pulls_.push_back({places[soft[k].vertex], pulls[k]});
}

void PyramidCells::factorize(const Rings& rings, const std::vector<double>& shares,
                             const PyramidStiffness& stiffness, const std::vector<bool>& moving,
                             const std::vector<SoftConstraint>& soft, const std::vector<double>& pulls)
{
    std::vector<int> place(rings.size(), -1), points;
    for (int i = 0; i < rings.size(); ++i)
        if (moving[i]) {
            place[i] = moving_++;
            points.push_back(i);
        }
    std::vector<Eigen::Triplet<double>> rows, sides;
    for (int i = 0; i < rings.size(); ++i) {
        const double root = std::sqrt(stiffness.tips[i]);
        if (moving[i] && rings.valence(i) > 0)
            rows.emplace_back(i, place[i], root);
        for (int a = rings.offsets()[i]; a < rings.offsets()[i + 1]; ++a) {
            const int j = rings.neighbours()[a];
            const double c = stiffness.sides[i] + stiffness.sides[j];
            if (moving[j])
                rows.emplace_back(i, place[j], -root * shares[a]);
            if (!moving[i])
                continue;
            sides.emplace_back(place[i], place[i], c);
            if (moving[j])
                sides.emplace_back(place[i], place[j], -c);
        }
    }
    for (std::size_t k = 0; k < soft.size(); ++k)
        sides.emplace_back(place[soft[k].vertex], place[soft[k].vertex], pulls[k]);
    SparseMatrix D(rings.size(), moving_), A(moving_, moving_);
    D.setFromTriplets(rows.begin(), rows.end());
    A.setFromTriplets(sides.begin(), sides.end());
    A += SparseMatrix(D.transpose() * D);
    try {
        factor_.factorize(A);
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        if (failure.elements().empty())
            throw;
        throw FactorizationFailed(failure.what(), Error::Element::vertex,
                                  {points[failure.elements().front()]});
    }
    std::vector<int> names(moving_);
    for (int p = 0; p < moving_; ++p) {
        names[factor_.order()[p]] = p;
        order_.push_back(points[factor_.order()[p]]);
    }
    factor_.rename(names);
}

PyramidView PyramidCells::view() const
{
    return {.offsets = offsets_.data(),
            .ends = ends_.data(),
            .backs = backs_.data(),
            .shares = shares_.data(),
            .sides = sides_.data(),
            .stiffness = stiffness_.data(),
            .edges = nullptr,
            .tips = nullptr,
            .points = nullptr};
}

void PyramidCells::keep(const PointsView& points, PyramidShape& shape) const
{
    shape.edges.resize(3 * ends_.size() + 1);
    shape.tips.resize(3 * static_cast<std::size_t>(cell_count()) + 1);
    parallel_for(cell_count(), [&](int p) {
        Vector3 tip = Vector3::Zero();
        for (int a = offsets_[p]; a < offsets_[p + 1]; ++a) {
            const Vector3 e = (points.row(order_[ends_[a]]) - points.row(order_[p])).transpose();
            Eigen::Map<Vector3>(shape.edges.data() + 3 * static_cast<std::size_t>(a)) = e;
            tip -= shares_[a] * e;
        }
        Eigen::Map<Vector3>(shape.tips.data() + 3 * static_cast<std::size_t>(p)) = tip;
    });
}

double PyramidCells::size(const PyramidShape& shape, int cell) const
{
    double edges = 0.0;
    for (std::size_t k = 3 * static_cast<std::size_t>(offsets_[cell]);
         k < 3 * static_cast<std::size_t>(offsets_[cell + 1]); ++k)
        edges += shape.edges[k] * shape.edges[k];
    const Eigen::Map<const Vector3> tip(shape.tips.data() + 3 * static_cast<std::size_t>(cell));
    return sides_[cell] * edges + stiffness_[cell] * tip.squaredNorm();
}

} // namespace sinew

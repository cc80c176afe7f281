// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/surface/nonlinear/arap/energy.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/operators/rotation_fit.h"

#include <algorithm>
#include <array>
#include <numeric>
#include <tuple>
#include <utility>

namespace sinew {

namespace {

/// A cell whose edges lie on one line leaves its turn about that line open. This share of the
/// rotation it had closes it; at the minimum, where rotations rest, it changes nothing.
constexpr double tie = 1e-8;

constexpr int entries = 9; ///< numbers of a rotation
using Packed = Eigen::Matrix<double, 3, 3>;
constexpr std::size_t chunk_numbers = arap_columns * (arap_chunk + 1); ///< of a chunk's covariances

/// Places along a curve that fills the bounding box: G. M. Morton, 1966.
std::vector<std::uint64_t> morton_codes(const Points& points)
{
    constexpr int bits = 21;
    const Eigen::RowVector3d low = points.colwise().minCoeff();
    const double extent = std::max((points.colwise().maxCoeff() - low).maxCoeff(), 1e-300);
    std::vector<std::uint64_t> codes(points.rows(), 0);
    for (Eigen::Index i = 0; i < points.rows(); ++i)
        for (int axis = 0; axis < 3; ++axis) {
            const auto cell =
                static_cast<std::uint64_t>((points(i, axis) - low[axis]) / extent * ((1 << bits) - 1));
            for (int bit = 0; bit < bits; ++bit)
                codes[i] |= (cell >> bit & 1) << (3 * bit + axis);
        }
    return codes;
}

/// Three numbers a row, and one more that may be read.
void pack(const PointsView& points, std::vector<double>& packed)
{
    packed.resize(points.size() + 1);
    parallel_for(static_cast<int>(points.rows()), [&](int i) {
        for (int k = 0; k < 3; ++k)
            packed[3 * static_cast<std::size_t>(i) + k] = points(i, k);
    });
}

} // namespace

void ArapGraph::set_metric()
{
    metric.assign(weights.size(), 0.0);
    if (!rims) {
        for (int i = 0; i < size; ++i)
            for (int a = offsets[i]; a < offsets[i + 1]; ++a)
                metric[a] = weights[a] * edge_rigidity(i, neighbours[a]);
        return;
    }
    const auto add = [&](int i, int j, double value) {
        const auto first = neighbours.begin() + offsets[i];
        const auto last = neighbours.begin() + offsets[i + 1];
        if (i != j) // a face may name a vertex twice
            metric[std::lower_bound(first, last, j) - neighbours.begin()] += value;
    };
    for (const ArapTriangle& t : triangles)
        for (int k = 0; k < 3; ++k) {
            const int i = t.corner[(k + 1) % 3], j = t.corner[(k + 2) % 3];
            const double mean = (rigidity[i] + rigidity[j] + rigidity[t.corner[k]]) / 3.0;
            add(i, j, mean * t.across[k]);
            add(j, i, mean * t.across[k]);
        }
}

void ArapGraph::factorize(const Points& rest)
{
    place.assign(size, -1);
    free_nodes.clear();
    for (int i = 0; i < size; ++i)
        if (hard[i] < 0 && !idle[i]) {
            place[i] = static_cast<int>(free_nodes.size());
            free_nodes.push_back(i);
        }

    std::vector<Eigen::Triplet<double>> L, M;
    std::vector<double> moment(size, 0.0); // of each cell, 2/3 sum w |e|^2
    const auto square = [&](int i, int j) { return (rest.row(i) - rest.row(j)).squaredNorm(); };
    for (int i = 0; i < size; ++i) {
        for (int a = offsets[i]; a < offsets[i + 1]; ++a) {
            const int j = neighbours[a];
            if (place[i] >= 0) {
                L.emplace_back(place[i], place[i], metric[a]);
                if (place[j] >= 0)
                    L.emplace_back(place[i], place[j], -metric[a]);
            }
            if (smoothing > 0) {
                M.emplace_back(i, j, -4 * smoothing * weights[a] * edge_rigidity(i, j));
                M.emplace_back(i, i, 4 * smoothing * weights[a] * edge_rigidity(i, j));
            }
            if (!rims)
                moment[i] += 2.0 / 3.0 * rigidity[i] * weights[a] * square(i, j);
        }
    }
    for (const ArapTriangle& t : triangles) {
        double spread = 0.0;
        for (int k = 0; k < 3; ++k)
            spread += t.across[k] * square(t.corner[(k + 1) % 3], t.corner[(k + 2) % 3]);
        for (int i : t.corner)
            moment[i] += 2.0 / 3.0 * rigidity[i] * spread;
    }
    for (const ArapPull& pull : pulls)
        L.emplace_back(place[pull.node], place[pull.node], pull.stiffness);
    SparseMatrix matrix(free_nodes.size(), free_nodes.size());
    matrix.setFromTriplets(L.begin(), L.end());
    if (!(smoothing > 0)) {
        position_factor.factorize(matrix);
    } else {
        // A node without edges, or of a part shrunk to a point, still needs a pivot.
        const double least = 1e-12 * std::max(1e-280, *std::ranges::max_element(moment));
        for (int i = 0; i < size; ++i)
            M.emplace_back(i, i, moment[i] + least);
        SparseMatrix field(size, size);
        field.setFromTriplets(M.begin(), M.end());
        // What is left of an ordering without the held nodes is one for the free ones.
        const std::vector<int> order = fill_reducing_order(field);
        rotation_factor.factorize(field, order);
        std::vector<int> free_order;
        for (int i : order)
            if (place[i] >= 0)
                free_order.push_back(place[i]);
        position_factor.factorize(matrix, free_order);
    }
}

double ArapGraph::scale(const PointsView& base) const
{
    return parallel_sum(size, [&](int i) {
        double sum = 0.0;
        for (int a = offsets[i]; a < offsets[i + 1]; ++a)
            sum += weights[a] * (base.row(i) - base.row(neighbours[a])).squaredNorm();
        return rigidity[i] * sum;
    });
}

std::vector<int> ArapGraph::renumber(const Points& rest)
{
    enum Kind { free, beside_free, held, out };
    std::vector<char> kind(size, held);
    for (int i = 0; i < size; ++i) {
        if (idle[i] || place[i] >= 0) {
            kind[i] = idle[i] ? out : free;
            continue;
        }
        const auto first = neighbours.begin() + offsets[i], last = neighbours.begin() + offsets[i + 1];
        if (smoothing > 0 || std::any_of(first, last, [&](int j) { return place[j] >= 0; }))
            kind[i] = beside_free;
    }
    const std::vector<std::uint64_t> codes = morton_codes(rest);
    std::vector<int> old(size);
    std::iota(old.begin(), old.end(), 0);
    std::ranges::sort(old, {}, [&](int i) { return std::tuple(kind[i], codes[i], i); });
    std::vector<int> renamed(size), free_renamed(free_nodes.size());
    for (int i = 0; i < size; ++i)
        renamed[old[i]] = i;

    ArapGraph sorted;
    sorted.size = size;
    sorted.smoothing = smoothing;
    sorted.rims = rims;
    sorted.rest_scale = scale(view(rest));
    sorted.offsets.assign(1, 0);
    for (int i : old) {
        std::vector<std::pair<int, int>> edges;
        for (int a = offsets[i]; a < offsets[i + 1]; ++a)
            edges.emplace_back(renamed[neighbours[a]], a);
        std::ranges::sort(edges);
        for (const auto& [j, a] : edges) {
            sorted.neighbours.push_back(j);
            sorted.weights.push_back(weights[a]);
            sorted.metric.push_back(metric[a]);
        }
        sorted.offsets.push_back(static_cast<int>(sorted.neighbours.size()));
        sorted.rigidity.push_back(rigidity[i]);
        sorted.hard.push_back(hard[i]);
        sorted.idle.push_back(idle[i]);
        sorted.place.push_back(-1);
        if (place[i] >= 0) {
            sorted.place.back() = free_renamed[place[i]] = static_cast<int>(sorted.free_nodes.size());
            sorted.free_nodes.push_back(renamed[i]);
        }
    }
    sorted.triangles = std::move(triangles);
    for (ArapTriangle& t : sorted.triangles)
        for (int& corner : t.corner)
            corner = renamed[corner];
    sorted.pulls = pulls;
    for (ArapPull& pull : sorted.pulls)
        pull.node = renamed[pull.node];
    sorted.position_factor = std::move(position_factor);
    sorted.position_factor.rename(free_renamed);
    sorted.rotation_factor = std::move(rotation_factor);
    sorted.rotation_factor.rename(renamed);
    const auto until = [&](Kind last) {
        return static_cast<int>(std::ranges::count_if(kind, [&](char k) { return k <= last; }));
    };
    sorted.fill_chunks(until(beside_free), until(held));
    *this = std::move(sorted);
    return old;
}

void ArapGraph::fill_chunks(int moving, int present)
{
    std::vector<int> chunk_of(size, -1);
    for (int begin = 0; begin < present;) {
        const int end = std::min(begin + arap_chunk, begin < moving ? moving : present);
        std::fill(chunk_of.begin() + begin, chunk_of.begin() + end, static_cast<int>(chunks.size()));
        chunks.push_back({begin, end, 0, 0});
        moving_chunks += begin < moving;
        begin = end;
    }

    chunk_edges.reserve(2 * static_cast<std::size_t>(size) + 1);
    for (int i = 0; i < size; ++i)
        for (bool within : {true, false}) {
            chunk_edges.push_back(static_cast<int>(chunk_ends.size()));
            for (int a = offsets[i]; a < offsets[i + 1]; ++a) {
                const int j = neighbours[a];
                if ((chunk_of[i] == chunk_of[j]) == within && (!within || i < j)) {
                    chunk_ends.push_back(j);
                    chunk_weights.push_back(weights[a]);
                }
            }
        }
    chunk_edges.push_back(static_cast<int>(chunk_ends.size()));

    std::vector<std::vector<int>> touching(chunks.size());
    for (int t = 0; t < static_cast<int>(triangles.size()); ++t)
        for (int corner : triangles[t].corner)
            if (const int chunk = chunk_of[corner];
                chunk >= 0 && (touching[chunk].empty() || touching[chunk].back() != t))
                touching[chunk].push_back(t);
    for (std::size_t c = 0; c < chunks.size(); ++c) {
        std::ranges::sort(touching[c], {}, [&](int t) { return std::ranges::min(triangles[t].corner); });
        chunks[c].first_triangle = static_cast<int>(chunk_triangles.size());
        for (int t : touching[c])
            chunk_triangles.push_back(triangles[t]);
        chunks[c].last_triangle = static_cast<int>(chunk_triangles.size());
    }
}

ArapProblem::ArapProblem(const ArapGraph& graph, const PointsView& base, const Points& targets,
                         const Points& pulls, ArapBuffers* buffers)
    : graph_(graph), kernels_(widest_kernels<ArapKernels>()), pulls_(pulls),
      own_buffers_(buffers ? nullptr : std::make_unique<ArapBuffers>()),
      buffers_(buffers ? *buffers : *own_buffers_)
{
    buffers_.energies.resize(graph.chunks.size());
    pack(base, buffers_.base);
    pack(view(targets), buffers_.points);
    std::copy_n(buffers_.base.data(), 3 * static_cast<std::size_t>(graph.free_count()),
                buffers_.points.data());
    view_ = {.edges = graph.chunk_edges.data(),
             .ends = graph.chunk_ends.data(),
             .weights = graph.chunk_weights.data(),
             .triangles = graph.chunk_triangles.data(),
             .rims = graph.rims,
             .rigidity = graph.rigidity.data(),
             .free = graph.free_count(),
             .base = buffers_.base.data(),
             .points = buffers_.points.data(),
             .smoothing = graph.smoothing};
    const int present = graph.chunks.empty() ? 0 : graph.chunks.back().end;
    for (int k = 0; k < (graph.smoothing > 0 ? 3 : 1); ++k) {
        Matrices& rotations = buffers_.rotations[k];
        rotations.resize(entries * static_cast<std::size_t>(graph.size) + 1);
        const int first = k == 0 ? 0 : present; // idle nodes keep theirs in all of them
        parallel_for(graph.size - first, [&](int i) {
            Eigen::Map<Packed>(rotations.data() + entries * static_cast<std::size_t>(first + i))
                .setIdentity();
        });
    }
}

/// Rotations and energy of the cells that no free node belongs to, once.
void ArapProblem::settle_the_others()
{
    if (settled_)
        return;
    settled_ = true;
    const int count = static_cast<int>(graph_.chunks.size()) - graph_.moving_chunks;
    parallel_chunks(count, 1, [&](int c, int) {
        const ArapChunk& chunk = graph_.chunks[graph_.moving_chunks + c];
        std::array<double, chunk_numbers> S;
        kernels_.covariances(view_, chunk, S.data());
        for (int k = 0; k < 2; ++k) // from anywhere, and from there: the tie changes nothing any longer
            fit(chunk, S.data(), buffers_.rotations[current_], tie, buffers_.rotations[current_]);
    });
    parallel_chunks(count, 1, [&](int c, int) {
        const ArapChunk& chunk = graph_.chunks[graph_.moving_chunks + c];
        buffers_.energies[c] = kernels_.energy(view_, chunk, buffers_.rotations[current_].data(), nullptr);
    });
    energy_of_others_ = std::accumulate(buffers_.energies.begin(), buffers_.energies.begin() + count, 0.0);
}

Matrix3 ArapProblem::rotation(int i) const
{
    return Eigen::Map<const Packed>(buffers_.rotations[current_].data() +
                                    entries * static_cast<std::size_t>(i));
}

void ArapProblem::set_rotation(int i, const Matrix3& R)
{
    Eigen::Map<Packed>(buffers_.rotations[current_].data() + entries * static_cast<std::size_t>(i)) = R;
}

void ArapProblem::move_to(const Points& x)
{
    parallel_chunks(graph_.free_count(), 16384, [&](int begin, int end) {
        std::copy(x.data() + 3 * static_cast<std::size_t>(begin),
                  x.data() + 3 * static_cast<std::size_t>(end),
                  buffers_.points.data() + 3 * static_cast<std::size_t>(begin));
    });
}

PointsView ArapProblem::place(const Points& x)
{
    move_to(x);
    return PointsView(buffers_.points.data(), graph_.size, 3);
}

int ArapProblem::spare(int used) const
{
    int set = 0;
    while (set == kept_ || set == used)
        ++set;
    return set;
}

void ArapProblem::for_each_moving(const std::function<void(const ArapChunk&)>& body) const
{
    parallel_chunks(graph_.moving_chunks, 1, [&](int c, int) { body(graph_.chunks[c]); });
}

void ArapProblem::fit(const ArapChunk& chunk, const double* S, const Matrices& before, double tie,
                      Matrices& after) const
{
    bool safe[arap_chunk];
    const std::size_t first = entries * static_cast<std::size_t>(chunk.begin);
    const int count = chunk.end - chunk.begin;
    kernels_.fit(S, before.data() + first, tie, count, after.data() + first, safe);
    for (int i = 0; i < count; ++i) {
        if (safe[i])
            continue;
        const Matrix3 own = arap_covariance(S, i);
        const Matrix3 last =
            Eigen::Map<const Packed>(before.data() + first + entries * static_cast<std::size_t>(i));
        Eigen::Map<Packed>(after.data() + first + entries * static_cast<std::size_t>(i)) =
            fit_rotation_svd(own + tie * own.norm() * last);
    }
}

double* ArapProblem::covariances_of(const ArapChunk& chunk) const
{
    return buffers_.covariances.data() + (&chunk - graph_.chunks.data()) * chunk_numbers;
}

/// One linearised step of all rotations together: (moment + 4 alpha A L) omega = torque. The
/// cell-by-cell fit alone passes a turn on by one ring an iteration.
void ArapProblem::turn_rotation_field()
{
    const Matrices& before = buffers_.rotations[current_];
    Points& torque = buffers_.torque;
    if (torque.rows() != graph_.size)
        torque.setZero(graph_.size, 3); // that of idle nodes stays
    for_each_moving([&](const ArapChunk& chunk) {
        double* const S = covariances_of(chunk);
        kernels_.covariances(view_, chunk, S);
        kernels_.torques(view_, chunk, S, before.data(),
                         torque.data() + 3 * static_cast<std::size_t>(chunk.begin));
    });
    graph_.rotation_factor.solve(torque, torque);
    const int turned = current_ == kept_ ? spare(current_) : current_;
    for_each_moving([&](const ArapChunk& chunk) {
        const std::size_t first = entries * static_cast<std::size_t>(chunk.begin);
        kernels_.turn(torque.data() + 3 * static_cast<std::size_t>(chunk.begin), before.data() + first,
                      chunk.end - chunk.begin, buffers_.rotations[turned].data() + first);
    });
    current_ = turned;
}

void ArapProblem::fit_rotations(const Points& x)
{
    move_to(x);
    settle_the_others();
    stale_ = false;
    const Matrices& before = buffers_.rotations[current_];
    const int next = current_ == kept_ ? spare(current_) : current_;
    for_each_moving([&](const ArapChunk& chunk) {
        std::array<double, chunk_numbers> S;
        kernels_.covariances(view_, chunk, S.data());
        fit(chunk, S.data(), before, tie, buffers_.rotations[next]);
    });
    current_ = next;
}

double ArapProblem::energy_and_gradient(Points& gradient) const
{
    gradient.resize(graph_.free_count(), 3);
    std::vector<double>& energies = buffers_.energies;
    parallel_chunks(graph_.moving_chunks, 1, [&](int c, int) {
        energies[c] =
            kernels_.energy(view_, graph_.chunks[c], buffers_.rotations[current_].data(), gradient.data());
    });
    double energy =
        std::accumulate(energies.begin(), energies.begin() + graph_.moving_chunks, energy_of_others_) /
        graph_.energy_factor();

    for (std::size_t k = 0; k < graph_.pulls.size(); ++k) {
        const ArapPull& pull = graph_.pulls[k];
        const Eigen::Map<const Eigen::RowVector3d> at(buffers_.points.data() +
                                                      3 * static_cast<std::size_t>(pull.node));
        const Eigen::RowVector3d gap = at - pulls_.row(k);
        energy += 0.5 * pull.stiffness * gap.squaredNorm();
        gradient.row(pull.node) += pull.stiffness * gap;
    }
    return energy;
}

double ArapProblem::evaluate(const Points& x, Points& gradient)
{
    if (graph_.smoothing > 0) {
        move_to(x);
        settle_the_others();
        buffers_.covariances.resize(graph_.moving_chunks * chunk_numbers);
        turn_rotation_field();
        const Matrices& before = buffers_.rotations[current_];
        const int next = spare(current_);
        for_each_moving([&](const ArapChunk& chunk) {
            double* const S = covariances_of(chunk);
            kernels_.add_neighbours(view_, chunk, before.data(), S);
            fit(chunk, S, before, 0.0, buffers_.rotations[next]);
        });
        current_ = next;
    } else {
        fit_rotations(x);
    }
    return energy_and_gradient(gradient);
}

void ArapProblem::precondition(const Points& gradient, Points& z) const
{
    graph_.position_factor.solve(gradient, z);
}

void ArapProblem::positions_for_rotations(Points& x)
{
    Points& gradient = buffers_.gradient;
    x = PointsView(buffers_.points.data(), graph_.free_count(), 3);
    for (int k = 0; k < 2; ++k) { // in single precision, each leaves a millionth
        energy_and_gradient(gradient);
        graph_.position_factor.solve(gradient, gradient);
        x -= gradient;
        move_to(x);
    }
}

} // namespace sinew

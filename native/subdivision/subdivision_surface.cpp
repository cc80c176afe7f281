// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/subdivision/subdivision_surface.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/subdivision/limit_masks.h"

#include <opensubdiv/far/error.h>
#include <opensubdiv/far/primvarRefiner.h>
#include <opensubdiv/far/stencilTable.h>
#include <opensubdiv/far/stencilTableFactory.h>
#include <opensubdiv/far/topologyDescriptor.h>
#include <opensubdiv/far/topologyRefinerFactory.h>

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <memory>
#include <numeric>
#include <string>

namespace sinew {

namespace {

namespace Far = OpenSubdiv::Far;
namespace Sdc = OpenSubdiv::Sdc;
using Refiner = Far::TopologyRefiner;

constexpr int highest_level = 10;
constexpr int highest_valence = 65535; // OpenSubdiv counts the neighbours of an element in 16 bits

/// The elements k for which bad(k) is true.
template <class Bad>
std::vector<int> where(int count, Bad&& bad)
{
    std::vector<int> found;
    for (int k = 0; k < count; ++k)
        if (bad(k))
            found.push_back(k);
    return found;
}

void check_sharpness(const std::vector<double>& sharpness, std::size_t count, const std::string& name)
{
    if (sharpness.size() != count)
        throw InvalidOption(name + ": " + std::to_string(sharpness.size()) + " sharpnesses for " +
                            std::to_string(count) + " elements");
    const auto bad = where(static_cast<int>(count), [&](int k) { return !(sharpness[k] >= 0); });
    if (!bad.empty())
        throw InvalidOption(name + ": a sharpness below 0 or NaN at entries " + list_some(bad));
}

void check(const SurfaceMesh& mesh, const SubdivisionOptions& options,
           const std::vector<std::array<int, 2>>& edges)
{
    if (options.level < 0 || options.level > highest_level)
        throw InvalidOption("level: " + std::to_string(options.level) + " is not in 0 to " +
                            std::to_string(highest_level));

    const int faces = mesh.face_count();
    if (options.scheme == SubdivisionScheme::loop)
        if (const auto bad = where(faces, [&](int f) { return mesh.face(f).size() != 3; }); !bad.empty())
            throw InvalidMesh("faces: loop subdivides triangles alone; other faces are " + list_some(bad),
                              Error::Element::face, bad);
    std::vector<int> sorted;
    const auto repeats = where(faces, [&](int f) {
        sorted.assign(mesh.face(f).begin(), mesh.face(f).end());
        std::ranges::sort(sorted);
        return std::ranges::adjacent_find(sorted) != sorted.end();
    });
    if (!repeats.empty())
        throw InvalidMesh("faces: a vertex comes twice in faces " + list_some(repeats), Error::Element::face,
                          repeats);
    const auto large = where(faces, [&](int f) { return mesh.face(f).size() > highest_valence; });
    if (!large.empty())
        throw InvalidMesh("faces: more than 65535 corners in faces " + list_some(large), Error::Element::face,
                          large);
    std::vector<int> valence(mesh.vertex_count(), 0);
    for (const auto& [a, b] : edges) {
        ++valence[a];
        ++valence[b];
    }
    const auto hubs = where(mesh.vertex_count(), [&](int v) { return valence[v] > highest_valence; });
    if (!hubs.empty())
        throw InvalidMesh("faces: more than 65535 edges at vertices " + list_some(hubs),
                          Error::Element::vertex, hubs);

    check_sharpness(options.crease_sharpness, options.crease_edges.size(), "creases");
    std::vector<int> strays;
    for (const auto& [a, b] : options.crease_edges)
        if (!std::ranges::binary_search(edges, std::array{std::min(a, b), std::max(a, b)}))
            strays.insert(strays.end(), {a, b});
    if (!strays.empty())
        throw InvalidOption("creases: no edge joins the vertices (in pairs) " + list_some(strays),
                            Error::Element::vertex, strays);
    check_sharpness(options.corner_sharpness, options.corner_vertices.size(), "corners");
    std::vector<int> outside;
    for (int v : options.corner_vertices)
        if (v < 0 || v >= mesh.vertex_count())
            outside.push_back(v);
    if (!outside.empty())
        throw InvalidOption("corners: the mesh has no vertices " + list_some(outside), Error::Element::vertex,
                            outside);

    std::size_t corners = 0;
    for (int f = 0; f < faces; ++f)
        corners += mesh.face(f).size();
    if (!options.face_varying.empty() && options.face_varying.size() != corners)
        throw InvalidOption("face_varying: " + std::to_string(options.face_varying.size()) + " indices for " +
                            std::to_string(corners) + " face corners");
    if (std::ranges::any_of(options.face_varying, [](int value) { return value < 0; }))
        throw InvalidOption("face_varying: an index is below 0");
}

/// \throw OutOfMemory  before anything is built.
void require_room(const SurfaceMesh& mesh, const SubdivisionOptions& options, std::int64_t edges)
{
    const bool loop = options.scheme == SubdivisionScheme::loop;
    std::int64_t vertices = mesh.vertex_count(), faces = mesh.face_count(), corners = 0,
                 all_vertices = vertices;
    for (int f = 0; f < mesh.face_count(); ++f)
        corners += static_cast<std::int64_t>(mesh.face(f).size());
    for (int level = 0; level < options.level; ++level) {
        vertices += edges + (loop ? 0 : faces);
        edges = 2 * edges + corners; // new edges: three in a triangle, one per corner in a polygon
        faces = loop ? 4 * faces : corners;
        corners = loop ? 3 * faces : 4 * faces;
        all_vertices += vertices;
    }
    // Per refined vertex there are 4 face corners and 4 edge ends, about 250 bytes in OpenSubdiv's tables,
    // and a row of about 18 weights, which the stencil table, the matrix and its copy in floats hold at the
    // same time. The matrix of the limit and its product with the other take as much again.
    const std::int64_t entries = vertices * 18;
    const std::int64_t bytes = 250 * all_vertices + entries * (options.limit ? 60 : 30) + 8 * corners;
    if (corners > std::numeric_limits<int>::max() || entries > std::numeric_limits<int>::max())
        throw OutOfMemory("level: " + std::to_string(options.level) + " gives " + std::to_string(vertices) +
                          " vertices, which take " + in_words(bytes) + " and more than 32 bits to count");
    require_memory(bytes, "the subdivision");
}

/// Keeps OpenSubdiv from printing its complaints. Where it fails, its results show it.
void silence()
{
    static const bool once = [] {
        Far::SetErrorCallback([](Far::ErrorType, const char*) {});
        Far::SetWarningCallback([](const char*) {});
        return true;
    }();
    static_cast<void>(once);
}

Sdc::SchemeType scheme(SubdivisionScheme scheme)
{
    switch (scheme) {
    case SubdivisionScheme::loop:
        return Sdc::SCHEME_LOOP;
    case SubdivisionScheme::bilinear:
        return Sdc::SCHEME_BILINEAR;
    default:
        return Sdc::SCHEME_CATMARK;
    }
}

Sdc::Options sdc_options(const SubdivisionOptions& options)
{
    using O = Sdc::Options;
    O sdc;
    sdc.SetVtxBoundaryInterpolation(options.boundary_smooth == BoundarySmooth::all
                                        ? O::VTX_BOUNDARY_EDGE_ONLY
                                        : O::VTX_BOUNDARY_EDGE_AND_CORNER);
    constexpr O::FVarLinearInterpolation linear[] = {
        O::FVAR_LINEAR_ALL,           O::FVAR_LINEAR_CORNERS_ONLY, O::FVAR_LINEAR_CORNERS_PLUS1,
        O::FVAR_LINEAR_CORNERS_PLUS2, O::FVAR_LINEAR_BOUNDARIES,   O::FVAR_LINEAR_NONE};
    sdc.SetFVarLinearInterpolation(linear[static_cast<int>(options.uv_smooth)]);
    return sdc;
}

std::unique_ptr<Refiner> refined(const SurfaceMesh& mesh, const SubdivisionOptions& options, int depth)
{
    std::vector<int> counts, corners;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto face = mesh.face(f);
        counts.push_back(static_cast<int>(face.size()));
        corners.insert(corners.end(), face.begin(), face.end());
    }
    const std::vector<float> creases(options.crease_sharpness.begin(), options.crease_sharpness.end());
    const std::vector<float> sharp(options.corner_sharpness.begin(), options.corner_sharpness.end());

    Far::TopologyDescriptor topology;
    topology.numVertices = mesh.vertex_count();
    topology.numFaces = mesh.face_count();
    topology.numVertsPerFace = counts.data();
    topology.vertIndicesPerFace = corners.data();
    topology.numCreases = static_cast<int>(creases.size());
    topology.creaseVertexIndexPairs = creases.empty() ? nullptr : options.crease_edges.front().data();
    topology.creaseWeights = creases.data();
    topology.numCorners = static_cast<int>(sharp.size());
    topology.cornerVertexIndices = options.corner_vertices.data();
    topology.cornerWeights = sharp.data();
    Far::TopologyDescriptor::FVarChannel channel;
    if (!options.face_varying.empty()) {
        channel.numValues = *std::ranges::max_element(options.face_varying) + 1;
        channel.valueIndices = options.face_varying.data();
        topology.numFVarChannels = 1;
        topology.fvarChannels = &channel;
    }
    using Factory = Far::TopologyRefinerFactory<Far::TopologyDescriptor>;
    std::unique_ptr<Refiner> refiner(
        Factory::Create(topology, Factory::Options(scheme(options.scheme), sdc_options(options))));
    if (!refiner)
        throw InvalidMesh("faces: OpenSubdiv cannot read this mesh");
    Refiner::UniformOptions uniform(depth);
    uniform.fullTopologyInLastLevel = true; // the limit masks need it
    refiner->RefineUniform(uniform);
    return refiner;
}

/// A compressed matrix with ascending columns, from rows whose entries are in any order.
SparseRows ascending(int columns, const std::vector<int>& sizes, const std::vector<int>& indices,
                     const std::vector<double>& weights)
{
    const int rows = static_cast<int>(sizes.size());
    SparseRows matrix(rows, columns);
    int* const offsets = matrix.outerIndexPtr();
    offsets[0] = 0;
    std::partial_sum(sizes.begin(), sizes.end(), offsets + 1);
    matrix.resizeNonZeros(offsets[rows]);
    parallel_chunks(rows, 4096, [&](int begin, int end) {
        std::vector<std::pair<int, double>> row;
        for (int i = begin; i < end; ++i) {
            row.clear();
            for (int k = offsets[i]; k < offsets[i + 1]; ++k)
                row.emplace_back(indices[k], weights[k]);
            std::ranges::sort(row, {}, &std::pair<int, double>::first);
            for (std::size_t k = 0; k < row.size(); ++k) {
                matrix.innerIndexPtr()[offsets[i] + k] = row[k].first;
                matrix.valuePtr()[offsets[i] + k] = row[k].second;
            }
        }
    });
    return matrix;
}

SparseRows stencils(const Refiner& refiner, int level, int controls, bool face_varying)
{
    if (level == 0) {
        SparseRows identity(controls, controls);
        identity.setIdentity();
        return identity;
    }
    using Factory = Far::StencilTableFactoryReal<double>;
    Factory::Options options;
    options.interpolationMode =
        face_varying ? Factory::INTERPOLATE_FACE_VARYING : Factory::INTERPOLATE_VERTEX;
    options.generateIntermediateLevels = false;
    options.generateOffsets = false;
    options.maxLevel = static_cast<unsigned>(level);
    const std::unique_ptr<const Far::StencilTableReal<double>> table(Factory::Create(refiner, options));
    return ascending(controls, table->GetSizes(), table->GetControlIndices(), table->GetWeights());
}

/// Takes the place of a point where OpenSubdiv forms weighted sums, and records the weights instead.
struct Row
{
    std::vector<std::pair<int, double>> entries;

    void Clear() { entries.clear(); } // NOLINT(readability-identifier-naming)
    void AddWithWeight(int point, double weight) { entries.emplace_back(point, weight); } // NOLINT
};

struct Numbers
{
    int operator[](int point) const { return point; }
};

/// Whether OpenSubdiv's limit mask is not exact for a vertex: sharpness is left there, or a crease that is
/// sharp on all levels ends. Edges of more than two faces are always sharp.
bool needs_own_mask(const Far::TopologyLevel& level, int vertex)
{
    if (level.IsVertexNonManifold(vertex) || level.IsVertexInfSharp(vertex))
        return false;
    bool semi_sharp = level.IsVertexSemiSharp(vertex);
    int endless = 0;
    for (int edge : level.GetVertexEdges(vertex)) {
        semi_sharp |= level.IsEdgeSemiSharp(edge);
        endless += level.IsEdgeInfSharp(edge);
    }
    return semi_sharp || endless == 1;
}

void set_own_mask(const Far::TopologyLevel& level, int vertex, bool triangles, Row& row)
{
    const auto edges = level.GetVertexEdges(vertex), faces = level.GetVertexFaces(vertex);
    const auto places = level.GetVertexFaceLocalIndices(vertex);
    Neighbourhood around{triangles, faces.size(), level.GetVertexSharpness(vertex), {}};
    std::vector<int> points{vertex};
    for (int edge : edges) {
        const auto ends = level.GetEdgeVertices(edge);
        points.push_back(ends[0] == vertex ? ends[1] : ends[0]);
        around.edge_sharpness.push_back(level.GetEdgeSharpness(edge));
    }
    if (!triangles)
        for (int k = 0; k < faces.size(); ++k)
            points.push_back(level.GetFaceVertices(faces[k])[(places[k] + 2) % 4]);
    const std::vector<double> mask = limit_mask(around);
    row.Clear();
    for (std::size_t k = 0; k < mask.size(); ++k)
        if (mask[k] != 0.0)
            row.AddWithWeight(points[k], mask[k]);
}

/// (count, n) the weights of the limits of the first `count` points of the last level.
SparseRows limits(const Refiner& refiner, int count)
{
    std::vector<Row> rows(refiner.GetLevel(refiner.GetMaxLevel()).GetNumVertices());
    const Numbers numbers;
    Far::PrimvarRefinerReal<double>(refiner).Limit(numbers, rows);
    const auto& level = refiner.GetLevel(refiner.GetMaxLevel());
    const Sdc::SchemeType scheme = refiner.GetSchemeType();
    if (scheme != Sdc::SCHEME_BILINEAR)
        parallel_for(
            count,
            [&](int v) {
                if (needs_own_mask(level, v))
                    set_own_mask(level, v, scheme == Sdc::SCHEME_LOOP, rows[v]);
            },
            256);
    std::vector<int> sizes, indices;
    std::vector<double> weights;
    for (int i = 0; i < count; ++i) {
        sizes.push_back(static_cast<int>(rows[i].entries.size()));
        for (const auto& [point, weight] : rows[i].entries) {
            indices.push_back(point);
            weights.push_back(weight);
        }
    }
    return ascending(static_cast<int>(rows.size()), sizes, indices, weights);
}

} // namespace

SubdivisionSurface::SubdivisionSurface(const SurfaceMesh& mesh, const SubdivisionOptions& options)
{
    const auto edges = mesh.edges();
    check(mesh, options, edges);
    require_room(mesh, options, static_cast<std::int64_t>(edges.size()));
    if (mesh.face_count() == 0) { // OpenSubdiv refuses such a mesh
        SparseRows identity(mesh.vertex_count(), mesh.vertex_count());
        identity.setIdentity();
        stencils_ = Stencils(std::move(identity));
        around_offsets_.assign(mesh.vertex_count() + 1, 0);
        return;
    }
    silence();
    // The limit masks are for quads, and only from level 1 on all faces are quads.
    const int depth = std::max(options.level, options.limit ? 1 : 0);
    const std::unique_ptr<Refiner> refiner = refined(mesh, options, depth);

    SparseRows matrix = stencils(*refiner, depth, mesh.vertex_count(), false);
    if (options.limit)
        matrix = SparseRows(limits(*refiner, refiner->GetLevel(options.level).GetNumVertices()) * matrix);
    stencils_ = Stencils(std::move(matrix));

    const auto& last = refiner->GetLevel(options.level);
    const bool varies = !options.face_varying.empty();
    for (int f = 0; f < last.GetNumFaces(); ++f) {
        const auto face = last.GetFaceVertices(f);
        counts_.push_back(face.size());
        corners_.insert(corners_.end(), face.begin(), face.end());
        if (varies) {
            const auto values = last.GetFaceFVarValues(f, 0);
            face_varying_corners_.insert(face_varying_corners_.end(), values.begin(), values.end());
        }
    }
    if (varies)
        face_varying_ = stencils(*refiner, options.level, refiner->GetLevel(0).GetNumFVarValues(0), true);

    find_faces_around();
}

void SubdivisionSurface::find_faces_around()
{
    around_offsets_.assign(vertex_count() + 1, 0);
    for (int v : corners_)
        ++around_offsets_[v + 1];
    std::partial_sum(around_offsets_.begin(), around_offsets_.end(), around_offsets_.begin());
    around_.resize(corners_.size());
    std::vector<int> next(around_offsets_.begin(), around_offsets_.end() - 1);
    for (std::size_t f = 0, c = 0; f < counts_.size(); ++f)
        for (int k = 0; k < counts_[f]; ++k, ++c)
            around_[next[corners_[c]]++] = static_cast<int>(f);
}

SubdivisionSurface SubdivisionSurface::reordered(std::span<const int> order) const
{
    std::vector<int> places(vertex_count(), -1);
    for (std::size_t k = 0; k < order.size(); ++k)
        if (order[k] >= 0 && order[k] < vertex_count())
            places[order[k]] = static_cast<int>(k);
    if (order.size() != places.size() || std::ranges::find(places, -1) != places.end())
        throw InvalidOption("order: each of the " + std::to_string(places.size()) +
                            " vertices has to be named once");
    SubdivisionSurface other = *this;
    const SparseRows& rows = matrix();
    SparseRows moved(rows.rows(), rows.cols());
    int* const offsets = moved.outerIndexPtr();
    offsets[0] = 0;
    for (std::size_t k = 0; k < order.size(); ++k)
        offsets[k + 1] = offsets[k] + static_cast<int>(rows.row(order[k]).nonZeros());
    moved.resizeNonZeros(rows.nonZeros());
    parallel_for(vertex_count(), [&](int k) {
        const int from = rows.outerIndexPtr()[order[k]], count = offsets[k + 1] - offsets[k];
        std::copy_n(rows.innerIndexPtr() + from, count, moved.innerIndexPtr() + offsets[k]);
        std::copy_n(rows.valuePtr() + from, count, moved.valuePtr() + offsets[k]);
    });
    other.stencils_ = Stencils(std::move(moved));
    for (int& corner : other.corners_)
        corner = places[corner];
    other.find_faces_around();
    return other;
}

Points SubdivisionSurface::normals(PointsView refined) const
{
    const int faces = static_cast<int>(counts_.size());
    std::vector<int> first(faces + 1, 0);
    std::partial_sum(counts_.begin(), counts_.end(), first.begin() + 1);
    std::vector<Vector3> areas(faces);
    parallel_for(faces, [&](int f) {
        const Vector3 origin = refined.row(corners_[first[f]]).transpose();
        Vector3 area = Vector3::Zero();
        for (int c = first[f] + 1; c + 1 < first[f + 1]; ++c)
            area += (refined.row(corners_[c]).transpose() - origin)
                        .cross(refined.row(corners_[c + 1]).transpose() - origin);
        areas[f] = area;
    });
    Points normals(vertex_count(), 3);
    parallel_for(vertex_count(), [&](int v) {
        Vector3 sum = Vector3::Zero();
        for (int k = around_offsets_[v]; k < around_offsets_[v + 1]; ++k)
            sum += areas[around_[k]];
        normals.row(v) = sum.normalized().transpose(); // normalized() leaves a zero vector as it is
    });
    return normals;
}

} // namespace sinew

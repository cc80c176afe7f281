// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/lattice/grid/hexahedra_cells.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <map>
#include <set>
#include <utility>

namespace sinew {

namespace {

using Edge = std::pair<int, int>;
using Quad = std::array<int, 4>;

Edge edge(int a, int b) { return {std::min(a, b), std::max(a, b)}; }

Quad sorted(Quad quad)
{
    std::sort(quad.begin(), quad.end());
    return quad;
}

/// The vertices beside `a` and `b` in a quad that has these as an edge: the one next to a, then next to b.
std::array<int, 2> beyond(const Quad& quad, int a, int b)
{
    const int i = static_cast<int>(std::find(quad.begin(), quad.end(), a) - quad.begin());
    return quad[(i + 1) % 4] == b ? std::array{quad[(i + 3) % 4], quad[(i + 2) % 4]}
                                  : std::array{quad[(i + 1) % 4], quad[(i + 2) % 4]};
}

/// The corners of each side of a cell, in order around it.
constexpr int sides[6][4] = {{0, 2, 6, 4}, {1, 3, 7, 5}, {0, 1, 5, 4},
                             {2, 3, 7, 6}, {0, 1, 3, 2}, {4, 5, 7, 6}};
constexpr int edges[12][2] = {{0, 1}, {2, 3}, {4, 5}, {6, 7}, {0, 2}, {1, 3},
                              {4, 6}, {5, 7}, {0, 4}, {1, 5}, {2, 6}, {3, 7}};

} // namespace

std::vector<Hexahedron> find_hexahedra(const SurfaceMesh& mesh)
{
    std::vector<Quad> quads;
    std::map<Edge, std::vector<int>> at;
    std::set<Quad> known;
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto face = mesh.face(f);
        if (face.size() != 4)
            continue;
        const Quad quad{face[0], face[1], face[2], face[3]};
        if (!known.insert(sorted(quad)).second)
            continue;
        for (int k = 0; k < 4; ++k)
            at[edge(quad[k], quad[(k + 1) % 4])].push_back(static_cast<int>(quads.size()));
        quads.push_back(quad);
    }
    std::vector<Hexahedron> cells;
    std::set<Hexahedron> found;
    for (std::size_t f = 0; f < quads.size(); ++f) {
        const auto [a, b, c, d] = quads[f];
        // Four more sides stand on the edges of this one, and the sixth one closes them.
        for (int first : at[edge(a, b)]) {
            if (first == static_cast<int>(f))
                continue;
            const auto [a2, b2] = beyond(quads[static_cast<std::size_t>(first)], a, b);
            const auto other = [&](int v, int w, int v2) {
                for (int q : at[edge(v, w)])
                    if (q != static_cast<int>(f))
                        if (const auto ends = beyond(quads[static_cast<std::size_t>(q)], v, w); ends[0] == v2)
                            return ends[1];
                return -1;
            };
            const int c2 = other(b, c, b2), d2 = c2 < 0 ? -1 : other(c, d, c2);
            if (d2 < 0 || other(d, a, d2) != a2 || !known.contains(sorted({a2, b2, c2, d2})))
                continue;
            Hexahedron cell{a, b, d, c, a2, b2, d2, c2}, key = cell;
            std::sort(key.begin(), key.end());
            if (std::adjacent_find(key.begin(), key.end()) != key.end() || !found.insert(key).second)
                continue;
            // Right-handed, if the middles of opposite sides say so.
            Vector3 axes[3];
            for (int axis = 0; axis < 3; ++axis) {
                axes[axis].setZero();
                for (int k = 0; k < 8; ++k)
                    axes[axis] += (k >> axis & 1 ? 1.0 : -1.0) * mesh.point(cell[k]);
            }
            if (axes[0].cross(axes[1]).dot(axes[2]) < 0.0)
                for (int k = 0; k < 8; k += 2)
                    std::swap(cell[k], cell[k + 1]);
            cells.push_back(cell);
        }
    }
    return cells;
}

RefinedCells refined(const std::vector<Hexahedron>& cells, int vertices)
{
    const int count = static_cast<int>(cells.size());
    std::map<Quad, int> faces;
    std::map<Edge, int> lines;
    std::vector<std::vector<int>> face_cells, line_cells, line_faces;
    std::vector<Quad> face_corners;
    std::vector<Edge> line_ends;
    std::vector<std::array<int, 6>> cell_faces(cells.size());
    std::vector<std::array<int, 12>> cell_lines(cells.size());
    for (int c = 0; c < count; ++c) {
        for (int s = 0; s < 6; ++s) {
            Quad quad;
            for (int k = 0; k < 4; ++k)
                quad[k] = cells[c][sides[s][k]];
            const auto [place, is_new] = faces.try_emplace(sorted(quad), static_cast<int>(faces.size()));
            if (is_new) {
                face_corners.push_back(quad);
                face_cells.emplace_back();
            }
            face_cells[place->second].push_back(c);
            cell_faces[c][s] = place->second;
        }
        for (int e = 0; e < 12; ++e) {
            const Edge ends = edge(cells[c][edges[e][0]], cells[c][edges[e][1]]);
            const auto [place, is_new] = lines.try_emplace(ends, static_cast<int>(lines.size()));
            if (is_new) {
                line_ends.push_back(ends);
                line_cells.emplace_back();
            }
            line_cells[place->second].push_back(c);
            cell_lines[c][e] = place->second;
        }
    }
    const int face_count = static_cast<int>(faces.size()), line_count = static_cast<int>(lines.size());
    line_faces.resize(lines.size());
    std::vector<std::vector<int>> vertex_cells(vertices), vertex_faces(vertices), vertex_lines(vertices);
    for (int f = 0; f < face_count; ++f)
        for (int k = 0; k < 4; ++k) {
            line_faces[lines.at(edge(face_corners[f][k], face_corners[f][(k + 1) % 4]))].push_back(f);
            vertex_faces[face_corners[f][k]].push_back(f);
        }
    for (int e = 0; e < line_count; ++e)
        for (int v : {line_ends[e].first, line_ends[e].second})
            vertex_lines[v].push_back(e);
    for (int c = 0; c < count; ++c)
        for (int v : cells[c])
            vertex_cells[v].push_back(c);
    const auto on_border = [&](int f) { return face_cells[f].size() == 1; };

    std::vector<Eigen::Triplet<double>> entries;
    const auto add_cell = [&](int row, int c, double w) {
        for (int v : cells[c])
            entries.emplace_back(row, v, w / 8.0);
    };
    const auto add_face = [&](int row, int f, double w) {
        for (int v : face_corners[f])
            entries.emplace_back(row, v, w / 4.0);
    };
    const auto add_line = [&](int row, int e, double w) {
        entries.emplace_back(row, line_ends[e].first, w / 2.0);
        entries.emplace_back(row, line_ends[e].second, w / 2.0);
    };
    // Vertices, then the points of lines, of faces and of cells.
    for (int v = 0; v < vertices; ++v) {
        std::vector<int> border, creases;
        for (int f : vertex_faces[v])
            if (on_border(f))
                border.push_back(f);
        for (int e : vertex_lines[v])
            if (line_cells[e].size() == 1)
                creases.push_back(e);
        if (vertex_cells[v].size() <= 1 || creases.size() > 2) {
            entries.emplace_back(v, v, 1.0);
        } else if (creases.size() == 2) { // a curve: 6/8 of itself, 1/8 of both neighbours
            entries.emplace_back(v, v, 0.5);
            for (int e : creases)
                add_line(v, e, 0.25);
        } else if (!border.empty()) { // a Catmull-Clark surface of n faces
            int n = 0;
            for (int e : vertex_lines[v])
                n += std::any_of(line_faces[e].begin(), line_faces[e].end(), on_border) ? 1 : 0;
            for (int f : border)
                add_face(v, f, 1.0 / (n * static_cast<double>(border.size())));
            for (int e : vertex_lines[v])
                if (std::any_of(line_faces[e].begin(), line_faces[e].end(), on_border))
                    add_line(v, e, 2.0 / (n * static_cast<double>(n)));
            entries.emplace_back(v, v, (n - 3.0) / n);
        } else {
            for (int c : vertex_cells[v])
                add_cell(v, c, 1.0 / (8.0 * static_cast<double>(vertex_cells[v].size())));
            for (int f : vertex_faces[v])
                add_face(v, f, 3.0 / (8.0 * static_cast<double>(vertex_faces[v].size())));
            for (int e : vertex_lines[v])
                add_line(v, e, 3.0 / (8.0 * static_cast<double>(vertex_lines[v].size())));
            entries.emplace_back(v, v, 1.0 / 8.0);
        }
    }
    for (int e = 0; e < line_count; ++e) {
        const int row = vertices + e;
        std::vector<int> border;
        for (int f : line_faces[e])
            if (on_border(f))
                border.push_back(f);
        const double n = static_cast<double>(line_faces[e].size());
        if (line_cells[e].size() == 1) {
            add_line(row, e, 1.0);
        } else if (!border.empty()) {
            add_line(row, e, 0.5);
            for (int f : border)
                add_face(row, f, 0.5 / static_cast<double>(border.size()));
        } else { // of n faces and n cells
            for (int c : line_cells[e])
                add_cell(row, c, 1.0 / (n * n));
            for (int f : line_faces[e])
                add_face(row, f, 2.0 / (n * n));
            add_line(row, e, (n - 3.0) / n);
        }
    }
    for (int f = 0; f < face_count; ++f) {
        const int row = vertices + line_count + f;
        if (on_border(f)) {
            add_face(row, f, 1.0);
        } else {
            add_face(row, f, 0.5);
            for (int c : face_cells[f])
                add_cell(row, c, 0.5 / static_cast<double>(face_cells[f].size()));
        }
    }
    for (int c = 0; c < count; ++c)
        add_cell(vertices + line_count + face_count + c, c, 1.0);

    RefinedCells finer;
    finer.weights.resize(vertices + line_count + face_count + count, vertices);
    finer.weights.setFromTriplets(entries.begin(), entries.end());
    for (int c = 0; c < count; ++c)
        for (int k = 0; k < 8; ++k) {
            // The small cell at corner k: corner m of it lies at the middles of the axes in which m differs.
            Hexahedron small;
            for (int m = 0; m < 8; ++m) {
                const int differs = m ^ k;
                int from = vertices + line_count + face_count + c;
                if (differs == 0) {
                    from = cells[c][k];
                } else if ((differs & (differs - 1)) == 0) {
                    from = vertices + lines.at(edge(cells[c][k], cells[c][k ^ differs]));
                } else if (differs != 7) {
                    const int across = 7 ^ differs; // the axis along which the face does not extend
                    const int axis = across == 1 ? 0 : across == 2 ? 1 : 2;
                    from = vertices + line_count + cell_faces[c][2 * axis + (k >> axis & 1)];
                }
                small[m] = from;
            }
            finer.cells.push_back(small);
        }
    return finer;
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/caging/cage_diagnosis.h"

#include "native/caging/wrap.h"
#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/core/report.h"
#include "native/mesh/frames/normal_frame.h"
#include "native/mesh/half_edges.h"
#include "native/mesh/sheets.h"
#include "native/mesh/trees/crossing_faces.h"
#include "native/mesh/trees/triangle_tree.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>

namespace sinew {

namespace {

/// The faces of the sheets that look inward. The sign of the volume that a sheet encloses says which way its
/// faces look; how often the other sheets wind around it says whether it is the wall of a cavity.
std::vector<int> inverted(const std::vector<Sheet>& found, const std::vector<Vector3>& points,
                          const std::vector<std::vector<Triangle>>& cut)
{
    std::vector<std::vector<Triangle>> outward(found.size());
    std::vector<Eigen::AlignedBox3d> boxes(found.size());
    std::vector<char> reversed(found.size(), 0); // where the faces that are not `turned` look inward
    for (std::size_t s = 0; s < found.size(); ++s) {
        double volume = 0.0;
        const Vector3& origin = points[cut[found[s].faces.front()].front()[0]];
        for (std::size_t k = 0; k < found[s].faces.size(); ++k)
            for (Triangle t : cut[found[s].faces[k]]) {
                if (found[s].turned[k])
                    std::swap(t[1], t[2]);
                outward[s].push_back(t);
                for (int v : t)
                    boxes[s].extend(points[v]);
                volume += (points[t[0]] - origin).dot((points[t[1]] - origin).cross(points[t[2]] - origin));
            }
        reversed[s] = volume < 0.0;
        if (reversed[s])
            for (Triangle& t : outward[s])
                std::swap(t[1], t[2]);
    }
    std::vector<int> faces;
    for (std::size_t s = 0; s < found.size(); ++s) {
        int around = 0;
        for (std::size_t other = 0; other < found.size(); ++other)
            // Of two parts that cross, neither is inside the other.
            if (other != s && found[other].closed && boxes[other].contains(boxes[s]))
                around += std::ranges::all_of(outward[s], [&](const Triangle& t) {
                    return winding_number(points, outward[other], points[t[0]]) > 0.5;
                });
        const bool cavity = around % 2 == 1;
        for (std::size_t k = 0; k < found[s].faces.size(); ++k)
            if ((found[s].turned[k] != 0) != ((reversed[s] != 0) != cavity))
                faces.push_back(found[s].faces[k]);
    }
    std::ranges::sort(faces);
    return faces;
}

/// The sides of a face, ascending.
std::vector<std::array<int, 2>> edges_of(std::span<const int> face)
{
    std::vector<std::array<int, 2>> edges;
    for (std::size_t k = 0; k < face.size(); ++k) {
        const auto [low, high] = std::minmax(face[k], face[(k + 1) % face.size()]);
        edges.push_back({low, high});
    }
    std::ranges::sort(edges);
    return edges;
}

/// See CageDiagnosis.
std::vector<std::array<int, 2>> crowded(const SurfaceMesh& cage)
{
    std::vector<std::array<int, 2>> edges = cage.edges(), diagonals;
    const auto add = [&](int a, int b) { diagonals.push_back({std::min(a, b), std::max(a, b)}); };
    for (std::size_t t = 0; t < cage.triangles().size(); ++t) {
        const std::span<const int> face = cage.face(cage.triangle_faces()[t]);
        if (face.size() == 4) {
            if (t == 0 || cage.triangle_faces()[t - 1] != cage.triangle_faces()[t]) {
                add(face[0], face[2]);
                add(face[1], face[3]);
            }
            continue;
        }
        for (int k = 0; k < 3; ++k) { // of the two triangles at a diagonal, one counts
            const int a = cage.triangles()[t][k], b = cage.triangles()[t][(k + 1) % 3];
            const std::array edge{std::min(a, b), std::max(a, b)};
            if (a < b && !std::ranges::binary_search(edges_of(face), edge))
                add(a, b);
        }
    }
    std::ranges::sort(diagonals);
    std::vector<std::array<int, 2>> found;
    for (std::size_t k = 0; k < diagonals.size(); ++k)
        if ((k > 0 && diagonals[k - 1] == diagonals[k]) || std::ranges::binary_search(edges, diagonals[k]))
            found.push_back(diagonals[k]);
    found.erase(std::unique(found.begin(), found.end()), found.end());
    return found;
}

/// \param unit  of length of the cage
std::vector<int> outside(PointsView points, const TriangleSoup& cage, double unit)
{
    std::vector<int> strays;
    for (int i = 0; i < points.rows(); ++i)
        if (!points.row(i).allFinite())
            strays.push_back(i);
    if (!strays.empty())
        throw InvalidConstraint("points: NaN or infinite coordinates at points " + list_some(strays),
                                Error::Element::vertex, strays);
    Eigen::AlignedBox3d box;
    for (const Triangle& t : cage.triangles)
        for (int v : t)
            box.extend(cage.points[v]);
    const bool any = std::ranges::any_of(
        cage.triangles, [&](const Triangle& t) { return !is_flat(corners_of(cage.points, t)); });
    std::vector<char> out(points.rows(), 1);
    if (any) {
        const TriangleTree tree(cage.points, cage.triangles);
        const std::vector<Vector3> asked = points_in_unit(points, unit);
        const double close = 1e-9 * box.diagonal().norm();
        parallel_for(
            static_cast<int>(points.rows()),
            [&](int i) {
                const Vector3& p = asked[i];
                out[i] = winding_number(cage.points, cage.triangles, p) < 0.5 &&
                         (tree.closest(p) - p).norm() > close;
            },
            64);
    }
    for (int i = 0; i < points.rows(); ++i)
        if (out[i])
            strays.push_back(i);
    return strays;
}

} // namespace

CageDiagnosis diagnose_cage(const SurfaceMesh& cage, const std::optional<PointsView>& points)
{
    CageDiagnosis diagnosis;
    TriangleSoup soup;
    soup.triangles = cage.triangles();
    const double unit = normal_unit(cage.points());
    soup.points = points_in_unit(view(cage.points()), unit);

    const std::vector<HalfEdge> sides = sorted_half_edges(cage);
    for_each_edge(sides, [&](std::span<const HalfEdge> along) {
        if (along.size() == 1)
            diagnosis.open_edges.push_back(along[0].edge());
        else if (along.size() > 2)
            diagnosis.non_manifold_edges.push_back(along[0].edge());
    });

    std::vector<std::vector<Triangle>> cut(cage.face_count());
    for (std::size_t t = 0; t < soup.triangles.size(); ++t) {
        const int face = cage.triangle_faces()[t];
        cut[face].push_back(soup.triangles[t]);
        if (is_flat(corners_of(soup.points, soup.triangles[t])) &&
            (diagnosis.degenerate_faces.empty() || diagnosis.degenerate_faces.back() != face))
            diagnosis.degenerate_faces.push_back(face);
    }
    const std::vector<Sheet> found = sheets(cage, sides);
    diagnosis.component_count = static_cast<int>(found.size());
    diagnosis.inverted_faces = inverted(found, soup.points, cut);
    diagnosis.crossing_faces = crossing_faces(cage, soup.points);
    diagnosis.crowded_diagonals = crowded(cage);
    if (points)
        diagnosis.outside_points = outside(*points, soup, unit);
    return diagnosis;
}

std::string summary(const CageDiagnosis& d)
{
    return summary_of({
        {d.open_edges.size(), "open edge", "open edges"},
        {d.non_manifold_edges.size(), "non-manifold edge", "non-manifold edges"},
        {d.crowded_diagonals.size(), "diagonal of more than two triangles",
         "diagonals of more than two triangles"},
        {d.inverted_faces.size(), "inverted face", "inverted faces"},
        {d.degenerate_faces.size(), "face without area", "faces without area"},
        {d.crossing_faces.size(), "pair of crossing faces", "pairs of crossing faces"},
        {d.outside_points.size(), "point outside", "points outside"},
    });
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/caging/automatic_cage.h"

#include "native/caging/mirror_plane.h"
#include "native/caging/progressive_hull.h"
#include "native/caging/quads.h"
#include "native/caging/wrap.h"
#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/core/parallel.h"
#include "native/core/progress_part.h"
#include "native/mesh/components.h"
#include "native/mesh/diagnosis.h"
#include "native/mesh/frames/normal_frame.h"
#include "native/mesh/frames/surface_frame.h"
#include "native/mesh/trees/triangle_tree.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <optional>
#include <tuple>
#include <utility>

namespace sinew {

namespace {

using Symmetry = AutomaticCageOptions::Symmetry;

constexpr double on_mirror = 1e-5; // vertices of the wrap that are this close to the mirror are put on it
constexpr double mirror_tolerance =
    0.02; // as large as the default margin, about: a symmetric cage then costs little space
constexpr double least_edge = 0.35; // beside details, as a share of the margin: the wrap is not finer
constexpr int attempts = 3;        // each with twice the margin of the one before

/// A number on a grid, far below all margins: so the last bits of the target, which its unit of length and
/// its place change, choose nothing. A number and its negative stay a pair, and the grid ends where no
/// regular shape has its points.
double on_grid(double x)
{
    constexpr double steps = 1 << 16, between_regular = 0.37;
    return std::copysign(std::floor(std::abs(x) * steps + between_regular) / steps, x);
}

Vector3 on_grid(const Vector3& p)
{
    return p.unaryExpr([](double x) { return on_grid(x); });
}

/// From object space to a size of 1 around the origin.
struct Frame
{
    Vector3 centre;
    double size;

    Vector3 in(const Vector3& p) const { return on_grid(Vector3((p - centre) / size)); }
    Vector3 out(const Vector3& p) const { return centre + size * p; }
};

Frame frame_of(const SurfaceMesh& target)
{
    const double extent =
        (target.points().colwise().maxCoeff() - target.points().colwise().minCoeff()).stableNorm();
    if (!std::isfinite(extent))
        throw InvalidMesh("points: too far apart to measure");
    if (extent < 1e-100)
        throw InvalidMesh("points: all in one place; a cage needs an extent");
    const SurfaceFrame frame = surface_frame(target);
    return {frame.centre, frame.size};
}

/// The vertices of faces, if any of these has an area; else the target as it is.
SurfaceMesh without_loose_vertices(const SurfaceMesh& target)
{
    std::vector<int> numbers(target.vertex_count(), -1), vertices, counts, corners;
    double area = 0.0;
    for (const auto& [a, b, c] : target.triangles())
        area += (target.point(b) - target.point(a)).cross(target.point(c) - target.point(a)).norm();
    if (!(area > 0.0))
        return target;
    for (int f = 0; f < target.face_count(); ++f)
        for (const int v : target.face(f))
            numbers[v] = 0;
    for (int v = 0; v < target.vertex_count(); ++v)
        if (numbers[v] == 0) {
            numbers[v] = static_cast<int>(vertices.size());
            vertices.push_back(v);
        }
    for (int f = 0; f < target.face_count(); ++f) {
        counts.push_back(static_cast<int>(target.face(f).size()));
        for (const int v : target.face(f))
            corners.push_back(numbers[v]);
    }
    return {target.points()(vertices, Eigen::all), std::move(counts), std::move(corners)};
}

/// The target, with its borders closed by fans.
TriangleSoup soup_of(const SurfaceMesh& target, const Frame& frame)
{
    TriangleSoup soup;
    soup.triangles = target.triangles();
    for (int v = 0; v < target.vertex_count(); ++v)
        soup.points.push_back(frame.in(target.point(v)));
    const Diagnosis diagnosis = diagnose(target);
    for (const std::vector<int>& loop : diagnosis.boundary_loops) {
        const int middle = static_cast<int>(soup.points.size());
        Vector3 sum = Vector3::Zero();
        for (int v : loop)
            sum += soup.points[v];
        soup.points.push_back(sum / static_cast<double>(loop.size()));
        for (std::size_t k = 0; k < loop.size(); ++k)
            soup.triangles.push_back({loop[k], loop[(k + 1) % loop.size()], middle});
    }
    // The wrap ignores flat triangles. Their corners and loose vertices get tiny triangles of their own.
    std::vector<char> held(target.vertex_count(), 0);
    for (const Triangle& t : soup.triangles)
        if (!is_flat(corners_of(soup.points, t)))
            for (int v : t)
                if (v < target.vertex_count())
                    held[v] = 1;
    for (int v = 0; v < target.vertex_count(); ++v) {
        if (held[v])
            continue;
        const int next = static_cast<int>(soup.points.size());
        soup.points.push_back(soup.points[v] + Vector3(1e-6, 0, 0));
        soup.points.push_back(soup.points[v] + Vector3(0, 1e-6, 0));
        soup.triangles.push_back({v, next, next + 1});
    }
    return soup;
}

bool is_forced(Symmetry symmetry) { return symmetry != Symmetry::automatic && symmetry != Symmetry::none; }

/// The mirror plane that is asked for, or the best one, in the coordinates of the frame.
MirrorPlane mirror_of(const TriangleSoup& soup, int vertices, const TriangleTree& tree, const Frame& frame,
                      Symmetry symmetry)
{
    if (symmetry == Symmetry::none)
        return {};
    const MirrorTest test(soup.points, vertices, tree);
    const Vector3 origin = -frame.centre / frame.size;
    const int forced = is_forced(symmetry) ? static_cast<int>(symmetry) - static_cast<int>(Symmetry::x) : -1;
    return test.best(origin, forced, mirror_tolerance);
}

/// Adds the mirror image of the soup to it.
void add_image(TriangleSoup& soup, int axis)
{
    const int count = static_cast<int>(soup.points.size());
    for (int v = 0; v < count; ++v) {
        soup.points.push_back(soup.points[v]);
        soup.points.back()[axis] *= -1;
    }
    const std::size_t triangles = soup.triangles.size();
    for (std::size_t t = 0; t < triangles; ++t) {
        const auto [a, b, c] = soup.triangles[t];
        soup.triangles.push_back({a + count, c + count, b + count});
    }
}

/// The soup with each place once, in the order of the places: so the numbers of vertices and faces choose
/// nothing where several facets of the wrap are as good.
TriangleSoup in_order(const TriangleSoup& soup)
{
    const auto key = [](const Vector3& p) { return std::tuple(p.x(), p.y(), p.z()); };
    TriangleSoup sorted{soup.points, soup.triangles};
    std::ranges::sort(sorted.points, {}, key);
    sorted.points.erase(std::unique(sorted.points.begin(), sorted.points.end()), sorted.points.end());
    std::vector<int> numbers;
    for (const Vector3& p : soup.points)
        numbers.push_back(static_cast<int>(std::ranges::lower_bound(sorted.points, key(p), {}, key) -
                                           sorted.points.begin()));
    for (Triangle& t : sorted.triangles) {
        for (int& v : t)
            v = numbers[v];
        std::ranges::sort(t); // the wrap has no use for the side of a triangle
    }
    std::ranges::sort(sorted.triangles);
    return sorted;
}

/// A cage that is finer beside details, on both sides of a mirror: how fine where, and of how many triangles.
std::pair<Fineness, int> finer_beside_details(const AutomaticCageOptions& options, const TriangleSoup& soup,
                                              const Frame& frame, int axis)
{
    std::vector<Detail> details;
    for (const auto& [centre, radius] : options.details) {
        Detail detail{frame.in(centre), on_grid(radius / frame.size)};
        details.push_back(detail);
        if (axis >= 0) {
            detail.centre[axis] *= -1;
            details.push_back(detail);
        }
    }
    if (details.empty())
        return {Fineness(), options.faces};
    const auto area_of = [](const Corners& t) { return 0.5 * (t[1] - t[0]).cross(t[2] - t[0]).norm(); };
    double area = 0.0, finer = 0.0;
    for (const Triangle& t : soup.triangles)
        area += area_of(corners_of(soup.points, t));
    const double usual = std::sqrt(area / options.faces * 4.0 / std::sqrt(3.0)); // of equal sides
    Fineness fineness(std::move(details), usual, least_edge * options.margin);
    for (const Triangle& t : soup.triangles) {
        const Corners corners = corners_of(soup.points, t);
        const Vector3 middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        finer += area_of(corners) * std::pow(fineness.at(middle), 2);
    }
    const int faces = area > 0.0 ? static_cast<int>(std::lround(
                                       std::min<double>(options.most_faces, options.faces * finer / area)))
                                 : options.faces;
    return {std::move(fineness), std::max(faces, options.faces)};
}

/// The part on the positive side of the mirror; vertices on the cut get the coordinate 0.
TriangleSoup positive_half(const TriangleSoup& whole, int axis)
{
    TriangleSoup half;
    half.points = whole.points;
    for (Vector3& p : half.points)
        if (std::abs(p[axis]) < on_mirror)
            p[axis] = 0.0;
    std::map<std::pair<int, int>, int> cuts;
    const auto cut = [&](int a, int b) {
        const auto [at, fresh] = cuts.try_emplace(std::minmax(a, b), static_cast<int>(half.points.size()));
        if (fresh) {
            const auto [low, high] = std::minmax(a, b);
            const Vector3 p = half.points[low], q = half.points[high];
            Vector3 middle = p + (q - p) * (p[axis] / (p[axis] - q[axis]));
            middle[axis] = 0.0;
            half.points.push_back(middle);
        }
        return at->second;
    };
    for (const Triangle& t : whole.triangles) {
        std::vector<int> kept; // the corners of the part that is left, two to four
        bool any = false;
        for (int k = 0; k < 3; ++k) {
            const int a = t[k], b = t[(k + 1) % 3];
            const double from = half.points[a][axis], to = half.points[b][axis];
            any |= from > 0.0;
            if (from >= 0.0)
                kept.push_back(a);
            if ((from > 0.0 && to < 0.0) || (from < 0.0 && to > 0.0))
                kept.push_back(cut(a, b));
        }
        if (any)
            for (std::size_t k = 2; k < kept.size(); ++k)
                half.triangles.push_back({kept[0], kept[k - 1], kept[k]});
    }
    return half;
}

/// Completes the half with its mirror image, joined along the mirror. The faces of the half come first.
void complete(std::vector<Vector3>& points, Polygons& faces, int axis)
{
    std::vector<int> image(points.size());
    const std::size_t count = points.size(), half = faces.size();
    for (std::size_t v = 0; v < count; ++v) {
        image[v] = static_cast<int>(v);
        if (points[v][axis] == 0.0)
            continue;
        image[v] = static_cast<int>(points.size());
        points.push_back(points[v]);
        points.back()[axis] *= -1;
    }
    for (std::size_t f = 0; f < half; ++f) {
        std::vector<int> face(faces[f].rbegin(), faces[f].rend());
        for (int& v : face)
            v = image[v];
        faces.push_back(std::move(face));
    }
}

/// What the cage must not touch: the target, and the wrap at half its distance from the target.
TriangleTree inner_tree(const TriangleSoup& wrap, const TriangleSoup& soup, const TriangleTree& target)
{
    TriangleSoup inner = soup;
    const int first = static_cast<int>(inner.points.size());
    inner.points.resize(first + wrap.points.size());
    parallel_for(
        static_cast<int>(wrap.points.size()),
        [&](int v) {
            inner.points[first + v] =
                on_grid(Vector3(0.5 * (wrap.points[v] + target.closest(wrap.points[v]))));
        },
        64);
    for (const auto& [a, b, c] : wrap.triangles)
        inner.triangles.push_back({first + a, first + b, first + c});
    return {inner.points, inner.triangles};
}

/// Simplifies in steps and tightens after each one: so what each collapse adds to the volume is taken back
/// before the next ones add to it. Where it is stuck, it goes on boldly.
void simplify(ProgressiveHull& hull, const TriangleTree& within, int faces, const Progress& progress)
{
    constexpr double ratio = 0.6; // of a step
    constexpr int first = 2;      // times the wanted number: before that, little has been added
    constexpr int rounds = 3, last_rounds = 16;
    const double whole = std::log(std::max(2.0, static_cast<double>(hull.face_count()) / faces));
    const auto done = [&](int left) {
        return std::max(0.0, 1.0 - std::log(static_cast<double>(left) / faces) / whole);
    };
    bool boldly = false;
    double from = 0.0; // of the progress
    while (true) {
        const int before = hull.face_count();
        const int next = before > first * faces         ? first * faces
                         : ratio * before < 1.3 * faces ? faces
                                                        : static_cast<int>(ratio * before);
        const double to = done(next), between = from + 0.7 * (to - from);
        hull.collapse(next, boldly, part_of(progress, from, between));
        const bool is_stuck = hull.face_count() == before;
        hull.tighten(within, next == faces ? last_rounds : rounds, part_of(progress, between, to));
        if (hull.face_count() <= faces || (is_stuck && boldly))
            break;
        boldly = is_stuck;
        from = to;
    }
}

/// Whether the cage is closed, does not cross itself, and contains the target. The coordinates checked are
/// those that are returned, rounding included.
/// \param unit  normal_unit() of the target
bool is_good(const SurfaceMesh& cage, const SurfaceMesh& target, double unit)
{
    const Diagnosis diagnosis = diagnose(cage);
    if (!diagnosis.boundary_loops.empty() || !diagnosis.non_manifold_edges.empty() ||
        !diagnosis.inconsistent_edges.empty() || !diagnosis.degenerate_faces.empty())
        return false;
    const std::vector<Vector3> around = points_in_unit(view(cage.points()), unit),
                               inner = points_in_unit(view(target.points()), unit);
    if (!meeting_pairs(around, cage.triangles()).empty())
        return false;
    const TriangleTree tree(around, cage.triangles());
    std::atomic<bool> pokes = false;
    parallel_for(
        static_cast<int>(target.triangles().size()),
        [&](int t) {
            if (!pokes && tree.meets(corners_of(inner, target.triangles()[t])))
                pokes = true;
        },
        256);
    if (pokes)
        return false;
    // A part that does not meet the cage is inside if one of its vertices is. Whether a flat triangle meets
    // the cage is not known, so all its corners are checked.
    std::vector<char> asked(target.vertex_count(), 0);
    const Components parts = connected_components(target);
    std::vector<char> known(parts.count, 0);
    for (int v = 0; v < target.vertex_count(); ++v)
        if (!std::exchange(known[parts.labels[v]], 1))
            asked[v] = 1;
    for (const Triangle& t : target.triangles())
        if (is_flat(corners_of(inner, t)))
            for (int v : t)
                asked[v] = 1;
    for (int v = 0; v < target.vertex_count(); ++v)
        if (asked[v] && winding_number(around, cage.triangles(), inner[v]) < 0.5)
            return false;
    return true;
}

double clearance(const SurfaceMesh& cage, const SurfaceMesh& target, double unit, double size)
{
    const std::vector<Vector3> inner = points_in_unit(view(target.points()), unit);
    const TriangleTree tree(points_in_unit(view(cage.points()), unit), cage.triangles());
    std::vector<double> distances(target.vertex_count());
    parallel_for(
        target.vertex_count(),
        [&](int v) { distances[v] = (tree.closest(inner[v]) - inner[v]).norm() / (size / unit); }, 256);
    return *std::ranges::min_element(distances);
}

SurfaceMesh mesh_of(const std::vector<Vector3>& points, const Polygons& faces, const Frame& frame)
{
    Points placed(static_cast<Eigen::Index>(points.size()), 3);
    for (std::size_t v = 0; v < points.size(); ++v)
        placed.row(static_cast<Eigen::Index>(v)) = frame.out(points[v]).transpose();
    std::vector<int> counts, corners;
    for (const std::vector<int>& face : faces) {
        counts.push_back(static_cast<int>(face.size()));
        corners.insert(corners.end(), face.begin(), face.end());
    }
    return {std::move(placed), std::move(counts), std::move(corners)};
}

} // namespace

AutomaticCage automatic_cage(const SurfaceMesh& whole, const AutomaticCageOptions& options,
                             const Progress& progress)
{
    const auto begin = std::chrono::steady_clock::now();
    if (options.faces < 12 || options.faces > 100'000)
        throw InvalidOption("faces: " + std::to_string(options.faces) + " is not in 12 to 100000");
    if (!(options.margin >= 0.004 && options.margin <= 0.25))
        throw InvalidOption("margin: " + shortest(options.margin) + " is not in 0.004 to 0.25");

    const SurfaceMesh target = without_loose_vertices(whole);
    Frame frame = frame_of(target);
    const double unit = normal_unit(target.points());
    TriangleSoup soup = soup_of(target, frame);
    std::optional<TriangleTree> tree(std::in_place, soup.points, soup.triangles);
    const MirrorPlane mirror = mirror_of(soup, target.vertex_count(), *tree, frame, options.symmetry);
    const int axis = mirror.deviation <= mirror_tolerance || is_forced(options.symmetry) ? mirror.axis : -1;
    if (axis >= 0 && mirror.through_origin) { // exactly, so that rounding is the same on both sides
        frame.centre[axis] = 0.0;
        soup = soup_of(target, frame);
    }
    const auto [fineness, wanted] = finer_beside_details(options, soup, frame, axis);
    if (axis >= 0)
        add_image(soup, axis);
    soup = in_order(soup);
    tree.emplace(soup.points, soup.triangles);

    std::optional<AutomaticCage> best;
    double margin = options.margin;
    for (int attempt = 0; attempt < attempts; ++attempt, margin *= 2) {
        const double start = static_cast<double>(attempt) / attempts, width = 1.0 / attempts;
        const auto stage = [&](double from, double to) {
            return part_of(progress, start + width * from, start + width * to);
        };
        TriangleSoup wrap = wrapped(soup, margin, margin, stage(0.0, 0.5));
        for (Vector3& p : wrap.points)
            p = on_grid(p);
        const int wrap_faces = static_cast<int>(wrap.triangles.size());
        if (axis >= 0)
            wrap = positive_half(wrap, axis);
        ProgressiveHull hull(wrap, 1.0, axis, fineness);
        simplify(hull, inner_tree(wrap, soup, *tree), axis >= 0 ? wanted / 2 : wanted, stage(0.5, 0.95));

        auto [points, triangles] = hull.surface();
        Polygons faces =
            options.quads ? paired(points, triangles, *tree, 0.3 * margin, axis) : polygons(triangles);
        if (axis >= 0)
            complete(points, faces, axis);
        progress.tick(start + width * 0.95, "checking");
        const SurfaceMesh cage = mesh_of(points, faces, frame);
        if (!is_good(cage, target, unit))
            continue;
        AutomaticCage found;
        found.points = cage.points();
        for (int f = 0; f < cage.face_count(); ++f) {
            found.counts.push_back(static_cast<int>(cage.face(f).size()));
            found.corners.insert(found.corners.end(), cage.face(f).begin(), cage.face(f).end());
        }
        found.report.wanted = wanted;
        found.report.faces = static_cast<int>(cage.triangles().size());
        found.report.quads = found.report.faces - cage.face_count();
        found.report.reached = found.report.faces <= wanted + (axis >= 0 ? 1 : 0);
        found.report.mirror_axis = axis;
        found.report.asymmetry = mirror.deviation;
        found.report.wrap_faces = wrap_faces;
        found.report.margin = margin;
        if (!best || found.report.faces < best->report.faces)
            best = std::move(found);
        if (best->report.reached)
            break;
    }
    if (!best)
        throw InvalidMesh(
            "no closed cage without crossings was found around this mesh; try another margin or "
            "number of faces");
    if (!best->report.reached)
        best->report.reason = "with fewer faces, some would cross, fold over or become needles, or a hole or "
                              "the gap between two parts would close";
    best->report.clearance =
        clearance(SurfaceMesh(best->points, best->counts, best->corners), target, unit, frame.size);
    progress.tick(1.0, "checking");
    best->report.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
    return *std::move(best);
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
// frames LOOP: runs one frame or bind of a method on a sheet of 10,000 vertices, within frame(). count.py
// counts the instructions there. It uses one thread, so that every run gives the same count.
#include "native/attachments/attachments.h"
#include "native/core/parallel.h"
#include "native/core/simd/processor.h"
#include "native/methods/space/cage/green.h"
#include "native/methods/space/cage/mean_value.h"
#include "native/methods/surface/linear/responses/affine_basis.h"
#include "native/methods/surface/linear/thin_shell.h"
#include "native/methods/surface/nonlinear/arap.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>

using namespace sinew;

/// callgrind counts the instructions within this function, which it finds by its name.
extern "C" __attribute__((noinline, visibility("default"))) void frame(const std::function<void()>& work)
{
    work();
}

namespace {

constexpr int side = 100;

/// A sheet of triangles with bumps; x and y from 0 to 1.
SurfaceMesh sheet()
{
    Points points(side * side, 3);
    std::vector<int> corners;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            const double x = i / (side - 1.0), y = j / (side - 1.0);
            points.row(side * i + j) << x, y, 0.05 * std::sin(11 * x) * std::cos(7 * y);
            if (i + 1 < side && j + 1 < side) {
                const int a = side * i + j, b = a + side;
                corners.insert(corners.end(), {a, b, b + 1, a, b + 1, a + 1});
            }
        }
    return {points, std::vector<int>(corners.size() / 3, 3), corners};
}

/// Vertices in the first or last 3 rows (axis 0) or columns (axis 1).
Handle border(int axis, bool far)
{
    Handle handle;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            const int along = axis == 0 ? i : j, across = axis == 0 ? j : i;
            const bool corner = axis == 1 && (across < 3 || across >= side - 3);
            if ((far ? along >= side - 3 : along < 3) && !corner)
                handle.vertices.push_back(side * i + j);
        }
    return handle;
}

Poses turned(int count)
{
    Pose still = Pose::Zero();
    still.leftCols<3>() = Matrix3::Identity();
    Poses poses(count, still);
    poses[1] << 0.8, 0.0, 0.6, 0.1, 0.0, 1.0, 0.0, 0.0, -0.6, 0.0, 0.8, 0.3;
    return poses;
}

/// A closed box of triangles around the sheet, `cells` along each side.
SurfaceMesh box(int cells)
{
    const int across = cells + 1;
    std::vector<int> index(static_cast<std::size_t>(across) * across * across, -1), corners;
    std::vector<double> numbers;
    const auto vertex = [&](int i, int j, int k) {
        int& at = index[(static_cast<std::size_t>(i) * across + j) * across + k];
        if (at < 0) {
            at = static_cast<int>(numbers.size() / 3);
            numbers.insert(numbers.end(),
                           {-0.1 + 1.2 * i / cells, -0.1 + 1.2 * j / cells, -0.3 + 0.6 * k / cells});
        }
        return at;
    };
    const auto quad = [&](int a, int b, int c, int d) { corners.insert(corners.end(), {a, b, c, a, c, d}); };
    for (int i = 0; i < cells; ++i)
        for (int j = 0; j < cells; ++j) {
            quad(vertex(i, j, 0), vertex(i, j + 1, 0), vertex(i + 1, j + 1, 0), vertex(i + 1, j, 0));
            quad(vertex(i, j, cells), vertex(i + 1, j, cells), vertex(i + 1, j + 1, cells),
                 vertex(i, j + 1, cells));
            quad(vertex(0, i, j), vertex(0, i, j + 1), vertex(0, i + 1, j + 1), vertex(0, i + 1, j));
            quad(vertex(cells, i, j), vertex(cells, i + 1, j), vertex(cells, i + 1, j + 1),
                 vertex(cells, i, j + 1));
            quad(vertex(i, 0, j), vertex(i + 1, 0, j), vertex(i + 1, 0, j + 1), vertex(i, 0, j + 1));
            quad(vertex(i, cells, j), vertex(i, cells, j + 1), vertex(i + 1, cells, j + 1),
                 vertex(i + 1, cells, j));
        }
    return {Eigen::Map<const Points>(numbers.data(), static_cast<Eigen::Index>(numbers.size() / 3), 3),
            std::vector<int>(corners.size() / 3, 3), corners};
}

/// The sheet with 14 x 14 small boxes of 26 vertices above it.
SurfaceMesh sheet_with_boxes(const SurfaceMesh& under)
{
    constexpr int rows = 14;
    const SurfaceMesh one = box(2);
    const int n = under.vertex_count(), each = one.vertex_count();
    Points points(n + rows * rows * each, 3);
    points.topRows(n) = under.points();
    std::vector<int> corners;
    const auto add = [&](const SurfaceMesh& part, int first) {
        for (const Triangle& t : part.triangles())
            corners.insert(corners.end(), {first + t[0], first + t[1], first + t[2]});
    };
    add(under, 0);
    for (int k = 0; k < rows * rows; ++k) {
        const Eigen::RowVector3d place((k / rows + 0.5) / rows, (k % rows + 0.5) / rows, 0.06);
        points.middleRows(n + each * k, each) = (0.03 * one.points()).rowwise() + place;
        add(one, n + each * k);
    }
    return {points, std::vector<int>(corners.size() / 3, 3), corners};
}

/// Only the second call is counted, since the first starts oneTBB and allocates memory.
void twice(const std::function<void()>& work)
{
    work();
    frame(work);
}

} // namespace

int main(int count, char** words)
{
    const char* loop = count > 1 ? words[1] : "";
    limit_threads(1);
    const SurfaceMesh mesh = sheet();
    const std::vector<Handle> two{border(0, false), border(0, true)};
    Points out;
    if (!std::strcmp(loop, "about")) {
        std::printf("{\"compiler\": \"%s\", \"avx2\": %s}\n", __VERSION__,
                    sinew::processor().avx2 ? "true" : "false");
    } else if (!std::strcmp(loop, "thin_shell")) {
        ThinShellOptions options;
        options.affine_basis = false;
        ThinShell shell(mesh, options);
        shell.set_handles(two);
        twice([&] { shell.solve({turned(2)}, out); });
    } else if (!std::strcmp(loop, "affine_basis")) {
        ThinShell shell(mesh);
        shell.set_handles({two[0], two[1], border(1, false), border(1, true)});
        twice([&] { shell.affine_basis()->solve(turned(4), out); });
    } else if (!std::strncmp(loop, "attachments", 6)) {
        const SurfaceMesh dressed = sheet_with_boxes(mesh);
        const Components parts = connected_components(dressed);
        std::vector<bool> driven(parts.count, false);
        driven[0] = true;
        const Attachments attachments(dressed, parts, driven, {.follow = true});
        Points incoming = dressed.points();
        incoming.col(2).array() += 0.1 * incoming.col(0).array().square();
        out = incoming;
        out.col(0).array() += 0.2 * incoming.col(1).array().square();
        if (std::strstr(loop, "_incoming"))
            twice([&] { attachments.move(view(incoming), out); });
        else
            twice([&] { attachments.move({}, out); });
    } else if (!std::strncmp(loop, "mean_value", 10) || !std::strncmp(loop, "green", 5)) {
        const SurfaceMesh cage = box(7); // 296 vertices
        const Points pose = 1.1 * cage.points();
        const auto measure = [&](CageCoordinates&& coordinates) {
            if (std::strstr(loop, "_bind")) {
                frame([&] { coordinates.bind(view(mesh.points())); });
            } else {
                coordinates.bind(view(mesh.points()));
                out.resize(mesh.vertex_count(), 3);
                twice([&] { coordinates.warp(view(pose), {}, out.data()); });
            }
        };
        if (loop[0] == 'm')
            measure(MeanValue{Cage(cage)});
        else
            measure(Green{Cage(cage)});
    } else if (!std::strcmp(loop, "thin_shell_bind")) {
        ThinShell shell(mesh);
        frame([&] { shell.set_handles(two); });
    } else if (!std::strcmp(loop, "arap_bind")) {
        Arap arap(mesh);
        frame([&] { arap.set_handles(two); });
    } else if (!std::strcmp(loop, "arap") && count == 4) {
        ArapOptions options;
        options.smoothness = std::atof(words[2]);
        Arap arap(mesh, options);
        arap.set_handles(two);
        SolveRequest request{turned(2)};
        request.max_iterations = std::atoi(words[3]);
        request.tolerance = 0.0;
        frame([&] { arap.solve(request, out); });
    } else {
        std::fprintf(stderr,
                     "frames about | thin_shell | affine_basis | attachments | attachments_incoming | "
                     "arap SMOOTHNESS ITERATIONS | thin_shell_bind | arap_bind | mean_value | green "
                     "| mean_value_bind | green_bind\n");
        return 2;
    }
    return 0;
}

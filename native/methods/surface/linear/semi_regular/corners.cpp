// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/semi_regular/corners.h"

#include <algorithm>
#include <array>
#include <iterator>

namespace sinew {

JoinedCorners::JoinedCorners(const SurfaceMesh& mesh, const std::vector<int>& part, std::vector<char>& sound)
    : first{0}, at(mesh.vertex_count(), none), count(mesh.vertex_count(), 0)
{
    std::vector<char> size(sound.size(), 0);
    std::vector<std::array<int, 3>> sides; // low and high vertex, corner
    for (int f = 0; f < mesh.face_count(); ++f) {
        const auto loop = mesh.face(f);
        const int p = part[loop.front()], begin = first.back();
        const bool point = std::ranges::count(loop, loop.front()) == std::ssize(loop);
        const int corners = point ? 0 : static_cast<int>(loop.size());
        for (int k = 0; k < corners; ++k) {
            const int v = loop[k], w = loop[(k + 1) % corners];
            vertex.push_back(v);
            face.push_back(f);
            if (at[v] == none)
                at[v] = begin + k;
            ++count[v];
            if (sound[p])
                sides.push_back({std::min(v, w), std::max(v, w), begin + k});
        }
        first.push_back(begin + corners);
        if (!sound[p] || point)
            continue;
        if (size[p] == 0)
            size[p] = static_cast<char>(corners == 3 || corners == 4 ? corners : -1);
        bool simple = corners == size[p];
        for (int k = 0; simple && k < corners; ++k)
            simple = std::find(loop.begin() + k + 1, loop.end(), loop[k]) == loop.end();
        if (!simple)
            sound[p] = 0;
    }
    twin.assign(vertex.size(), none);
    std::ranges::sort(sides);
    for (std::size_t begin = 0, end; begin < sides.size(); begin = end) {
        const auto [low, high, one] = sides[begin];
        for (end = begin + 1; end < sides.size() && sides[end][0] == low && sides[end][1] == high;)
            ++end;
        if (end - begin == 1)
            continue;
        const int other = sides[begin + 1][2];
        if (end - begin > 2 || vertex[one] == vertex[other]) {
            sound[part[low]] = 0;
            continue;
        }
        twin[one] = other;
        twin[other] = one;
    }
    std::vector<int> around;
    for (std::size_t v = 0; v < at.size(); ++v) {
        if (!sound[part[v]] || at[v] == none)
            continue;
        fan(static_cast<int>(v), around);
        if (static_cast<int>(around.size()) != count[v])
            sound[part[v]] = 0;
    }
}

bool JoinedCorners::fan(int v, std::vector<int>& corners) const
{
    corners.clear();
    int start = at[v];
    while (twin[start] != none) {
        start = next(twin[start]);
        if (start == at[v])
            break;
    }
    for (int c = start; c != none;) {
        corners.push_back(c);
        c = twin[previous(c)];
        if (c == start)
            return true;
    }
    return false;
}

} // namespace sinew

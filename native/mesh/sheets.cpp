// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/mesh/sheets.h"

#include <numeric>
#include <utility>

namespace sinew {

std::vector<Sheet> sheets(const SurfaceMesh& mesh, std::span<const HalfEdge> sides)
{
    struct Neighbour
    {
        int face;
        bool agrees; ///< whether both faces look to the same side
    };
    const int count = mesh.face_count();
    std::vector<int> begin(count + 1, 0);
    const auto for_each_pair = [&](const auto& body) {
        for_each_edge(sides, [&](std::span<const HalfEdge> along) {
            if (along.size() == 2) {
                body(along[0], along[1]);
                body(along[1], along[0]);
            }
        });
    };
    for_each_pair([&](const HalfEdge& one, const HalfEdge&) { ++begin[one.face + 1]; });
    std::partial_sum(begin.begin(), begin.end(), begin.begin());
    std::vector<Neighbour> neighbours(begin.back());
    std::vector<int> next(begin.begin(), begin.end() - 1);
    for_each_pair([&](const HalfEdge& one, const HalfEdge& other) {
        neighbours[next[one.face]++] = {other.face, one.from != other.from};
    });

    std::vector<Sheet> found;
    std::vector<char> visited(count, 0), turned(count, 0);
    for (int first = 0; first < count; ++first) {
        if (visited[first])
            continue;
        Sheet sheet{{first}, {}};
        visited[first] = 1;
        for (std::size_t k = 0; k < sheet.faces.size(); ++k) {
            const int face = sheet.faces[k];
            for (int at = begin[face]; at < begin[face + 1]; ++at) {
                const auto [other, agrees] = neighbours[at];
                const char as_it_should = agrees == (turned[face] != 0);
                sheet.one_sided |= visited[other] && turned[other] != as_it_should;
                if (visited[other])
                    continue;
                visited[other] = 1;
                turned[other] = as_it_should;
                sheet.faces.push_back(other);
            }
        }
        for (int f : sheet.faces) {
            sheet.turned.push_back(turned[f]);
            sheet.closed &= begin[f + 1] - begin[f] == static_cast<int>(mesh.face(f).size());
        }
        found.push_back(std::move(sheet));
    }
    return found;
}

} // namespace sinew

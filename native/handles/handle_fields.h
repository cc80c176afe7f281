// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/types.h"
#include "native/handles/constrained_system.h"
#include "native/handles/handle_groups.h"
#include "native/mesh/surface_mesh.h"

#include <functional>

namespace sinew {

/// How far each handle reaches over the surface.
enum class Field {
    harmonic, ///< Delta s = 0 between the handles (Eq. 8)
    geodesic, ///< shares of the inverse distances along the surface; s = d_F / (d_F + d_H) for two handles
    euclidean ///< the same with straight distances
};
constexpr auto choices(Field)
{
    return std::array{Choice{"harmonic", Field::harmonic}, Choice{"geodesic", Field::geodesic},
                      Choice{"euclidean", Field::euclidean}};
}

/// One field per part handle: 1 on its own handle and 0 on the others; those of a part sum to 1. A soft
/// handle of weight w has less than 1 on its vertices: it pulls the harmonic field as it pulls positions, and
/// lies (1 - w) / w mean edges farther away. All fields stay in [0, 1]: for harmonic ones, negative weights
/// of edges are made positive (see operators/laplacian.h).
class HandleFields
{
public:
    HandleFields() = default;
    /// The harmonic fields. Cost: one solve of as many columns as a part has handles, less one; and one
    /// factorisation where an edge has a negative weight.
    /// \param laplacian  factorised for these regions; or on the multigrid, and then without negative weights.
    /// \throw OutOfMemory  the fields would take more than limit_memory() allows.
    /// \throw NotConverged, Cancelled  on the multigrid.
    HandleFields(HandleGroups groups, const Regions& regions, const ConstrainedSystem& laplacian,
                 const Progress& progress = {});
    /// The fields by distances. Cost: O(n log n) per handle.
    /// \param field  geodesic or euclidean.
    /// \throw OutOfMemory  likewise.
    HandleFields(HandleGroups groups, const Regions& regions, const SurfaceMesh& mesh, Field field);

    const HandleGroups& groups() const { return groups_; }
    /// The field of a part handle at a vertex of its part.
    double share(int vertex, int part_handle) const
    {
        double share;
        shares(vertex, 1, part_handle, &share);
        return share;
    }
    /// The field of a part handle at n vertices of its part, one after the other.
    void shares(int begin, int n, int part_handle, double* found) const
    {
        const int g = groups_.group[begin], slot = part_handle - groups_.offsets[g];
        const Eigen::Index width = shares_.cols(), kept = groups_.offsets[g + 1] - 1 - groups_.offsets[g];
        const double* row = shares_.data() + width * begin;
        for (int i = 0; i < n; ++i, row += width)
            if (slot < kept)
                found[i] = row[slot];
            else {
                found[i] = 1.0;
                for (Eigen::Index other = 0; other < kept; ++other)
                    found[i] -= row[other];
            }
    }

    /// (n, m) the mean of the values of the part handles at each vertex, weighted by the fields. Where all
    /// values of a part are one, it is exactly that one. Rows of parts without a handle are left as they are.
    /// \param values  (part handles, m)
    void blend(const RowMatrix& values, RowMatrix& blended) const;

private:
    /// \throw OutOfMemory  there is no room for them, and for as many columns beside them.
    void allocate(int columns_beside = 0);
    /// Shares of the inverse distances of each vertex from the part handles of its part.
    void share_by(const Regions& regions, const std::function<double(int vertex, int part_handle)>& distance);

    HandleGroups groups_;
    RowMatrix shares_; ///< (n, width - 1) of all part handles of a part but the last
};

} // namespace sinew

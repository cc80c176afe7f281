// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/progress.h"
#include "native/core/types.h"
#include "native/mesh/surface_mesh.h"

#include <array>
#include <cstddef>
#include <vector>

namespace sinew {

/// A grid around a shape: which voxels its faces and points touch, which lie inside of closed surfaces, and
/// which of these are parts of larger cubes. Around the shape, one layer stays empty.
class Voxels
{
public:
    /// \param wanted  about how many cubes.
    /// \param levels  how often inner voxels may be merged, eight into one, as long as neighbours differ by
    ///                one level at most.
    Voxels(const SurfaceMesh& mesh, int wanted, int levels, const Progress& progress);

    const Vector3& origin() const { return origin_; }
    double side() const { return side_; }
    const std::array<int, 3>& dims() const { return dims_; }
    std::size_t count() const { return state_.size(); }
    std::size_t index(const std::array<int, 3>& at) const
    {
        return (static_cast<std::size_t>(at[2]) * dims_[1] + at[1]) * dims_[0] + at[0];
    }
    /// By rising index.
    template <class Visit>
    void each(Visit&& visit) const
    {
        std::size_t index = 0;
        for (int z = 0; z < dims_[2]; ++z)
            for (int y = 0; y < dims_[1]; ++y)
                for (int x = 0; x < dims_[0]; ++x)
                    visit(std::array<int, 3>{x, y, z}, index++);
    }

    bool is_filled(std::size_t index) const { return state_[index] != empty; }
    /// Whether a face or a point of the shape touches it.
    bool has_shape(std::size_t index) const { return state_[index] == shape; }
    /// 0 for a voxel of its own, 1 for one of a cube of eight, ...
    int level(std::size_t index) const { return level_[index]; }
    /// Whether one face runs through both, or they have no part of the shape in common.
    bool share_shape(std::size_t one, std::size_t other) const;

private:
    enum State : char { unknown, empty, shape, inner };

    void lay_out(const SurfaceMesh& mesh, double side);
    int fill(const SurfaceMesh& mesh, int levels);
    void merge(int level);
    bool is_block(const std::array<int, 3>& at, int level) const;
    template <class Visit>
    void touched_by(const Vector3& a, const Vector3& b, const Vector3& c, Visit&& visit) const;

    Vector3 origin_ = Vector3::Zero();
    double side_ = 1.0;
    std::array<int, 3> dims_{};
    std::vector<State> state_;
    std::vector<char> level_;
    std::vector<std::vector<int>> triangles_; ///< that touch each voxel with a part of the shape
    std::vector<std::vector<int>> parts_;     ///< of the shape in it
    std::vector<int> slot_;                   ///< of each voxel in these two, or -1
};

} // namespace sinew

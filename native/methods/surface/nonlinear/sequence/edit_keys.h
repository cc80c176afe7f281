// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"

#include <Eigen/Core>

#include <vector>

namespace sinew {

/// How a handle is edited in one frame of an animation: an affine map in the moving frame of the handle,
/// whose origin is the handle's centre.
struct EditKey
{
    double frame;
    int handle;
    Pose edit;
};

/// Keys of the edits of handles, and the edits between them.
///
/// An edit x -> A x + m is A = R S, a rotation and a symmetric stretch. Its numbers are m, the rotation
/// vector of R and S. Each runs along a cubic Hermite curve from key to key of its handle, so the edit is C1
/// in time. With the slopes a and b on both sides of a key, the curve passes it with
///
///     max(0, a.b) (a + b) / (|a|^2 + |b|^2)
///
/// for m, for the rotation vector and for S each: a key beside an equal one is passed with the slope 0, so
/// the edit between two equal keys is constant, and it nowhere exceeds those of its keys. Before the first
/// key and after the last one it stays as it is there. A rotation vector is taken in the number of turns that
/// brings it nearest to that of the key before, so a handle turns by less than half a turn from key to key.
///
/// A handle without keys is not edited. The edit at a frame depends on the frame and the keys alone.
class EditKeys
{
public:
    EditKeys() = default;
    /// \param keys  in any order.
    /// \throw InvalidOption  a number is not finite, a handle is negative, or two keys of a handle have the
    ///   same frame; the key is named.
    explicit EditKeys(const std::vector<EditKey>& keys);

    /// How many handles the keys name: the last of them and all before.
    int handle_count() const { return static_cast<int>(tracks_.size()); }
    bool empty() const { return tracks_.empty(); }
    /// Exactly the edit of a key in its frame, and exactly the identity for a handle without keys.
    /// Cost: O(log keys).
    Pose at(int handle, double frame) const;

private:
    using Numbers = Eigen::Matrix<double, 12, 1>; ///< m, rotation vector, S (see .cpp)
    struct Knot
    {
        double frame;
        Pose edit;
        Numbers value, slope;
    };
    using Track = std::vector<Knot>; ///< of one handle, by rising frame

    static Track track_of(const std::vector<EditKey>& keys);

    std::vector<Track> tracks_;
};

} // namespace sinew

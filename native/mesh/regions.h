// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/report.h"
#include "native/core/types.h"
#include "native/mesh/components.h"

#include <optional>
#include <vector>

namespace sinew {

/// A region that an artist marked. A fixed region is a handle whose pose is the identity.
struct Handle
{
    std::vector<int> vertices;
    /// One per vertex, in [0, 1]: 1 holds the vertex exactly, less pulls it softly, 0 leaves it free. Empty
    /// where all are 1.
    std::vector<double> weights;
    /// How smoothly the free surface leaves the region, from 0 to 2 (C0 to C2), as far as the order of the
    /// energy allows; values between these blend them.
    double continuity = 2.0;

    bool operator==(const Handle&) const = default;
};

/// Pulls a vertex with the stiffness weight / (1 - weight), in units of the vertex's own diagonal entry of
/// the system.
struct SoftConstraint
{
    int vertex;
    int handle;
    double weight; ///< in (0, 1)

    double stiffness() const { return weight / (1.0 - weight); }
};

/// A vertex, and a handle that holds or pulls it.
struct Constraint
{
    int vertex;
    int handle;
};

/// The handles on a mesh of n vertices, checked and turned into constraints of single vertices. At most one
/// handle holds a vertex exactly, and then no handle pulls it; the soft pulls of several handles add up.
class Regions
{
public:
    Regions() = default;

    /// \throw InvalidConstraint  a handle without vertices, an index out of range, another number of weights
    ///   than of vertices, a weight outside [0, 1], a continuity outside [0, 2], or a vertex that two handles
    ///   hold exactly.
    Regions(std::vector<Handle> handles, const Components& parts);

    const std::vector<Handle>& handles() const { return handles_; }
    int handle_count() const { return static_cast<int>(handles_.size()); }
    int vertex_count() const { return static_cast<int>(hard_.size()); }

    /// The handle that holds a vertex exactly, or -1.
    int hard(int vertex) const { return hard_[vertex]; }
    const std::vector<SoftConstraint>& soft() const { return soft_; }
    /// All constraints: first the hard ones by rising vertex, then those of soft() in their order.
    std::vector<Constraint> constraints() const;
    double continuity(int handle) const { return handles_[handle].continuity; }

    /// Whether a vertex is in a part that no handle touches; such parts follow the incoming shape.
    bool is_idle(int vertex) const { return idle_[vertex]; }
    /// Whether the position of a vertex has to be solved for.
    bool is_free(int vertex) const { return hard_[vertex] < 0 && !idle_[vertex]; }
    std::vector<bool> free_vertices() const; ///< (n) is_free() of each

    /// A bind report with the counts of handles and vertices; the caller adds factorisations and time.
    BindReport report() const;

private:
    std::vector<Handle> handles_;
    std::vector<int> hard_;
    std::vector<SoftConstraint> soft_;
    std::vector<bool> idle_;
    int idle_parts_ = 0;
};

/// Where the handles want their vertices in one frame.
struct Targets
{
    const Poses& poses; ///< (k) of the handles
    PointsView rest;
    std::optional<PointsView> incoming; ///< the shape that entered this frame; without one, the rest shape
    /// (k) whether the pose of each handle applies to the rest shape; null: all apply to the incoming shape.
    const std::vector<bool>* from_rest = nullptr;

    PointsView base() const { return incoming ? *incoming : rest; }

    /// Where a handle wants a vertex: its pose, applied to the incoming position or to the rest position. The
    /// latter is for a handle whose control moves along with what deformed the incoming shape.
    Vector3 position(int vertex, int handle) const
    {
        const bool aims_from_rest = from_rest && (*from_rest)[handle];
        return apply(poses[handle], (aims_from_rest ? rest : base()).row(vertex).transpose());
    }

    /// \throw InvalidConstraint  the number of poses or flags is not the number of handles, a pose or an
    ///   incoming point is not finite, or `incoming` has another size than `rest`.
    void check(int handle_count) const;
};

} // namespace sinew

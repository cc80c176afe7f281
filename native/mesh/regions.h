// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/report.h"
#include "native/core/types.h"
#include "native/mesh/components.h"

#include <optional>
#include <vector>

namespace sinew {

/// One marked region. A fixed region is a handle whose pose is the identity.
struct Handle
{
    std::vector<int> vertices;
    /// One a vertex, in [0, 1]: 1 holds exactly, less pulls softly, 0 lets go. Empty: all 1.
    std::vector<double> weights;
    /// How smoothly the free surface leaves the region, 0 to 2 (C0 to C2), as far as the
    /// order of the energy allows; values between blend.
    double continuity = 2.0;

    bool operator==(const Handle&) const = default;
};

/// A soft constraint pulls a vertex with stiffness weight / (1 - weight), in units of the
/// vertex's own diagonal entry of the system.
struct SoftConstraint
{
    int vertex;
    int handle;
    double weight; ///< in (0, 1)

    double stiffness() const { return weight / (1.0 - weight); }
};

/// One vertex that one handle holds or pulls.
struct Constraint
{
    int vertex;
    int handle;
};

/// Handles over a mesh of n vertices, checked and turned into per-vertex constraints.
/// A vertex belongs to one hard handle at most; a hard constraint overrides soft ones; soft
/// ones of several handles add up.
class Regions
{
public:
    Regions() = default;

    /// \throw InvalidConstraint  a handle without vertices, an index out of range, weights of
    ///   another length, a weight outside [0, 1], a continuity outside [0, 2], or a vertex held
    ///   hard by two handles.
    Regions(std::vector<Handle> handles, const Components& parts);

    const std::vector<Handle>& handles() const { return handles_; }
    int handle_count() const { return static_cast<int>(handles_.size()); }
    int vertex_count() const { return static_cast<int>(hard_.size()); }

    /// The handle that holds a vertex exactly, or -1.
    int hard(int vertex) const { return hard_[vertex]; }
    const std::vector<SoftConstraint>& soft() const { return soft_; }
    /// All constraints: the hard ones by rising vertex, then those of soft() in their order.
    std::vector<Constraint> constraints() const;
    double continuity(int handle) const { return handles_[handle].continuity; }

    /// True in parts that no handle touches; they follow the incoming shape.
    bool is_idle(int vertex) const { return idle_[vertex]; }
    /// True where a position has to be solved for.
    bool is_free(int vertex) const { return hard_[vertex] < 0 && !idle_[vertex]; }

    /// The counts of a bind report; the caller adds its factorisations and its time.
    BindReport report() const;

private:
    std::vector<Handle> handles_;
    std::vector<int> hard_;
    std::vector<SoftConstraint> soft_;
    std::vector<bool> idle_;
    int idle_parts_ = 0;
};

/// What a surface method gets each frame besides the poses.
struct Targets
{
    const Poses& poses;
    PointsView rest;
    std::optional<PointsView> incoming;           ///< none: the rest shape comes in
    const std::vector<bool>* from_rest = nullptr; ///< per handle; null: all from incoming

    PointsView base() const { return incoming ? *incoming : rest; }

    /// Where handle `handle` wants vertex `vertex`: its pose applied to the incoming
    /// position, or to the rest position for a handle that rides on what moved the mesh.
    Vector3 of(int vertex, int handle) const
    {
        const bool aims_from_rest = from_rest && (*from_rest)[handle];
        return apply(poses[handle], (aims_from_rest ? rest : base()).row(vertex).transpose());
    }

    /// \throw InvalidConstraint  the number of poses or flags is not the number of handles, a
    ///   pose or incoming point is not finite, or incoming has another size than rest.
    void check(int handle_count) const;
};

} // namespace sinew

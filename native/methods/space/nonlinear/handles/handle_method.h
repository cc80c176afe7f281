// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/mesh/surface_mesh.h"
#include "native/methods/space/method.h"
#include "native/methods/space/nonlinear/handles/handle_control.h"

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace sinew {

/// For each place the point that is nearest to it, of equal ones the first. Cost: O(n) where all places are
/// points, else O(n) for each of the others.
std::vector<int> nearest_points(const Points& places, PointsView points);

/// A space method that handles move, with an energy of the shape in its space.
///
/// The control of warp() is (c, 3), the posed points of the handles, which are fitted with a motion per
/// handle; warp_poses() takes poses instead, so that single points turn, too. The answer depends on these and
/// on the incoming shape alone.
class HandleMethod : public SpaceMethod
{
public:
    const HandleControl& handles() const { return control_; }
    const SurfaceMesh& surface() const { return surface_; }

    /// warp() for poses (k), from object space to object space.
    /// \param from_rest  (k) whether the pose of each handle applies to the rest shape; empty where all apply
    ///                   to the shape that enters.
    /// \throw as warp()
    void warp_poses(const Poses& poses, const std::optional<PointsView>& incoming, PositionsOut out,
                    std::optional<Eigen::Index> room = {}, const std::vector<bool>& from_rest = {}) const;

    /// What moves the points between the handles: nodes, and which of them hold together.
    struct Network
    {
        Points nodes; ///< (m, 3)
        std::vector<std::array<int, 2>> links;
    };
    /// Where poses take the network of the last bind. \throw as warp_poses()
    Network network(const Poses& poses, const std::optional<PointsView>& incoming = {},
                    const std::vector<bool>& from_rest = {}) const;

    /// What a warp of the bound points reaches: iterations, energy and whether it converged.
    /// \throw as warp_poses()
    SolveReport report_for(const Poses& poses) const;

protected:
    /// \param surface  the shape that the space is built around, of any number of faces, also none.
    HandleMethod(SurfaceMesh surface, HandlePoints held);

    const Vector3& centre() const { return centre_; }
    double unit() const { return unit_; } ///< the size of the surface; 1 for a point
    Points in_unit(PointsView points) const { return (points.rowwise() - centre_.transpose()) / unit_; }
    SurfaceMesh surface_in_unit() const;

    /// As compute(). The last tick comes before anything of the object is changed.
    virtual void build(PointsView points, SpaceReport& report, const Progress& progress) = 0;
    /// Writes base + displacements for motions in the coordinates (x - centre) / unit.
    /// \param enters  whether `base` is another shape than the bound points.
    virtual SolveReport deform(const std::vector<HeldMotion>& motions, PointsView base, bool enters,
                               PositionsOut out) const = 0;
    virtual Network posed_network(const std::vector<HeldMotion>& motions, PointsView base,
                                  bool enters) const = 0;
    virtual void swap_binding(HandleMethod& other) = 0;

    void compute(PointsView points, SpaceReport& report, const Progress& progress) final;
    void displace(PointsView control, PointsView base, PositionsOut out) const final;
    void swap_weights(SpaceMethod& other) final;
    /// "surface" and "handles".
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;

private:
    void write(const std::vector<HeldMotion>& motions, PointsView base, PositionsOut out) const;
    std::vector<HeldMotion> aimed(const Poses& poses, PointsView base,
                                  const std::vector<bool>& from_rest) const;
    bool enters(PointsView base) const { return base.data() != points().data(); }

    SurfaceMesh surface_;
    Vector3 centre_;
    double unit_;
    HandleControl control_;
    std::vector<int> carriers_; ///< (c) the bound point nearest to each point of a handle; empty without any
};

} // namespace sinew

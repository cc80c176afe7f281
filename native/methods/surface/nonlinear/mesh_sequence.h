// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/surface/nonlinear/arap.h"
#include "native/methods/surface/nonlinear/sequence/edit_keys.h"
#include "native/methods/surface/nonlinear/sequence/handle_frames.h"

#include <functional>
#include <vector>

namespace sinew {

/// Edits of an animated mesh: handles are moved in some frames, and the frames between follow.
///
/// W. Xu, K. Zhou, Y. Yu, Q. Tan, Q. Peng, B. Guo. "Gradient Domain Editing of Deforming Mesh Sequences."
/// ACM TOG 26(3) (SIGGRAPH), 2007.
///
/// Each frame f of an animation is a shape a_f of the same faces. A handle h has a moving frame there: its
/// centre c and its turn Q from the rest shape (HandleFrames). Its edit E at f, y -> A y + m, comes from its
/// keys (EditKeys) and moves the points x of the handle to
///
///     c + Q E(Q^T (x - c)),
///
/// so an edit goes along with whatever carries the handle. The other points minimise the energy of Arap, with
/// the edges of a_f as its base. Where no handle is edited, a_f itself is that minimum.
///
/// Departs from the paper: it solves for all frames together, with a term that couples them in time. Here
/// each frame is solved by itself, from its own number, its shape and the keys; smoothness in time is that of
/// the edits, which are C1. So frames can be computed in any order, in parallel and on different machines,
/// and one factor serves all of them.
///
///   call            repeat it when ...            cost
///   constructor     as Arap                       as Arap
///   set_handles()   as Arap                       as Arap; once for all frames
///   solve_frame()   the frame or a key changed    one solve() of Arap
///   solve_frames()  likewise, for many frames     as many, several of them at once
///
/// solve() takes poses in object space, as that of any method, and knows of no frames.
class MeshSequence final : public Arap
{
public:
    explicit MeshSequence(const SurfaceMesh& rest, const ArapOptions& options = {});

    /// What a frame needs besides its number and the keys.
    ///
    /// The poses of `request` edit further, on top of the keys: as if the handle were the control that has
    /// moved, each pose turns and scales it about its centre, along the axes of the object, and moves it as
    /// far as the pose moves its centre at rest. Where `from_rest` is set, the pose is that of a control
    /// which follows the animation, and only what it does beyond the moving frame edits. The two edits
    /// multiply their turns and add their moves.
    ///
    /// \throw InvalidConstraint  see SurfaceMethod::solve(); or the keys name a handle that is not there.
    SolveReport solve_frame(double frame, const EditKeys& keys, const SolveRequest& request,
                            Points& positions) const;

    /// Many frames, several of them at once. Each is the same to the bit as by solve_frame(). A bind by
    /// another thread meanwhile comes between two frames.
    /// \param shapes  a_f, (n, 3) each, as many as there are frames.
    /// \param request  for all frames; `incoming` and `start` are not used.
    /// \param take  gets each frame by its place in `frames`, from any thread and in any order.
    /// \throw InvalidOption      another number of shapes than of frames.
    /// \throw InvalidConstraint  see solve_frame(); the message names the frame.
    /// \throw Cancelled          by the request's progress. Some frames may have been taken.
    std::vector<SolveReport>
    solve_frames(const std::vector<double>& frames, const EditKeys& keys,
                 const std::vector<PointsView>& shapes, const SolveRequest& request,
                 const std::function<void(int place, Points& positions)>& take) const;

    /// The whole edits in a frame (keys, and the poses of `request`) in the moving frames: what a new key at
    /// this frame holds. (k)
    Poses edits(double frame, const EditKeys& keys, const SolveRequest& request) const;
    /// The poses in object space, of the incoming points, to which solve_frame() moves the handles. (k)
    Poses poses(double frame, const EditKeys& keys, const SolveRequest& request) const;
    /// The poses that, given by `request`, edit nothing: the identity, and the moving frame where `from_rest`
    /// is set. (k)
    Poses still_poses(const SolveRequest& request) const;

protected:
    void bind(const Regions& regions, BindReport& report, const Progress& progress) override;
    void swap_binding(SurfaceMethod& other) override;

private:
    struct Moment;
    /// Checks the request, and sees where the handles are. The caller holds a lock, as for those below.
    Moment moment(const SolveRequest& request) const;
    void require_handles(const EditKeys& keys) const;

    HandleFrames frames_;
};

} // namespace sinew

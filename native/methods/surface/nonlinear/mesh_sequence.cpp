// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/mesh_sequence.h"

#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/core/system/jobs.h"

#include <atomic>
#include <cmath>
#include <string>
#include <thread>
#include <utility>

namespace sinew {

namespace {

using Frame = HandleFrames::Frame;

/// Turns the handle by `linear` about its centre, along the axes of the object, and moves the centre.
struct Change
{
    Matrix3 linear;
    Vector3 move;
};

void require_number(double frame)
{
    if (!std::isfinite(frame))
        throw InvalidConstraint("frame: not a finite number");
}

std::string named(double frame) { return "frame " + shortest(frame) + ": "; }

} // namespace

struct MeshSequence::Moment
{
    const SolveRequest& request;
    std::vector<Frame> frames, rest;

    bool aims_from_rest(std::size_t handle) const
    {
        return request.from_rest && (*request.from_rest)[handle];
    }

    /// By the keys and the pose of a handle together.
    Change change(std::size_t handle, double at, const EditKeys& keys) const
    {
        const Frame& now = frames[handle];
        const Pose& pose = request.poses[handle];
        const Vector3 moved = apply(pose, rest[handle].centre);
        Change change{pose.leftCols<3>(), moved - rest[handle].centre};
        if (aims_from_rest(handle)) {
            change.linear *= now.turn.transpose();
            change.move = moved - now.centre;
        }
        const Pose key = keys.at(static_cast<int>(handle), at);
        if (!key.leftCols<3>().isIdentity(0)) // so that no key changes no bit
            change.linear *= now.turn * key.leftCols<3>() * now.turn.transpose();
        change.move += now.turn * key.col(3);
        return change;
    }
};

MeshSequence::MeshSequence(const SurfaceMesh& rest, const ArapOptions& options) : Arap(rest, options) {}

void MeshSequence::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    HandleFrames frames(rest(), regions);
    Arap::bind(regions, report, progress);
    frames_ = std::move(frames);
}

void MeshSequence::swap_binding(SurfaceMethod& other)
{
    Arap::swap_binding(other);
    std::swap(frames_, static_cast<MeshSequence&>(other).frames_);
}

MeshSequence::Moment MeshSequence::moment(const SolveRequest& request) const
{
    const Targets targets{request.poses, view(rest().points()), request.incoming,
                          request.from_rest ? &*request.from_rest : nullptr};
    targets.check(regions().handle_count());
    return {request, frames_.at(request.incoming ? &*request.incoming : nullptr), frames_.at(nullptr)};
}

void MeshSequence::require_handles(const EditKeys& keys) const
{
    if (keys.handle_count() > regions().handle_count())
        throw InvalidConstraint("keys: there is no handle " + std::to_string(keys.handle_count() - 1) +
                                "; the mesh has " + std::to_string(regions().handle_count()));
}

Poses MeshSequence::edits(double frame, const EditKeys& keys, const SolveRequest& request) const
{
    require_number(frame);
    const AccessLock shared = reading();
    require_handles(keys);
    const Moment now = moment(request);
    Poses edits(request.poses.size());
    for (std::size_t h = 0; h < edits.size(); ++h) {
        const Change change = now.change(h, frame, keys);
        const Matrix3& Q = now.frames[h].turn;
        edits[h] << Q.transpose() * change.linear * Q, Q.transpose() * change.move;
    }
    return edits;
}

Poses MeshSequence::still_poses(const SolveRequest& request) const
{
    const AccessLock shared = reading();
    const Moment now = moment(request);
    Poses poses(request.poses.size());
    for (std::size_t h = 0; h < poses.size(); ++h) {
        const Frame& frame = now.frames[h];
        if (now.aims_from_rest(h))
            poses[h] << frame.turn, frame.centre - frame.turn * now.rest[h].centre;
        else
            poses[h] << Matrix3::Identity(), Vector3::Zero();
    }
    return poses;
}

Poses MeshSequence::poses(double frame, const EditKeys& keys, const SolveRequest& request) const
{
    require_number(frame);
    const AccessLock shared = reading();
    require_handles(keys);
    const Moment now = moment(request);
    Poses poses(request.poses.size());
    for (std::size_t h = 0; h < poses.size(); ++h) {
        const Change change = now.change(h, frame, keys);
        const Vector3& centre = now.frames[h].centre;
        poses[h] << change.linear, centre - change.linear * centre + change.move;
    }
    return poses;
}

SolveReport MeshSequence::solve_frame(double frame, const EditKeys& keys, const SolveRequest& request,
                                      Points& positions) const
{
    const AccessLock shared = reading(); // so that both calls see the same handles
    SolveRequest moved = request;
    moved.poses = poses(frame, keys, request);
    moved.from_rest.reset();
    return solve(moved, positions);
}

std::vector<SolveReport>
MeshSequence::solve_frames(const std::vector<double>& frames, const EditKeys& keys,
                           const std::vector<PointsView>& shapes, const SolveRequest& request,
                           const std::function<void(int place, Points& positions)>& take) const
{
    if (shapes.size() != frames.size())
        throw InvalidOption("shapes: " + std::to_string(shapes.size()) + " given for " +
                            std::to_string(frames.size()) + " frames");
    const int count = static_cast<int>(frames.size());
    std::vector<SolveReport> reports(count);
    std::atomic<int> done = 0;
    const std::thread::id caller = std::this_thread::get_id();
    parallel_jobs(count, [&](int k) {
        if (std::this_thread::get_id() == caller)
            request.progress.tick(static_cast<double>(done) / count, "solving the frames");
        SolveRequest one{.poses = request.poses,
                         .incoming = shapes[k],
                         .from_rest = request.from_rest,
                         .max_iterations = request.max_iterations,
                         .tolerance = request.tolerance};
        Points positions;
        try {
            reports[k] = solve_frame(frames[k], keys, one, positions);
        } catch (const InvalidConstraint& error) {
            throw InvalidConstraint(named(frames[k]) + error.what(), error.element_kind(), error.elements());
        }
        take(k, positions);
        ++done;
    });
    request.progress.tick(1.0, "solved the frames");
    return reports;
}

} // namespace sinew

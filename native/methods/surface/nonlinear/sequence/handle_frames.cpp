// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/nonlinear/sequence/handle_frames.h"

#include "native/core/dense.h"
#include "native/handles/map_blend.h"
#include "native/operators/fits/rotation_fit.h"

#include <utility>

namespace sinew {

namespace {

/// A patch is a line where its second extent is below this share of its first one, as squares.
constexpr double line = 1e-12;

template <class Shape>
Vector3 mean(const Shape& points, const std::vector<int>& of)
{
    Vector3 sum = Vector3::Zero();
    for (int v : of)
        sum += points.row(v).transpose();
    return sum / static_cast<double>(of.size());
}

} // namespace

HandleFrames::HandleFrames(const SurfaceMesh& rest, const Regions& regions)
{
    std::vector<std::vector<int>> patches = handle_patches(rest, regions);
    for (int h = 0; h < regions.handle_count(); ++h) {
        const Handle& handle = regions.handles()[h];
        Member member;
        for (std::size_t k = 0; k < handle.vertices.size(); ++k)
            if (handle.weights.empty() || handle.weights[k] > 0)
                member.vertices.push_back(handle.vertices[k]);
        if (member.vertices.empty()) // all its weights are 0
            member.vertices = handle.vertices;
        member.rest_centre = mean(rest.points(), member.vertices);

        std::vector<int>& patch = patches[h];
        if (!patch.empty()) {
            const Vector3 centre = mean(rest.points(), patch);
            member.spokes.resize(static_cast<int>(patch.size()), 3);
            for (std::size_t k = 0; k < patch.size(); ++k)
                member.spokes.row(static_cast<int>(k)) = rest.points().row(patch[k]) - centre.transpose();
            const Matrix3 extent = member.spokes.transpose() * member.spokes;
            const Vector3 squares = eigenvectors(extent).values;
            if (squares[1] > line * squares[2])
                member.patch = std::move(patch);
        }
        members_.push_back(std::move(member));
    }
}

std::vector<HandleFrames::Frame> HandleFrames::at(const PointsView* shape) const
{
    std::vector<Frame> frames;
    for (const Member& member : members_) {
        Frame frame{Matrix3::Identity(), member.rest_centre};
        if (shape) {
            frame.centre = mean(*shape, member.vertices);
            Matrix3 S = Matrix3::Zero();
            const Vector3 centre = member.patch.empty() ? Vector3::Zero() : mean(*shape, member.patch);
            for (std::size_t k = 0; k < member.patch.size(); ++k)
                S += (shape->row(member.patch[k]).transpose() - centre) *
                     member.spokes.row(static_cast<int>(k));
            const double largest = S.cwiseAbs().maxCoeff(); // whose square may be no number any more
            if (largest > 0)
                frame.turn = fit_rotation(S / largest);
        }
        frames.push_back(frame);
    }
    return frames;
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/vector_field.h"

#include "native/core/dense.h"
#include "native/core/errors.h"
#include "native/core/finite.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/operators/fits/rotation_fit.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

namespace sinew {

namespace {

constexpr double unturned = 1e-13;  // an angle that rounding alone explains

const FieldKernels& kernels() { return widest_kernels<FieldKernels>(); }

/// Axis times angle, at most half a turn.
Vector3 turn_of(const Matrix3& rotation)
{
    const Eigen::AngleAxisd turn(rotation);
    return turn.angle() < unturned ? Vector3::Zero() : Vector3(turn.angle() * turn.axis());
}

Matrix3 rotation_by(const Vector3& turn)
{
    const double angle = turn.norm();
    return angle == 0.0 ? Matrix3::Identity() : Eigen::AngleAxisd(angle, turn / angle).toRotationMatrix();
}

/// From one unit vector to another. For opposite ones, any way will do.
Matrix3 shortest_turn(const Vector3& from, const Vector3& to)
{
    return smallest_turn(from, to).normalized().toRotationMatrix();
}

/// The angle of the part of a rotation that turns about an axis, in (-pi, pi].
double twist_of(const Matrix3& rotation, const Vector3& axis)
{
    const Eigen::Quaterniond q(rotation);
    double half = std::atan2(q.vec().dot(axis), q.w());
    constexpr double pi = 3.14159265358979323846;
    if (half > 0.5 * pi)
        half -= pi;
    else if (half <= -0.5 * pi)
        half += pi;
    return 2.0 * half;
}

void put(double (&to)[3], const Vector3& from) { Vector3::Map(to) = from; }

/// b(u)
double blend(double u)
{
    u = std::clamp(u, 0.0, 1.0);
    return u * u * (u * (4.0 - 3.0 * u));
}

/// How much of a twist reaches a point at y from its centre.
double twisted_share(const FieldPiece& piece, const Vector3& y)
{
    const Vector3 axis = Vector3::Map(piece.axis);
    const double height = axis.dot(y), distance = (y - height * axis).norm();
    return blend((height - piece.inner[0]) / (piece.outer[0] - piece.inner[0])) *
           (1.0 - blend(distance / piece.width - 1.0));
}

template <class Value>
std::vector<Value> per_tool(std::vector<Value> values, std::size_t tools, const char* name)
{
    if (values.size() == 1)
        values.resize(tools, values.front());
    if (values.size() != tools)
        throw InvalidOption(std::string(name) + ": give one value, or one for each of the " +
                            std::to_string(tools) + " tools");
    return values;
}

} // namespace

VectorField::VectorField(Points frames, const VectorFieldOptions& options)
    : SpaceMethod("tools"), frames_(std::move(frames)), options_(options)
{
    if (!all_finite(frames_))
        throw InvalidConstraint("a number of the frames of tools is not finite");
    if (frames_.rows() == 0 || frames_.rows() % 4 != 0)
        throw InvalidOption("a frame is four points, and " + std::to_string(frames_.rows()) + " are given");
    require_valid(options);
    if (options.order == 3)
        throw InvalidOption("order: 3 is not 1, 2 or 4");
    if (options_.counts.empty())
        options_.counts = {static_cast<int>(frames_.rows() / 4)};
    add_tools();
}

void VectorField::add_tools()
{
    const std::size_t count = options_.counts.size();
    options_.tools = per_tool(options_.tools, count, "tools");
    options_.inner = per_tool(options_.inner, count, "inner");
    options_.outer = per_tool(options_.outer, count, "outer");
    options_.width = per_tool(options_.width, count, "width");
    std::vector<int> differing, flat;
    int begin = 0;
    for (std::size_t k = 0; k < count; ++k) {
        const int frames = options_.counts[k];
        const double inner = options_.inner[k], outer = options_.outer[k];
        if (frames < 1 || frames > frames_.rows() / 4 - begin)
            throw InvalidOption("counts: tool " + std::to_string(k) + " needs at least one frame, and " +
                                std::to_string(frames_.rows() / 4) + " are given for all tools");
        if (!(std::isfinite(outer) && std::isfinite(inner) && inner < outer))
            throw InvalidOption("tool " + std::to_string(k) + ": inner must be less than outer");
        if (options_.tools[k] == FieldTool::drag && inner < 0.0)
            throw InvalidOption("tool " + std::to_string(k) + ": inner must not be negative for a drag");
        if (!(std::isfinite(options_.width[k]) && options_.width[k] > 0.0))
            throw InvalidOption("tool " + std::to_string(k) + ": width must be positive");
        const auto first = frames_.middleRows<4>(4 * begin);
        for (int f = 1; f < frames; ++f)
            if (frames_.middleRows<4>(4 * (begin + f)) != first) {
                differing.push_back(static_cast<int>(k));
                break;
            }
        const Matrix3 axes = (first.bottomRows<3>().rowwise() - first.row(0)).transpose();
        if (!(std::abs(axes.determinant()) > 1e-9 * std::pow(axes.norm(), 3)))
            flat.push_back(static_cast<int>(k));
        tools_.push_back({begin, frames, options_.tools[k], inner, outer, options_.width[k], axes.inverse(),
                          axes.col(2).stableNormalized()});
        begin += frames;
    }
    if (4 * begin != frames_.rows())
        throw InvalidOption("counts: " + std::to_string(begin) + " frames are counted, and " +
                            std::to_string(frames_.rows() / 4) + " are given");
    if (!differing.empty())
        throw InvalidConstraint("the frames of tools " + list_some(differing) + " differ at rest",
                                Error::Element::handle, differing);
    if (!flat.empty())
        throw InvalidConstraint("tools " + list_some(flat) + " are flat", Error::Element::handle, flat);
}

void VectorField::compute(PointsView points, SpaceReport& report, const Progress& progress)
{
    report.weight_bytes = static_cast<std::int64_t>(sizeof(double)) * points.size();
    require_memory(report.weight_bytes, "a copy of the points");
    progress.tick(0.0, "copying the points");
    progress.tick(1.0, "copying the points");
}

VectorField::Frame VectorField::frame(const Tool& tool, PointsView control, int number) const
{
    const auto rows = control.middleRows<4>(4 * (tool.begin + number));
    const Matrix3 axes = (rows.bottomRows<3>().rowwise() - rows.row(0)).transpose();
    const Matrix3 map = axes * tool.to_rest;
    return {fit_rotation_svd(map), rows.row(0).transpose(), std::cbrt(std::abs(map.determinant()))};
}

VectorField::Stage VectorField::bend(const Tool& tool, const Matrix3& bent, const Matrix3& end,
                                     const Vector3& from, const Vector3& to) const
{
    const auto halfway = [&](const Matrix3& all) -> Vector3 {
        return rotation_by(0.5 * turn_of(all)) * tool.axis;
    };
    Stage stage;
    stage.piece.bends = true;
    put(stage.piece.centre, frames_.row(4 * tool.begin).transpose());
    const Vector3 turn = turn_of(shortest_turn(from, to)), begin = halfway(bent), last = halfway(end);
    put(stage.piece.turn, turn);
    const Vector3 side = last - last.dot(begin) * begin;
    stage.piece.angle = std::atan2(side.norm(), last.dot(begin));
    put(stage.piece.axis, begin);
    put(stage.piece.side, side.stableNormalized());
    put(stage.piece.own_axis, from);
    put(stage.piece.own_side, turn.cross(from).stableNormalized());
    stage.piece.own_angle = turn.norm();
    stage.piece.inner[0] = tool.inner;
    stage.piece.outer[0] = tool.outer;
    stage.piece.width = tool.width;
    stage.turn = rotation_by(turn);
    finish(tool, turn.norm() * (2.0 * tool.outer + tool.width), stage);
    return stage;
}

VectorField::Stage VectorField::drag(const Tool& tool, const Frame& from, const Frame& to) const
{
    Stage stage;
    const Vector3 move = to.centre - from.centre, turn = turn_of(to.turn * from.turn.transpose());
    put(stage.piece.centre, from.centre);
    put(stage.piece.move, move);
    put(stage.piece.turn, turn);
    const auto length = [&](double (&pair)[2], double rest) {
        // A tool that is scaled to nothing would have no region to blend in.
        const double least = 1e-9;
        pair[0] = rest * std::max(from.scale, least);
        pair[1] = rest * std::max(to.scale, least) - pair[0];
    };
    length(stage.piece.inner, tool.inner);
    length(stage.piece.outer, tool.outer);
    stage.turn = rotation_by(turn);
    finish(tool, move.norm() + turn.norm() * tool.outer, stage);
    return stage;
}

void VectorField::finish(const Tool& tool, double motion, Stage& stage) const
{
    const double inner = stage.piece.inner[0], outer = stage.piece.outer[0];
    stage.most_outer = std::max(outer, outer + stage.piece.outer[1]);
    stage.least_inner = std::min(inner, inner + stage.piece.inner[1]);
    // A step crosses no more than the width of the blend, or it would not see it.
    const double width = std::min(outer - inner, outer + stage.piece.outer[1] - inner - stage.piece.inner[1]);
    const double needed = std::ceil(motion / width);
    stage.steps = options_.steps ? options_.steps : static_cast<int>(std::clamp(needed, 1.0, 1024.0));
    stage.tolerance = options_.tolerance * tool.outer;
}

void VectorField::add_stages(const Tool& tool, PointsView control, std::vector<Stage>& found) const
{
    const auto moved = [&](int number) { // the frame differs from the one before, or from rest
        const auto before = number ? PointsView(control.data() + 12 * (tool.begin + number - 1), 4, 3)
                                   : PointsView(frames_.data() + 12 * tool.begin, 4, 3);
        return before != control.middleRows<4>(4 * (tool.begin + number));
    };
    const Frame rest{Matrix3::Identity(), frames_.row(4 * tool.begin).transpose(), 1.0};
    Frame last = rest;
    Matrix3 bent = Matrix3::Identity(); // a bend: the shortest turns of the axis so far, all together
    double twist = 0.0;
    for (int number = 0; number < tool.count; ++number) {
        if (!moved(number))
            continue;
        const Frame next = frame(tool, control, number);
        if (tool.kind == FieldTool::drag) {
            found.push_back(drag(tool, last, next));
        } else if (tool.kind == FieldTool::twist) {
            twist += twist_of(last.turn.transpose() * next.turn, tool.axis);
        } else if (const Vector3 from = last.turn * tool.axis, to = next.turn * tool.axis;
                   (to - from).norm() > unturned) {
            const Matrix3 end = shortest_turn(from, to) * bent;
            found.push_back(bend(tool, bent, end, from, to));
            bent = end;
        }
        last = next;
    }
    if (tool.kind == FieldTool::twist && std::abs(twist) > unturned) {
        Stage stage;
        stage.twists = true;
        put(stage.piece.centre, rest.centre);
        put(stage.piece.axis, tool.axis);
        stage.piece.angle = twist;
        stage.piece.inner[0] = tool.inner;
        stage.piece.outer[0] = tool.outer;
        stage.piece.width = tool.width;
        found.push_back(stage);
    }
}

std::vector<VectorField::Stage> VectorField::stages(PointsView control) const
{
    if (control.rows() != frames_.rows())
        throw InvalidConstraint("the paths of the tools have " + std::to_string(frames_.rows()) +
                                " points, and " + std::to_string(control.rows()) + " are given");
    if (!all_finite(control))
        throw InvalidConstraint("a number of the frames of tools is not finite");
    std::vector<Stage> found;
    for (const Tool& tool : tools_)
        add_stages(tool, control, found);
    return found;
}

void VectorField::move(const Stage& stage, int count, double* points) const
{
    const int lanes = kernels().lanes;
    const FieldPiece& piece = stage.piece;
    const auto point = [&](const double* of, int lane) {
        return Vector3(of[lane], of[lanes + lane], of[2 * lanes + lane]);
    };
    const auto set = [&](double* of, int lane, const Vector3& x) {
        for (int k = 0; k < 3; ++k)
            of[k * lanes + lane] = x[k];
    };
    const Vector3 centre = Vector3::Map(piece.centre), way = Vector3::Map(piece.move);
    if (stage.twists) {
        const Vector3 axis = Vector3::Map(piece.axis);
        for (int lane = 0; lane < count; ++lane) {
            const Vector3 y = point(points, lane) - centre;
            const double share = twisted_share(piece, y);
            if (share > 0.0)
                set(points, lane, centre + Eigen::AngleAxisd(share * piece.angle, axis) * y);
        }
        return;
    }
    unsigned waiting = 0; // bit k: the end of point k is not known yet
    std::array<double, 3 * most_field_lanes> end;
    std::copy(points, points + 3 * lanes, end.begin());
    for (int lane = 0; lane < count; ++lane) {
        const Vector3 y = point(points, lane) - centre;
        const double square = way.squaredNorm();
        const double along = square > 0.0 ? std::clamp(y.dot(way) / square, 0.0, 1.0) : 0.0;
        if (!piece.bends && (y - along * way).norm() >= stage.most_outer)
            continue; // it is never reached
        if (!piece.bends && y.norm() <= stage.least_inner)
            set(points, lane, centre + way + stage.turn * y);
        else
            waiting |= 1u << lane;
    }
    if (!waiting)
        return;
    if (options_.steps)
        kernels().flow(piece, options_.steps, options_.order, end.data());
    else
        kernels().flow_to(piece, stage.steps, stage.tolerance, end.data());
    for (int lane = 0; lane < count; ++lane)
        if (waiting >> lane & 1u)
            set(points, lane, point(end.data(), lane));
}

void VectorField::displace(PointsView control, PointsView base, PositionsOut out) const
{
    const std::vector<Stage> path = stages(control);
    const int lanes = kernels().lanes, count = static_cast<int>(base.rows());
    const Points& rest = points();
    std::visit(
        [&](auto* positions) {
            using Number = std::remove_pointer_t<decltype(positions)>;
            parallel_chunks((count + lanes - 1) / lanes, 32, [&](int from, int to) {
                for (int group = from; group < to; ++group) {
                    const int first = group * lanes, some = std::min(lanes, count - first);
                    std::array<double, 3 * most_field_lanes> places;
                    for (int lane = 0; lane < lanes; ++lane)
                        for (int k = 0; k < 3; ++k)
                            places[static_cast<std::size_t>(k * lanes + lane)] =
                                rest(first + std::min(lane, some - 1), k);
                    for (const Stage& stage : path)
                        move(stage, some, places.data());
                    for (int lane = 0; lane < some; ++lane)
                        for (int k = 0; k < 3; ++k) {
                            const double moved =
                                places[static_cast<std::size_t>(k * lanes + lane)] - rest(first + lane, k);
                            positions[3 * static_cast<std::size_t>(first + lane) + k] =
                                static_cast<Number>(base(first + lane, k) + moved);
                        }
                }
            });
        },
        out);
}

int VectorField::piece_count(PointsView control) const { return static_cast<int>(stages(control).size()); }

Points VectorField::velocities(PointsView control, int piece, double time, PointsView points) const
{
    const std::vector<Stage> path = stages(control);
    if (piece < 0 || piece >= static_cast<int>(path.size()))
        throw InvalidConstraint("the tools have " + std::to_string(path.size()) + " pieces, and no piece " +
                                std::to_string(piece));
    const Stage& stage = path[static_cast<std::size_t>(piece)];
    const int lanes = kernels().lanes;
    Points found(points.rows(), 3);
    for (int i = 0; i < points.rows(); ++i) {
        if (stage.twists) {
            const Vector3 axis = Vector3::Map(stage.piece.axis);
            const Vector3 y = points.row(i).transpose() - Vector3::Map(stage.piece.centre);
            found.row(i) = (twisted_share(stage.piece, y) * stage.piece.angle * axis.cross(y)).transpose();
            continue;
        }
        std::array<double, 3 * most_field_lanes> x, v;
        for (int k = 0; k < 3; ++k)
            for (int lane = 0; lane < lanes; ++lane)
                x[static_cast<std::size_t>(k * lanes + lane)] = points(i, k);
        kernels().velocity(stage.piece, time, x.data(), v.data());
        for (int k = 0; k < 3; ++k)
            found(i, k) = v[static_cast<std::size_t>(k * lanes)];
    }
    return found;
}

std::vector<std::string> VectorField::changed_settings(const SpaceMethod& former) const
{
    const auto& other = static_cast<const VectorField&>(former);
    return changed(
        options_, other.options_,
        names_of({{"frames", !same(frames_, other.frames_) || options_.counts != other.options_.counts}}));
}

} // namespace sinew

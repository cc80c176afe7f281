// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/bodies/body_problem.h"

#include "native/core/parallel.h"
#include "native/core/simd/kernel_set.h"
#include "native/local_global/arap/cell_fits.h"

#include <array>
#include <numeric>

namespace sinew {

BodyProblem::BodyProblem(const ArapSystem& graph, const RigidBodies& bodies,
                         const std::vector<double>& numbers, const Points& centres, const Points& pulls,
                         BodyBuffers* buffers)
    : graph_(graph), bodies_(bodies), kernels_(widest_kernels<BodyKernels>()), pulls_(pulls),
      own_buffers_(buffers ? nullptr : std::make_unique<BodyBuffers>()),
      buffers_(buffers ? *buffers : *own_buffers_), view_(bodies.view())
{
    pack(sinew::view(centres), buffers_.points);
    for (std::vector<double>& rotations : buffers_.rotations)
        rotations.resize(entries * static_cast<std::size_t>(bodies.size()) + 1);
    buffers_.energies.resize((bodies.free_count() + graph_chunk - 1) / graph_chunk);
    buffers_.torque.resize(bodies.free_count(), 3);
    view_.joints = numbers.data();
    view_.points = buffers_.points.data();
    parallel_for(bodies.size(), [&](int i) { set_rotation(i, Matrix3::Identity()); });
}

Matrix3 BodyProblem::rotation(int body) const
{
    return Eigen::Map<const Matrix3>(buffers_.rotations[current_].data() +
                                     entries * static_cast<std::size_t>(body));
}

void BodyProblem::set_rotation(int body, const Matrix3& R)
{
    for (std::vector<double>& rotations : buffers_.rotations)
        Eigen::Map<Matrix3>(rotations.data() + entries * static_cast<std::size_t>(body)) = R;
}

void BodyProblem::move_to(const Points& x)
{
    parallel_chunks(bodies_.free_count(), 16384, [&](int begin, int end) {
        std::copy(x.data() + 3 * static_cast<std::size_t>(begin),
                  x.data() + 3 * static_cast<std::size_t>(end),
                  buffers_.points.data() + 3 * static_cast<std::size_t>(begin));
    });
}

PointsView BodyProblem::place(const Points& x)
{
    move_to(x);
    return {buffers_.points.data(), bodies_.size(), 3};
}

int BodyProblem::spare() const
{
    int set = 0;
    while (set == kept_ || set == current_)
        ++set;
    return set;
}

template <class Body>
void BodyProblem::each_chunk(Body&& body) const
{
    parallel_chunks(bodies_.free_count(), graph_chunk, body);
}

void BodyProblem::settle()
{
    const ArapKernels& fits = widest_kernels<ArapKernels>();
    Points& torque = buffers_.torque;
    for (int sweep = 0; sweep < bodies_.sweeps(); ++sweep) {
        const double* const before = buffers_.rotations[current_].data();
        each_chunk([&](int begin, int end) {
            std::array<double, chunk_numbers> S;
            kernels_.covariances(view_, begin, end, before, S.data());
            kernels_.torques(S.data(), before + entries * static_cast<std::size_t>(begin), end - begin,
                             torque.data() + 3 * static_cast<std::size_t>(begin));
        });
        bodies_.rotation_factor().solve(torque, torque);
        current_ = spare();
        double* const turned = buffers_.rotations[current_].data();
        each_chunk([&](int begin, int end) {
            const std::size_t first = entries * static_cast<std::size_t>(begin);
            fits.turn(torque.data() + 3 * static_cast<std::size_t>(begin), before + first, end - begin,
                      turned + first);
        });
        current_ = spare();
        double* const after = buffers_.rotations[current_].data();
        each_chunk([&](int begin, int end) {
            const std::size_t first = entries * static_cast<std::size_t>(begin);
            std::array<double, chunk_numbers> S;
            kernels_.covariances(view_, begin, end, turned, S.data());
            fit_cells(S.data(), turned + first, tie, end - begin, after + first);
        });
    }
}

double BodyProblem::energy_and_gradient(Points& gradient) const
{
    gradient.resize(bodies_.free_count(), 3);
    std::vector<double>& energies = buffers_.energies;
    each_chunk([&](int begin, int end) {
        energies[begin / graph_chunk] =
            kernels_.energy(view_, begin, end, buffers_.rotations[current_].data(),
                            gradient.data() + 3 * static_cast<std::size_t>(begin));
    });
    double energy = 0.5 * std::accumulate(energies.begin(), energies.end(), 0.0);
    for (std::size_t k = 0; k < graph_.nodes().pulls().size(); ++k) {
        const GraphPull& pull = graph_.nodes().pulls()[k];
        const Eigen::RowVector3d gap = Eigen::Map<const Eigen::RowVector3d>(
                                           buffers_.points.data() + 3 * static_cast<std::size_t>(pull.node)) -
                                       pulls_.row(static_cast<Eigen::Index>(k));
        energy += 0.5 * pull.stiffness * gap.squaredNorm();
        gradient.row(pull.node) += pull.stiffness * gap;
    }
    return energy;
}

double BodyProblem::evaluate(const Points& x, Points& gradient)
{
    move_to(x);
    settle();
    return energy_and_gradient(gradient);
}

void BodyProblem::centres_for_rotations(Points& x)
{
    Points& gradient = buffers_.gradient;
    x = PointsView(buffers_.points.data(), bodies_.free_count(), 3);
    for (int k = 0; k < 2; ++k) { // the factor is in single precision, so each solve leaves a millionth
        energy_and_gradient(gradient);
        graph_.position_factor().solve(gradient, gradient);
        x -= gradient;
        move_to(x);
    }
}

} // namespace sinew

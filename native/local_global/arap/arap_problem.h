// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/types.h"
#include "native/local_global/arap/arap_system.h"
#include "native/local_global/arap/cluster_motions.h"
#include "native/solvers/optimization/metric_lbfgs.h"

#include <cstddef>
#include <functional>
#include <memory>
#include <vector>

namespace sinew {

/// The workspace of a ArapProblem. If it is kept from one solve to the next, it is not allocated again.
struct ArapBuffers
{
    std::vector<double> base, points; ///< three numbers per node
    /// Nine numbers per node. With smoothing, one of the three holds the rotations that keep_state() keeps.
    std::vector<double> rotations[3];
    std::vector<double> covariances; ///< only with smoothing
    Points torque, gradient;
    std::vector<double> energies; ///< one per chunk
    ClusterMotions::Motion motion;
    Points better, better_gradient;
};

/// The function F = E / energy_factor() of the free positions on one graph. It has the rotations as its
/// state, and every evaluation fits them to the positions.
class ArapProblem final : public MetricProblem
{
public:
    /// \param base     (size, 3) the shape whose edges are kept as rigid as possible.
    /// \param targets  (size, 3) where held nodes are to be; base for the idle ones; free ones are not read.
    /// \param pulls    (pulls, 3) where the soft pulls pull their nodes.
    /// \param buffers  the workspace, which may be that of an earlier problem; null for one of its own.
    ArapProblem(const ArapSystem& graph, const PointsView& base, const Points& targets, const Points& pulls,
                ArapBuffers* buffers = nullptr);

    Matrix3 rotation(int i) const;
    /// For nodes in moving chunks at any time; for others before the first evaluation, which fits these once
    /// and for all.
    void set_rotation(int i, const Matrix3& R);

    /// Finds the free positions that minimise E for the current rotations, to the millionth that a factor in
    /// single precision leaves; where the shape is nearly rigid, to the square of that.
    void global_step(Points& x);
    Points global_step()
    {
        Points x;
        global_step(x);
        return x;
    }
    /// Fits the rotation of each cell to the positions alone, without smoothing.
    void local_step(const Points& x);

    /// Iterations that take the place of factors tick here; it must live as long as this.
    void watch(const Progress& progress) { progress_ = &progress; }

    int free_count() const { return graph_.free_count(); }

    double evaluate(const Points& x, Points& gradient) override;
    void precondition(const Points& gradient, Points& z) const override;
    /// From now on, improve() takes a step of these motions, shorter until the energy falls. It comes after
    /// evaluate(), whose covariances it uses, and fits no rotations.
    void improve_by(const ClusterMotions& motions) { motions_ = &motions; }
    bool improve(Points& x, Points& gradient, double& F) override;
    bool go_on(const Points& from, double F_from, double share, Points& x, Points& gradient,
               double& F) override;
    /// Without smoothing, rotations depend on the positions alone; they are not kept, but fitted again.
    void keep_state() override { kept_ = graph_.is_smooth() ? current_ : -1; }
    void restore_state() override
    {
        if (graph_.is_smooth())
            current_ = kept_;
        else
            stale_ = true;
    }
    /// Makes rotation() valid again after restore_state().
    /// \param x  the free positions that belong to the restored state.
    void refresh(const Points& x)
    {
        if (stale_)
            local_step(x);
    }

    /// The positions of all nodes, with the free ones at x.
    PointsView place(const Points& x);
    /// The rows of the free nodes.
    Points free_rows(const PointsView& all) const { return all.topRows(graph_.free_count()); }

private:
    using Matrices = std::vector<double>;

    void move_to(const Points& x);
    /// The index of one of the three sets of rotations that is neither kept nor `used`.
    int spare(int used) const;
    /// The energy at buffers_.better, and its gradient. With smoothing, the cells turn by buffers_.torque from the
    /// rotations `before`; without it, they are fitted.
    double try_better(int before);
    /// Takes what try_better() has tried. Returns true.
    bool accept(double F_better, Points& x, Points& gradient, double& F);
    /// Takes the positions and rotations from before it.
    void return_to(int before, const Points& x);
    void for_each_moving(const std::function<void(const GraphChunk&)>& body) const;
    void fit(const GraphChunk& chunk, const double* S, const Matrices& before, double tie,
             Matrices& after) const;
    void fit_fixed_cells();
    double* covariances_of(const GraphChunk& chunk) const;
    void turn_rotation_field();
    double energy_and_gradient(Points& gradient) const;

    inline static const Progress silent{};

    const ArapSystem& graph_;
    const ArapKernels& kernels_;
    const Points& pulls_;
    std::unique_ptr<ArapBuffers> own_buffers_;
    ArapBuffers& buffers_;
    const ClusterMotions* motions_ = nullptr;
    const Progress* progress_ = &silent;
    GraphView view_;
    int current_ = 0, kept_ = -1;
    bool fixed_cells_fitted_ = false, stale_ = false;
    double energy_of_fixed_cells_ = 0.0; ///< of the cells that depend on no free node
};

} // namespace sinew

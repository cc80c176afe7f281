// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/coarse_start.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"
#include "native/local_global/arap/mesh_graph.h"
#include "native/local_global/graph/rotations.h"

#include <numeric>
#include <utility>

namespace sinew {

CoarseStart::CoarseStart(const SurfaceMesh& mesh, const Regions& regions, double smoothing,
                         std::vector<double> rigidity, const Progress& progress)
    : vertex_count_(mesh.vertex_count())
{
    GraphEdges edges = cotan_edges(mesh);
    GraphCells cells;
    cells.smoothing = smoothing;
    cells.rigidity = rigidity.empty() ? std::vector<double>(vertex_count_, 1.0) : std::move(rigidity);
    GraphHandles handles(regions, [&, laplacian = cells.laplacian(edges)](int vertex) {
        return std::accumulate(laplacian.begin() + edges.offsets[vertex],
                               laplacian.begin() + edges.offsets[vertex + 1], 0.0);
    });
    build({std::move(edges), std::move(handles)}, cells, mesh.points(), progress);
}

CoarseStart::CoarseStart(const HandleGraph& nodes, const GraphCells& cells, const Points& rest,
                         const Progress& progress)
    : vertex_count_(nodes.size())
{
    build(nodes, cells, rest, progress);
}

void CoarseStart::build(const HandleGraph& nodes, const GraphCells& cells, const Points& rest,
                        const Progress& progress)
{
    if (nodes.free_count() == 0)
        return;
    level_ = RotationLevel::coarser(nodes, cells, rest);
    if (level_) {
        below_ = MultilevelStart(level_->graph, level_->rest, progress);
        return;
    }
    mesh_.emplace(nodes, cells, rest);
    mesh_rest_ = rest(mesh_->order(), Eigen::all);
    below_ = MultilevelStart(*mesh_, mesh_rest_, progress);
}

void CoarseStart::rotations(const Targets& targets, Workspace& work,
                            std::vector<Eigen::Quaterniond>& vertices) const
{
    vertices.assign(vertex_count_, Eigen::Quaterniond::Identity());
    if (!level_ && !mesh_)
        return;
    Targets local{targets.poses, view(level_ ? level_->rest : mesh_rest_), {}, targets.from_rest};
    if (targets.incoming) {
        if (level_)
            level_->map.restrict(*targets.incoming, work.top.base);
        else
            work.top.base = (*targets.incoming)(mesh_->order(), Eigen::all);
        local.incoming.emplace(view(work.top.base));
    }
    work.top.goals.set(top(), local);
    ArapProblem problem(top(), local.base(), work.top.goals.targets, work.top.goals.pulls, &work.top.buffers);
    CascadeSolve cascade(below_, problem, top(), local, work.levels);
    const std::vector<Eigen::Quaterniond>& nodes = cascade.solve(work.top);
    parallel_for(vertex_count_, [&](int i) {
        if (level_ && level_->map.label()[i] >= 0)
            vertices[i] = handed_down(level_->map, nodes, i);
        else if (!level_)
            vertices[mesh_->order()[i]] = nodes[i];
    });
}

std::int64_t CoarseStart::factor_bytes() const
{
    return below_.factor_bytes() + (level_ || mesh_ ? top().factor_bytes() : 0);
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/surface/linear/gradient_editing.h"

#include "native/core/memory.h"
#include "native/core/progress_part.h"
#include "native/handles/constrained_system.h"
#include "native/handles/map_blend.h"
#include "native/operators/laplacian.h"
#include "native/operators/turned_gradients.h"

#include <algorithm>
#include <memory>
#include <string>
#include <utility>

namespace sinew {

namespace {

/// The handle whose held vertices each triangle touches; -1 where there are none, or those of several
/// handles.
std::vector<int> touching_handles(const SurfaceMesh& mesh, const Regions& regions)
{
    std::vector<int> handles;
    handles.reserve(mesh.triangles().size());
    for (const Triangle& t : mesh.triangles()) {
        int touching = -1;
        bool alone = true;
        for (int v : t)
            if (const int hard = regions.hard(v); hard >= 0) {
                alone = alone && (touching < 0 || touching == hard);
                touching = hard;
            }
        handles.push_back(alone ? touching : -1);
    }
    return handles;
}

/// The workspace of a frame.
struct Workspace
{
    RowMatrix blended; ///< (n, MapBlend::numbers)
    std::vector<Vector3> forces;
};

/// The results of a bind.
struct Binding
{
    ConstrainedSystem system; ///< of the cotan Laplacian
    TurnedGradients gradients;
    HandleFields fields;
    std::vector<int> touching; ///< of touching_handles()
    std::vector<std::vector<int>> patches;
    mutable Pool<Workspace> workspaces;
};

} // namespace

struct GradientEditing::Impl
{
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();
};

GradientEditing::GradientEditing(const SurfaceMesh& rest, const GradientEditingOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
}

void GradientEditing::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    Binding& bound = *impl_->bound;
    const TriangleMetric metric = triangle_metric(rest());
    report.degenerate_faces = degenerate_face_count(rest(), metric);
    if (bound.gradients.triangle_count() == 0)
        bound.gradients = TurnedGradients(rest(), metric);
    std::vector<int> touching = touching_handles(rest(), regions);
    std::vector<std::vector<int>> patches = handle_patches(rest(), regions);
    HandleFields fields;
    const auto laplacian = [&] {
        LinearSystem system;
        system.graph = laplacian_matrix(rest(), Discretization::cotan, metric);
        system.points = rest().points();
        return system;
    };
    const bool harmonic = options().field == Field::harmonic;
    const auto find_fields = [&](const ConstrainedSystem& system) {
        progress.tick(0.7, "computing the fields");
        HandleGroups groups(regions, connected_components(rest()));
        fields = harmonic ? HandleFields(std::move(groups), regions, system, part_of(progress, 0.7, 0.8))
                          : HandleFields(std::move(groups), regions, rest(), options().field);
    };
    const auto complete = [&] {
        if (fields.groups().group.empty())
            find_fields(bound.system);
        progress.tick(1.0, "bound");
    };
    const auto factorize = [&] {
        auto L = std::make_shared<SparseMatrix>(laplacian().graph);
        progress.tick(0.2, "factorising");
        bound.system.factorize(std::move(L), regions, complete);
    };
    const auto iterate = [&] {
        LinearSystem system = laplacian(), positive;
        if (harmonic)
            positive = system;
        const bool apart = harmonic && make_weights_positive(positive.graph);
        if (apart) {
            ConstrainedSystem of_fields;
            of_fields.iterate(std::move(positive), regions, part_of(progress, 0.2, 0.7));
            find_fields(of_fields);
        }
        positive = {};
        bound.system.iterate(std::move(system), regions,
                             apart ? part_of(progress, 0.8, 1.0) : part_of(progress, 0.2, 0.7), complete);
    };
    const auto free = static_cast<int>(std::ranges::count(regions.free_vertices(), true));
    const std::string why = bind_by(options().solver, {free, factor_bytes(free, 1), "", factorize, iterate});
    bound.fields = std::move(fields);
    bound.touching = std::move(touching);
    bound.patches = std::move(patches);
    bound.system.report(report, why);
}

SolveReport GradientEditing::deform(const SolveRequest& request, const Targets& targets,
                                    Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const auto work = bound.workspaces.take([this] {
        auto made = std::make_unique<Workspace>();
        made->blended.resize(rest().vertex_count(), MapBlend::numbers);
        return made;
    });
    const std::vector<Matrix3> maps = linear_maps(targets, bound.patches);
    const HandleGroups& groups = bound.fields.groups();
    const MapBlend blend(groups, maps);
    const auto change = [&](int triangle, Vector3& first, Vector3& second) {
        const auto apply = [&](const auto& map) {
            first = (map(first) - first).eval();
            second = (map(second) - second).eval();
        };
        if (const int handle = bound.touching[triangle]; handle >= 0) {
            apply([&](const Vector3& v) -> Vector3 { return maps[handle] * v; });
            return;
        }
        const auto [i, j, k] = rest().triangles()[triangle];
        const int group = groups.group[i];
        if (group < 0) {
            first = second = Vector3::Zero();
            return;
        }
        const Eigen::Matrix<double, MapBlend::numbers, 1> mean =
            (work->blended.row(i) + work->blended.row(j) + work->blended.row(k)).transpose() / 3.0;
        apply(blend.at(group, mean.data()));
    };
    const auto source = [&](RowMatrix& b) {
        bound.fields.blend(blend.values(), work->blended);
        return bound.gradients.source(targets.base(), change, work->forces, b);
    };
    SolveReport report = bound.system.solve(targets, positions, source,
                                            {.start = request.start, .progress = request.progress});
    report.half_turns = blend.half_turns(groups);
    return report;
}

void GradientEditing::swap_binding(SurfaceMethod& other)
{
    std::swap(impl_->bound, static_cast<GradientEditing&>(other).impl_->bound);
}

} // namespace sinew

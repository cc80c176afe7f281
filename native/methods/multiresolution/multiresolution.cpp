// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/multiresolution/multiresolution.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/core/parallel.h"
#include "native/core/progress_part.h"
#include "native/operators/laplacian.h"
#include "native/solvers/shared_analyses.h"

#include <algorithm>
#include <iterator>
#include <utility>

namespace sinew {

namespace {

/// The shapes of all levels in one frame, from the fine one to the base, before and after the deformation.
struct Workspace
{
    std::vector<Points> levels, moved;
    Points start, spare;
};

/// The results of a bind.
struct Binding
{
    DetailBands bands;
    Points below; ///< the base less the rest shape; empty unless both are displaced alike
    int factorizations = 0, analyses = 0; ///< so far, without those of the base
    mutable Pool<Workspace> workspaces;
};

} // namespace

struct Multiresolution::Impl
{
    std::shared_ptr<SurfaceMethod> base;
    std::shared_ptr<const RingRotations> rings;
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();
};

Multiresolution::Multiresolution(const SurfaceMesh& rest, std::shared_ptr<SurfaceMethod> base,
                                 const MultiresolutionOptions& options)
    : SurfaceMethodWith(rest, options), impl_(hidden<Impl>())
{
    if (!base)
        throw InvalidOption("base: there is no method to put this one around");
    if (!(base->rest() == SurfaceMethod::rest()))
        throw InvalidOption("base: its rest shape is another one; make both on the same mesh");
    impl_->base = std::move(base);
    impl_->rings = std::make_shared<const RingRotations>(SurfaceMethod::rest());
}

std::vector<Points> Multiresolution::levels() const
{
    const AccessLock shared = reading();
    const std::vector<Points>& levels = impl_->bound->bands.levels();
    return levels.empty() ? std::vector{rest().points()} : levels;
}

void Multiresolution::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    const SharedAnalyses shared; // of bi-Laplacians for the bands and for the base
    auto next = std::make_unique<Binding>();
    next->factorizations = impl_->bound->factorizations;
    next->analyses = impl_->bound->analyses;
    const Regions faired = faired_regions(rest(), regions, connected_components(rest()));
    next->bands = DetailBands(rest(), regions, faired, options(), impl_->rings, part_of(progress, 0.0, 0.5));
    BindReport of_bands;
    next->bands.report(of_bands);
    next->factorizations += of_bands.factorizations;
    next->analyses += of_bands.analyses;
    report.detail_vectors += of_bands.detail_vectors;
    // Soft handles pull the rest shape and the base from different places.
    if (impl_->base->displaces_all_alike() && regions.soft().empty())
        next->below = next->bands.levels().back() - next->bands.levels().front();
    // The base comes last: its own bind leaves it as it was if it throws, and nothing throws afterwards. It
    // is kept if its handles are the same.
    const BindReport of_base =
        impl_->base->rebind(*impl_->base, regions.handles(), part_of(progress, 0.5, 1.0));
    report.remarks = of_base.remarks;
    std::ranges::copy(of_bands.remarks, std::back_inserter(report.remarks));
    report.degenerate_faces = degenerate_face_count(rest(), least_area_for_order(2));
    report.factorizations = of_base.factorizations + next->factorizations;
    report.analyses = of_base.analyses + next->analyses;
    report.factor_bytes = of_base.factor_bytes + of_bands.factor_bytes;
    report.refactored = 1.0;
    impl_->bound = std::move(next);
}

SolveReport Multiresolution::deform(const SolveRequest& request, const Targets& /*targets*/,
                                    Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const auto work = bound.workspaces.take([] { return std::make_unique<Workspace>(); });
    if (request.incoming) {
        work->levels.resize(bound.bands.levels().size());
        work->levels[0] = *request.incoming;
        bound.bands.smooth(work->levels);
    }
    const std::vector<Points>& levels = request.incoming ? work->levels : bound.bands.levels();
    work->moved.resize(levels.size());
    SolveReport report;
    if (bound.below.size() > 0 && !request.incoming && request.substeps == 1) {
        // From rest, so that the base can use what it has precomputed for this.
        report = impl_->base->solve(request, work->moved.back());
        Points& moved = work->moved.back();
        parallel_for(static_cast<int>(moved.rows()), [&](int v) { moved.row(v) += bound.below.row(v); });
    } else {
        SolveRequest of_base = request;
        of_base.incoming.emplace(view(levels.back()));
        if (request.start) {
            work->start = *request.start;
            bound.bands.smooth(work->start, work->spare);
            of_base.start.emplace(view(work->start));
        }
        report = impl_->base->solve(of_base, work->moved.back());
    }
    bound.bands.put_back(levels, work->moved, !request.incoming, positions, report);
    return report;
}

std::vector<std::string> Multiresolution::changed_options(const SurfaceMethod& former) const
{
    const auto& other = static_cast<const Multiresolution&>(former);
    return changed(options(), other.options(),
                   names_of({{"base", !impl_->base->differences(*other.impl_->base).empty()}}));
}

void Multiresolution::swap_binding(SurfaceMethod& other)
{
    Impl& former = *static_cast<Multiresolution&>(other).impl_;
    std::swap(impl_->bound, former.bound);
    std::swap(impl_->base, former.base); // they are alike, and their binds go with the rest
}

} // namespace sinew

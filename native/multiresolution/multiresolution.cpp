// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/multiresolution/multiresolution.h"

#include "native/core/errors.h"
#include "native/core/memory.h"
#include "native/multiresolution/details/deformation_transfer.h"
#include "native/multiresolution/details/displacement_vectors.h"
#include "native/multiresolution/details/displacement_volumes.h"
#include "native/multiresolution/details/fairing.h"
#include "native/multiresolution/details/normal_displacements.h"
#include "native/operators/laplacian.h"

#include <cmath>
#include <utility>

namespace sinew {

namespace {

constexpr int most_bands = 8;

/// The shapes of all levels in one frame, from the fine one to the base, before and after the deformation.
struct Workspace
{
    std::vector<Points> levels, moved;
    Points start, spare;
};

/// The results of a bind.
struct Binding
{
    std::vector<std::unique_ptr<Fairing>> fairings; ///< one per band
    std::vector<std::unique_ptr<DetailCoding>> codings;
    std::vector<Points> levels; ///< at rest
    Points below; ///< the base less the rest shape; empty unless both are displaced alike
    int factorizations = 0, analyses = 0; ///< so far, without those of the base
    mutable Pool<Workspace> workspaces;
};

/// The levels below levels[0].
void smooth(const std::vector<std::unique_ptr<Fairing>>& fairings, std::vector<Points>& levels)
{
    levels.resize(fairings.size() + 1);
    for (std::size_t k = 0; k < fairings.size(); ++k)
        fairings[k]->smooth(view(levels[k]), levels[k + 1]);
}

} // namespace

struct Multiresolution::Impl
{
    std::shared_ptr<SurfaceMethod> base;
    MultiresolutionOptions options;
    std::shared_ptr<const RingRotations> rings;
    std::unique_ptr<Binding> bound = std::make_unique<Binding>();

    std::unique_ptr<DetailCoding> coding(const SurfaceMesh& rest, const Regions& regions, const Points& fine,
                                         const Points& coarse) const
    {
        switch (options.details) {
        case DetailKind::normal_displacements:
            return std::make_unique<NormalDisplacements>(view(fine), view(coarse), rings);
        case DetailKind::displacement_volumes:
            return std::make_unique<DisplacementVolumes>(rest, regions, view(fine), view(coarse), rings);
        case DetailKind::deformation_transfer:
            return std::make_unique<DeformationTransfer>(rest, regions, rings);
        case DetailKind::displacement_vectors:
            break;
        }
        return std::make_unique<DisplacementVectors>(rings, view(coarse));
    }
};

Multiresolution::Multiresolution(const SurfaceMesh& rest, std::shared_ptr<SurfaceMethod> base,
                                 const MultiresolutionOptions& options)
    : SurfaceMethod(rest), impl_(std::make_unique<Impl>())
{
    if (!base)
        throw InvalidOption("base: there is no method to put this one around");
    if (!(base->rest() == rest))
        throw InvalidOption("base: its rest shape is another one; make both on the same mesh");
    if (!(options.wavelength > 0) || !std::isfinite(options.wavelength))
        throw InvalidOption("wavelength must be a finite number above 0");
    if (options.bands < 1 || options.bands > most_bands)
        throw InvalidOption("bands must be from 1 to " + std::to_string(most_bands));
    impl_->base = std::move(base);
    impl_->options = options;
    impl_->rings = std::make_shared<const RingRotations>(rest);
}

Multiresolution::~Multiresolution() = default;
Multiresolution::Multiresolution(Multiresolution&&) noexcept = default;

std::vector<Points> Multiresolution::levels() const
{
    const AccessLock shared = reading();
    return impl_->bound->levels.empty() ? std::vector{rest().points()} : impl_->bound->levels;
}

void Multiresolution::bind(const Regions& regions, BindReport& report, const Progress& progress)
{
    auto next = std::make_unique<Binding>();
    next->factorizations = impl_->bound->factorizations;
    next->analyses = impl_->bound->analyses;
    const Regions faired = faired_regions(rest(), regions, connected_components(rest()));
    const int bands = impl_->options.bands;
    double wavelength = impl_->options.wavelength * mean_edge(rest());
    std::int64_t bytes = 0;
    const auto count = [&](const auto& part) {
        BindReport own;
        part.report(own);
        next->factorizations += own.factorizations;
        next->analyses += own.analyses;
        bytes += own.factor_bytes;
    };
    for (int k = 0; k < bands; ++k, wavelength *= 2) {
        progress.tick(0.5 * k / bands, "fairing the base");
        next->fairings.push_back(std::make_unique<Fairing>(rest(), faired, wavelength));
        count(*next->fairings.back());
    }
    next->levels = {rest().points()};
    smooth(next->fairings, next->levels);
    for (int k = 0; k < bands; ++k) {
        progress.tick(0.5, "coding the details");
        next->codings.push_back(impl_->coding(rest(), faired, next->levels[k], next->levels[k + 1]));
        count(*next->codings.back());
        report.detail_vectors += next->codings.back()->vectors();
    }
    // Soft handles pull the rest shape and the base from different places.
    if (impl_->base->displaces_all_alike() && regions.soft().empty())
        next->below = next->levels.back() - next->levels.front();
    // The base comes last: its own bind leaves it as it was if it throws, and nothing throws afterwards. It
    // is kept if its handles are the same.
    const BindReport of_base = impl_->base->rebind(*impl_->base, regions.handles(),
                                                   Progress([&](double fraction, const char* stage) {
                                                       progress.tick(0.5 + 0.5 * fraction, stage);
                                                       return true;
                                                   }));
    report.degenerate_faces = degenerate_face_count(rest(), least_area_for_order(2));
    report.factorizations = of_base.factorizations + next->factorizations;
    report.analyses = of_base.analyses + next->analyses;
    report.factor_bytes = of_base.factor_bytes + bytes;
    report.refactored = 1.0;
    impl_->bound = std::move(next);
}

SolveReport Multiresolution::deform(const SolveRequest& request, const Targets& /*targets*/,
                                    Points& positions) const
{
    const Binding& bound = *impl_->bound;
    const auto work = bound.workspaces.take([] { return std::make_unique<Workspace>(); });
    if (request.incoming) {
        work->levels.resize(bound.levels.size());
        work->levels[0] = *request.incoming;
        smooth(bound.fairings, work->levels);
    }
    const std::vector<Points>& levels = request.incoming ? work->levels : bound.levels;
    work->moved.resize(levels.size());
    SolveReport report;
    if (bound.below.size() > 0 && !request.incoming && request.substeps == 1) {
        // From rest, so that the base can use what it has precomputed for this.
        report = impl_->base->solve(request, work->moved.back());
        work->moved.back() += bound.below;
    } else {
        SolveRequest of_base = request;
        of_base.incoming.emplace(view(levels.back()));
        if (request.start) {
            work->start = *request.start;
            for (const auto& fairing : bound.fairings) {
                fairing->smooth(view(work->start), work->spare);
                work->start.swap(work->spare);
            }
            of_base.start.emplace(view(work->start));
        }
        report = impl_->base->solve(of_base, work->moved.back());
    }
    for (std::size_t k = bound.codings.size(); k-- > 0;)
        bound.codings[k]->apply(
            {view(levels[k]), view(levels[k + 1]), view(work->moved[k + 1]), !request.incoming},
            k == 0 ? positions : work->moved[k], report);
    return report;
}

std::vector<std::string> Multiresolution::changed_options(const SurfaceMethod& former) const
{
    const Impl &own = *impl_, &other = *static_cast<const Multiresolution&>(former).impl_;
    return names_of({{"base", !own.base->differences(*other.base).empty()},
                     {"details", own.options.details != other.options.details},
                     {"wavelength", own.options.wavelength != other.options.wavelength},
                     {"bands", own.options.bands != other.options.bands}});
}

bool Multiresolution::updates(const std::string& option) const { return option != "base"; }

void Multiresolution::swap_binding(SurfaceMethod& other)
{
    Impl& former = *static_cast<Multiresolution&>(other).impl_;
    std::swap(impl_->bound, former.bound);
    std::swap(impl_->base, former.base); // they are alike, and their binds go with the rest
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/memory.h"
#include "native/core/progress.h"
#include "native/core/report.h"
#include "native/core/types.h"
#include "native/mesh/regions.h"
#include "native/solvers/constrained_quadratic.h"
#include "native/solvers/systems/multigrid_solver.h"

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace sinew {

/// The displacements that belong to m columns of constraint values, and inner products of these columns, from
/// which the energy and the residual of any linear combination of them follow.
struct LinearResponse
{
    RowMatrix displacement; ///< (n, m)
    MatrixX energy;         ///< (m, m) twice E as a bilinear form, soft terms included
    MatrixX residual;       ///< (m, m) inner products of A d - b on the unknowns
    MatrixX load;           ///< (m, m) inner products of b, the right-hand side
};

/// How an iterative solve begins, and who may end it.
struct Iterating
{
    std::optional<PointsView> start; ///< (n, 3) the shape it begins from; without one, a coarse solution
    Progress progress;
};

/// A linear system for the displacements d of a surface with hard and soft position constraints:
///
///     E(d) = 1/2 d^T A d - b^T d + c / 2 + 1/2 sum_i s_i |d_i - t_i|^2,    s_i = w / (1 - w) A_ii
///
/// is least over the free rows of d. The rows of held vertices are given; a soft handle of weight w pulls
/// vertex i to its displacement t_i. A vertex without a diagonal entry has the mean of all as its unit.
///
///   call         repeat it when ...     cost
///   factorize()  the handles changed    one factorisation, or the part of it that depends on these vertices
///   or iterate()                        a hierarchy of graphs, where the factor would be too large
///   solve()      the handles moved      one solve for x, y and z; after iterate(), 8 to 60 iterations
class ConstrainedSystem
{
public:
    explicit ConstrainedSystem(const FactorOptions& options = {}) : equations_(options) {}

    /// Takes another A and other handles, and then calls `completed`. Leaves everything as it was if one of
    /// the two throws.
    /// \param A  (n, n) symmetric positive semi-definite, without soft pulls.
    /// \param wider  where vertices are free for which the factor is analysed, too; see
    ///   ConstrainedQuadratic. Null for none.
    /// \throw FactorizationFailed  a free block of A is singular; the element of the error is a vertex.
    void factorize(std::shared_ptr<SparseMatrix> A, const Regions& regions,
                   const std::function<void()>& completed = {}, const Regions* wider = nullptr);

    /// The same without a factor and without A, see MultigridSolver.
    /// \param system     what A is made of, without vertices and pulls, which follow from the regions.
    /// \param completed  as above.
    /// \throw OutOfMemory, FactorizationFailed, Cancelled
    void iterate(LinearSystem system, const Regions& regions, const Progress& progress,
                 const std::function<void()>& completed = {});
    bool iterates() const { return grid_ != nullptr; }

    /// Fills b (n, 3) and returns c.
    using Source = std::function<double(RowMatrix& b)>;

    /// \param[out] positions  (n, 3) the shape that enters, displaced.
    /// \param source          null for b = 0 and c = 0, and then in all calls.
    /// \throw NotConverged, Cancelled  after iterate().
    /// \throw InvalidOption  after iterate(), where a SolvedSystem is to keep the matrix.
    SolveReport solve(const Targets& targets, Points& positions, const Source& source = {},
                      const Iterating& how = {}) const;

    /// The same without a report, whose energy and residual take a product with A.
    void displace(const Targets& targets, Points& positions, const Source& source = {}) const;

    /// (n, m) d with b = 0 for m columns of constraint values.
    /// \param constraints  (c, m) one row for each of regions.constraints().
    /// \throw InvalidConstraint        before the first factorize().
    /// \throw NotConverged, Cancelled  after iterate().
    RowMatrix spread(const MatrixX& constraints, const Progress& progress = {}) const;
    /// (n, m) d for m columns of b, where held vertices stay and nothing pulls. Rows of b that are no
    /// unknowns are not read.
    /// \throw as spread()
    RowMatrix answer(const RowMatrix& b, const Progress& progress = {}) const;
    /// \throw InvalidOption  after iterate().
    LinearResponse respond(const MatrixX& constraints) const;

    /// (n, n) A of the last factorize(), with the soft pulls on its diagonal.
    const SparseMatrix& matrix() const { return *equations_.problem().matrix; }
    /// Completes the counts of factorisations, the memory and the remarks in a report.
    /// \param why  of bind_by(), see handles/system_solver.h.
    void report(BindReport& report, const std::string& why = {}) const;

private:
    /// The workspace of a frame. Rows of d that are neither given nor solved for stay zero, and so do rows of
    /// b where no handle pulls if there is no source.
    struct Frame
    {
        RowMatrix d, b;
        ConstrainedQuadratic::Workspace work;
    };

    /// Takes other constraints and another solver, and then calls `completed`; as before if it throws.
    void exchange(const Regions& regions, std::vector<double> stiffness,
                  std::unique_ptr<const MultigridSolver> grid, const std::function<void()>& completed);
    bool is_soft(std::size_t row) const { return row >= constraints_.size() - stiffness_.size(); }
    double stiffness(std::size_t row) const
    {
        return stiffness_[row + stiffness_.size() - constraints_.size()];
    }
    RowMatrix spread(const MatrixX& constraints, std::optional<RowMatrix>& b, const Progress& progress) const;
    void solve(RowMatrix& d, const RowMatrix* b, const Progress& progress) const;
    void solve(const Targets& targets, Points& positions, const Source& source, SolveReport* report,
               const Iterating& how) const;

    std::vector<Constraint> constraints_;
    std::vector<double> stiffness_; ///< s_i of the soft ones, which are the last
    ConstrainedQuadratic equations_; ///< with the pulls on the diagonal; empty after iterate()
    std::unique_ptr<const MultigridSolver> grid_; ///< after iterate()
    int factorizations_ = 0;
    std::unique_ptr<Pool<Frame>> frames_ = std::make_unique<Pool<Frame>>();
};

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/local_global/arap/higher_order.h"

#include "native/core/errors.h"
#include "native/core/parallel.h"

#include <utility>

namespace sinew {

HigherOrder::HigherOrder(const ArapSystem& graph, double lambda, std::vector<double> mass)
    : lambda_(lambda), mass_(std::move(mass)), laplacian_(graph.size(), graph.size())
{
    const HandleGraph& nodes = graph.nodes();
    const int free = graph.free_count();
    std::vector<Eigen::Triplet<double>> entries;
    for (int i = 0; i < graph.size(); ++i)
        for (int a = nodes.edges().offsets[i]; a < nodes.edges().offsets[i + 1]; ++a) {
            entries.emplace_back(i, i, graph.laplacian()[a]);
            entries.emplace_back(i, nodes.edges().neighbours[a], -graph.laplacian()[a]);
        }
    laplacian_.setFromTriplets(entries.begin(), entries.end());

    const SparseMatrix columns = laplacian_.leftCols(free);
    SparseMatrix scaled = laplacian_.leftCols(free);
    for (int c = 0; c < free; ++c)
        for (SparseMatrix::InnerIterator it(scaled, c); it; ++it)
            it.valueRef() *= lambda / mass_[it.row()];
    SparseMatrix A = SparseMatrix(columns.transpose()) * scaled;
    A += (1 - lambda) * SparseMatrix(columns.topRows(free));
    for (const GraphPull& pull : nodes.pulls())
        A.coeffRef(pull.node, pull.node) += (1 - lambda) * pull.stiffness;
    try {
        factor_.factorize(A);
    } catch (const OutOfMemory&) {
        throw;
    } catch (const FactorizationFailed& failure) {
        if (failure.elements().empty())
            throw;
        throw FactorizationFailed(failure.what(), Error::Element::vertex,
                                  {graph.order()[failure.elements().front()]});
    }
}

HigherOrderProblem::HigherOrderProblem(const ArapSystem& graph, const HigherOrder& order,
                                       ArapProblem& problem, const PointsView& base, const Points& pulls)
    : graph_(graph), order_(order), problem_(problem), base_(base), pulls_(pulls)
{
}

double HigherOrderProblem::bend(const Points& x, Points& gradient)
{
    const PointsView q = problem_.place(x);
    const GraphEdges& edges = graph_.nodes().edges();
    const std::vector<double>& rigidity = graph_.cells().rigidity;
    const int present = graph_.chunks().present(), free = graph_.free_count();
    const double lambda = order_.lambda();
    r_.resize(present, 3);
    parallel_for(present, [&](int i) {
        const Matrix3 R = rigidity[i] * problem_.rotation(i);
        Vector3 sum = Vector3::Zero();
        for (int a = edges.offsets[i]; a < edges.offsets[i + 1]; ++a) {
            const int j = edges.neighbours[a];
            const Vector3 e = base_.row(i) - base_.row(j), d = q.row(i) - q.row(j);
            sum += graph_.laplacian()[a] * d -
                   0.5 * edges.weights[a] * (R * e + rigidity[j] * (problem_.rotation(j) * e));
        }
        r_.row(i) = sum.transpose();
    });
    const double energy =
        0.5 * lambda * parallel_sum(present, [&](int i) { return r_.row(i).squaredNorm() / order_.mass(i); });
    gradient.resize(free, 3);
    parallel_for(free, [&](int i) {
        Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
        for (SparseMatrix::InnerIterator it(order_.laplacian(), i); it; ++it) // L is symmetric
            sum += it.value() / order_.mass(static_cast<int>(it.row())) * r_.row(it.row());
        gradient.row(i) = (1 - lambda) * r_.row(i) + lambda * sum;
    });
    for (std::size_t k = 0; k < graph_.nodes().pulls().size(); ++k) {
        const GraphPull& pull = graph_.nodes().pulls()[k];
        gradient.row(pull.node) +=
            (1 - lambda) * pull.stiffness * (q.row(pull.node) - pulls_.row(static_cast<Eigen::Index>(k)));
    }
    return energy;
}

double HigherOrderProblem::evaluate(const Points& x, Points& gradient)
{
    const double stretching = problem_.evaluate(x, gradient);
    return (1 - order_.lambda()) * stretching + bend(x, gradient);
}

void HigherOrderProblem::global_step(Points& x)
{
    Points gradient;
    for (int k = 0; k < 3; ++k) { // the factor is in single precision, and its condition that of a square
        bend(x, gradient);
        order_.factor().solve(gradient, gradient);
        x -= gradient;
    }
    problem_.place(x);
}

} // namespace sinew

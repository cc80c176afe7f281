// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/cage/closed_forms/smooth_normals.h"

#include <Eigen/LU>

#include <map>
#include <utility>

namespace sinew {

namespace {

constexpr double slack = 1e-6;

} // namespace

SmoothNormals::SmoothNormals(const Cage& cage, const std::vector<Column>& columns)
    : of_columns_(static_cast<Eigen::Index>(columns.size()), 3 * cage.control_count()),
      rest_(static_cast<Eigen::Index>(columns.size()), 3)
{
    std::vector<Eigen::Triplet<double>> entries, squares;
    for (std::size_t c = 0; c < columns.size(); ++c) {
        const Column& column = columns[c];
        const std::span<const int> face = cage.rest().face(column.face);
        std::map<int, double> shares; // of the control points, at the middle of the face
        for (int v : face)
            for (SparseRows::InnerIterator entry(cage.smooth()->places(), v); entry; ++entry)
                shares[static_cast<int>(entry.col())] += entry.value() / static_cast<double>(face.size());
        for (const auto& [k, share] : shares)
            for (int axis = 0; axis < 3; ++axis)
                entries.emplace_back(static_cast<int>(c), 3 * k + axis, share * column.rest[axis]);
        weights_.push_back(column.weight);
        rest_.row(static_cast<Eigen::Index>(c)) = column.rest.transpose();
    }
    of_columns_.setFromTriplets(entries.begin(), entries.end());

    const int unknowns = static_cast<int>(of_columns_.cols());
    double sum = 0.0;
    for (Eigen::Index c = 0; c < of_columns_.rows(); ++c) {
        if (weights_[static_cast<std::size_t>(c)] == 0.0)
            continue;
        for (SparseRows::InnerIterator i(of_columns_, c); i; ++i)
            for (SparseRows::InnerIterator j(of_columns_, c); j; ++j) {
                const double product = weights_[static_cast<std::size_t>(c)] * i.value() * j.value();
                squares.emplace_back(static_cast<int>(i.col()), static_cast<int>(j.col()), product);
                sum += i.col() == j.col() ? product : 0.0;
            }
    }
    for (int i = 0; i < unknowns; ++i)
        squares.emplace_back(i, i, slack * sum / unknowns);
    SparseMatrix normal_matrix(unknowns, unknowns);
    normal_matrix.setFromTriplets(squares.begin(), squares.end());
    factor_.factorize(normal_matrix);

    Points arms = cage.control();
    const Eigen::RowVector3d middle = arms.colwise().mean();
    arms = (arms.rowwise() - middle) / cage.size();
    pseudo_inverse_ = arms * (arms.transpose() * arms).inverse();
}

void SmoothNormals::fold(RowMatrix& rows) const
{
    const Eigen::Index points = rows.cols() - of_columns_.rows();
    RowMatrix folded = RowMatrix::Zero(rows.rows(), points + columns());
    folded.leftCols(points) = rows.leftCols(points);
    add_product(rows, points, of_columns_, folded.rightCols(columns()));
    rows.swap(folded);
}

void SmoothNormals::controls(const Points& normals, PointsView control, Eigen::Ref<Points> controls) const
{
    Matrix3 affine = Matrix3::Zero(); // transposed
    for (Eigen::Index k = 0; k < control.rows(); ++k)
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                affine(i, j) += pseudo_inverse_(k, i) * control(k, j);
    RowMatrix change = RowMatrix::Zero(columns(), 3);
    for (Eigen::Index c = 0; c < normals.rows(); ++c) {
        const double weight = weights_[static_cast<std::size_t>(c)];
        if (weight == 0.0)
            continue;
        for (int j = 0; j < 3; ++j) {
            double left = normals(c, j);
            for (int i = 0; i < 3; ++i)
                left -= rest_(c, i) * affine(i, j);
            for (SparseRows::InnerIterator entry(of_columns_, c); entry; ++entry)
                change(entry.col(), j) += weight * entry.value() * left;
        }
    }
    factor_.solve_rows(change);
    for (Eigen::Index row = 0; row < columns(); ++row)
        controls.row(row) = affine.row(row % 3) + change.row(row);
}

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/space/cage/mean_value.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace sinew {

namespace {

/// Adds a triangle's part to the weights `row`; true where x lies on it, and then `row` is the answer.
bool add_triangle(const Cage& cage, const Triangle& triangle, const Vector3& x, double* row)
{
    std::array<Vector3, 3> u;
    std::array<double, 3> d;
    for (int i = 0; i < 3; ++i) {
        u[i] = cage.rest().point(triangle[i]) - x;
        d[i] = u[i].norm();
        if (d[i] <= 1e-14 * cage.size()) {
            std::fill(row, row + cage.vertex_count(), 0.0);
            row[triangle[i]] = 1.0;
            return true;
        }
        u[i] /= d[i];
    }
    Vector3 mean = Vector3::Zero(); // half the sum of arc angle times arc normal
    std::array<Vector3, 3> normal;
    for (int i = 0; i < 3; ++i) {
        const Vector3& a = u[(i + 1) % 3];
        const Vector3& b = u[(i + 2) % 3];
        normal[i] = a.cross(b);
        const double sine = normal[i].norm();
        if (sine > 0.0)
            mean += 0.5 * std::atan2(sine, a.dot(b)) / sine * normal[i];
    }
    const double volume = u[0].dot(normal[0]);
    if (std::abs(volume) < 1e-14)
        return false;
    for (int i = 0; i < 3; ++i)
        row[triangle[i]] += mean.dot(normal[i]) / (volume * d[i]);
    return false;
}

} // namespace

void MeanValue::evaluate(PointsView block, RowMatrix& rows, std::vector<char>& outside) const
{
    rows.setZero(block.rows(), columns());
    outside.assign(static_cast<std::size_t>(block.rows()), 0);
    for (Eigen::Index i = 0; i < block.rows(); ++i) {
        const Vector3 x = block.row(i).transpose();
        double* row = rows.row(i).data();
        bool on = false;
        for (const Triangle& triangle : cage().triangles())
            if ((on = add_triangle(cage(), triangle, x, row)))
                break;
        if (!on)
            rows.row(i) /= rows.row(i).sum();
    }
}

} // namespace sinew

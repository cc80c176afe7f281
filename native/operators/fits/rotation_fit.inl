// SPDX-License-Identifier: GPL-3.0-or-later
// Four fits of rotation_fit.h at once, one per lane, for the .inl files of kernels (see lane_types.inl).

#include "native/core/simd/lane_types.inl"

namespace {

/// Below this slope of the characteristic polynomial (S scaled to |S| = 1) the largest eigenvalue is treated
/// as double: the quaternion's error grows as epsilon / slope.
constexpr double least_slope = 1e-3;
constexpr int most_newton_steps = 60;

/// Fits rotations to four matrices, one per lane, in three stages: begin(), some steps, finish(). A step
/// waits for a division, so a caller that has several of these steps them in turn.
struct FourFits
{
    using L = Lanes<double>;
    using Mask = decltype(above(L{}, L{}));

    /// \param S      row-major.
    /// \param guess  a lower bound of the largest trace(R^T S), such as that of the rotation before.
    void begin(const L* S, L guess)
    {
        L square = S[0] * S[0];
        for (int k = 1; k < 9; ++k)
            square = square + S[k] * S[k];
        // S = 0 gives K = 0, whose quaternion is the identity.
        const L scale = choose(above(square, constant(1e-300)), constant(1.0) / root(square), constant(0.0));
        L A[9];
        for (int k = 0; k < 9; ++k)
            A[k] = S[k] * scale;

        k00 = A[0] + A[4] + A[8], k11 = A[0] - A[4] - A[8], k22 = A[4] - A[0] - A[8],
        k33 = A[8] - A[0] - A[4];
        k01 = A[7] - A[5], k02 = A[2] - A[6], k03 = A[3] - A[1];
        k12 = A[1] + A[3], k13 = A[2] + A[6], k23 = A[5] + A[7];
        c1 = constant(-8.0) * (A[0] * (A[4] * A[8] - A[5] * A[7]) + A[1] * (A[5] * A[6] - A[3] * A[8]) +
                               A[2] * (A[3] * A[7] - A[4] * A[6]));
        c0 = (k00 * k11 - k01 * k01) * (k22 * k33 - k23 * k23) -
             (k00 * k12 - k02 * k01) * (k12 * k33 - k23 * k13) +
             (k00 * k13 - k03 * k01) * (k12 * k23 - k22 * k13) +
             (k01 * k12 - k02 * k11) * (k02 * k33 - k23 * k03) -
             (k01 * k13 - k03 * k11) * (k02 * k23 - k22 * k03) +
             (k02 * k13 - k03 * k12) * (k02 * k13 - k12 * k03);

        // From above, Newton's iteration approaches the largest root without overshooting. It may start at
        // sqrt(3), or where a first step from a guess below the root leads: the polynomial is convex there,
        // and that root is the only one ahead, so the step ends above it.
        const L most = constant(1.7320508075688774);
        l = guess * scale;
        evaluate();
        const L ahead = l - value_ / slope_;
        l = choose(above(l, constant(0.58)) & above(constant(1e-16), value_) &
                       above(slope_, constant(least_slope)) & above(most, ahead),
                   ahead, most);
        safe_ = above(most, constant(0.0));
    }

    /// One step of Newton's iteration.
    void step()
    {
        evaluate();
        safe_ = safe_ & above(slope_, constant(least_slope));
        move_ = value_ / slope_;
        l = l - move_;
    }

    /// Whether all lanes have converged. The error after a step is about 4 move^2 / slope.
    bool done() const
    {
        return all(above(slope_, constant(1e17) * move_ * move_) | above(constant(least_slope), slope_));
    }

    /// \param[out] R  the rotations, row-major.
    /// \return in which lanes they are safe. In the others, a singular value decomposition has to take over.
    Mask finish(L* R) const
    {
        // Every non-zero column of the adjugate of M = K - l I is the eigenvector; the one with the largest
        // diagonal entry is the best conditioned. a and b are minors of the upper and of the lower two rows,
        // C their sums, the cofactors.
        const L m00 = k00 - l, m11 = k11 - l, m22 = k22 - l, m33 = k33 - l;
        const L b01 = k02 * k13 - k12 * k03, b02 = k02 * k23 - m22 * k03, b03 = k02 * m33 - k23 * k03;
        const L b12 = k12 * k23 - m22 * k13, b13 = k12 * m33 - k23 * k13, b23 = m22 * m33 - k23 * k23;
        const L a01 = m00 * m11 - k01 * k01, a02 = m00 * k12 - k02 * k01, a03 = m00 * k13 - k03 * k01;
        const L a12 = k01 * k12 - k02 * m11, a13 = k01 * k13 - k03 * m11;
        const L C00 = m11 * b23 - k12 * b13 + k13 * b12;
        const L C01 = k12 * b03 - k01 * b23 - k13 * b02;
        const L C02 = k01 * b13 - m11 * b03 + k13 * b01;
        const L C03 = m11 * b02 - k01 * b12 - k12 * b01;
        const L C11 = m00 * b23 - k02 * b03 + k03 * b02;
        const L C12 = k01 * b03 - m00 * b13 - k03 * b01;
        const L C13 = m00 * b12 - k01 * b02 + k02 * b01;
        const L C22 = k03 * a13 - k13 * a03 + m33 * a01;
        const L C23 = k13 * a02 - k03 * a12 - k23 * a01;
        const L C33 = k02 * a12 - k12 * a02 + m22 * a01;

        // The diagonal cofactors are negative: products of three negative eigenvalues and a square.
        const L zero = constant(0.0);
        L q0 = C00, q1 = C01, q2 = C02, q3 = C03, best = zero - C00;
        const auto take = [&](L diagonal, L w, L x, L y, L z) {
            const auto better = above(diagonal, best);
            best = choose(better, diagonal, best);
            q0 = choose(better, w, q0);
            q1 = choose(better, x, q1);
            q2 = choose(better, y, q2);
            q3 = choose(better, z, q3);
        };
        take(zero - C11, C01, C11, C12, C13);
        take(zero - C22, C02, C12, C22, C23);
        take(zero - C33, C03, C13, C23, C33);

        const L norm = q0 * q0 + q1 * q1 + q2 * q2 + q3 * q3;
        const L two = constant(2.0) / norm, one = constant(1.0);
        R[0] = one - two * (q2 * q2 + q3 * q3);
        R[1] = two * (q1 * q2 - q0 * q3);
        R[2] = two * (q1 * q3 + q0 * q2);
        R[3] = two * (q1 * q2 + q0 * q3);
        R[4] = one - two * (q1 * q1 + q3 * q3);
        R[5] = two * (q2 * q3 - q0 * q1);
        R[6] = two * (q1 * q3 - q0 * q2);
        R[7] = two * (q2 * q3 + q0 * q1);
        R[8] = one - two * (q1 * q1 + q2 * q2);
        return safe_ & above(norm, constant(1e-200));
    }

private:
    /// det(K - l I) = l^4 - 2 l^2 + c1 l + c0 for |A| = 1.
    void evaluate()
    {
        const L square = l * l;
        value_ = (square - constant(2.0)) * square + c1 * l + c0;
        slope_ = constant(4.0) * l * (square - constant(1.0)) + c1;
    }

    L k00, k11, k22, k33, k01, k02, k03, k12, k13, k23; ///< K of [Hor87]
    L c0, c1, l, value_, slope_, move_;
    Mask safe_;
};

} // namespace

// SPDX-License-Identifier: GPL-3.0-or-later
// The bodies of LayerKernels for lane_count points at a time, compiled once for each set of instructions.

#include "native/core/simd/lane_math.inl"

namespace sinew {

namespace {

using Wide = Lanes<double>;

constexpr double quarter_inverse_pi = 0.07957747154594766788;

/// Points in the frame of a face, and quantities of its corners and edges for these points.
struct View
{
    Wide x, y, d, d2;
    Wide r[most_layer_corners], r2[most_layer_corners];
    Wide h[most_layer_edges], L[most_layer_edges], R[most_layer_edges];
};

inline void look(const LayerFace& face, const double* points, int stride, View& view)
{
    const Wide px = load(points) - constant(face.origin[0]);
    const Wide py = load(points + stride) - constant(face.origin[1]);
    const Wide pz = load(points + 2 * stride) - constant(face.origin[2]);
    view.x = face.x[0] * px + face.x[1] * py + face.x[2] * pz;
    view.y = face.y[0] * px + face.y[1] * py + face.y[2] * pz;
    view.d = constant(0.0) - (face.n[0] * px + face.n[1] * py + face.n[2] * pz);
    view.d2 = view.d * view.d;
    for (int c = 0; c < face.corners; ++c) {
        const Wide dx = constant(face.corner[2 * c]) - view.x, dy = constant(face.corner[2 * c + 1]) - view.y;
        view.r2[c] = dx * dx + dy * dy + view.d2;
        view.r[c] = root(view.r2[c]);
    }
    const Wide zero = constant(0.0), two = constant(2.0);
    for (int k = 0; k < face.edges; ++k) {
        const LayerEdge& edge = face.edge[k];
        const Wide h = constant(edge.offset) - (edge.mx * view.x + edge.my * view.y);
        const Wide t0 = constant(edge.start) - (edge.sx * view.x + edge.sy * view.y);
        const Wide t1 = t0 + constant(edge.length);
        const Wide r0 = view.r[edge.from], r1 = view.r[edge.to];
        const Wide away = h * h + view.d2; // squared distance from the line
        const Wide floored = larger(away, constant(1e-36));
        // L = log((r0 + r1 + l)^2 / ((r0 + r1)^2 - l^2)); the denominator is 2 (away + t0 t1 + r0 r1), whose
        // last two terms cancel where the foot lies on the edge.
        const Wide sum = r0 + r1 + constant(edge.length);
        const Wide along = t0 * t1, apart = r0 * r1 - along;
        const auto beside = above(zero, along);
        const Wide top = sum * sum * choose(beside, apart, constant(1.0));
        const Wide bottom =
            two * choose(beside, floored * (apart + t0 * t0 + t1 * t1 + away), floored + along + r0 * r1);
        const Wide L = log_of_ratio(top, bottom);
        view.h[k] = h;
        view.L[k] = L;
        view.R[k] = constant(0.5) * (t1 * r1 - t0 * r0 + away * L);
    }
}

/// The signed solid angle of a panel over 4 pi.
inline Wide solid_angle(const LayerFace& face, const LayerPanel& panel, const View& view)
{
    const int a = panel.corner[0], b = panel.corner[1], c = panel.corner[2];
    const auto dot = [&](int k, int i, int j) {
        const double length = face.edge[panel.edge[k]].length;
        return constant(0.5) * (view.r2[i] + view.r2[j] - constant(length * length));
    };
    const Wide below = view.r[a] * view.r[b] * view.r[c] + dot(0, a, b) * view.r[c] +
                       dot(1, b, c) * view.r[a] + dot(2, c, a) * view.r[b];
    const Wide angle = constant(2.0 * quarter_inverse_pi) *
                       angle_between(magnitude(view.d) * constant(panel.double_area), below);
    return choose(above(constant(0.0), view.d), constant(0.0) - angle, angle);
}

/// S[1], lambda and the three S[hat] of a panel, times 4 pi; `omega` is the solid angle that solid_angle()
/// gives.
inline void flux(const LayerPanel& panel, const View& view, Wide omega, Wide& s, Wide* lambda, Wide* hats)
{
    const Wide h[3] = {panel.turn[0] * view.h[panel.edge[0]], panel.turn[1] * view.h[panel.edge[1]],
                       panel.turn[2] * view.h[panel.edge[2]]};
    s = h[0] * view.L[panel.edge[0]] + h[1] * view.L[panel.edge[1]] + h[2] * view.L[panel.edge[2]] -
        view.d * omega;
    for (int c = 0; c < 3; ++c) {
        lambda[c] = panel.inverse_height[c] * h[(c + 1) % 3];
        hats[c] = lambda[c] * s + panel.slope[c][0] * view.R[panel.edge[0]] +
                  panel.slope[c][1] * view.R[panel.edge[1]] + panel.slope[c][2] * view.R[panel.edge[2]];
    }
}

void single(const LayerFace& face, const double* points, int stride, int count, double* out)
{
    const int width = (face.corners + 3) / 4 * 4;
    View view;
    for (int i = 0; i < count; i += lane_count, out += lane_count * width) {
        look(face, points + i, stride, view);
        Wide sums[most_layer_corners];
        for (int k = 0; k < width; ++k)
            sums[k] = constant(0.0);
        for (int p = 0; p < face.panels; ++p) {
            const LayerPanel& panel = face.panel[p];
            const Wide omega = constant(1 / quarter_inverse_pi) * solid_angle(face, panel, view);
            Wide s, lambda[3], hats[3];
            flux(panel, view, omega, s, lambda, hats);
            for (int c = 0; c < 3; ++c)
                sums[panel.corner[c]] = sums[panel.corner[c]] + hats[c];
        }
        for (int k = 0; k < width; k += 4)
            store_rows(out + k, width, quarter_inverse_pi * sums[k], quarter_inverse_pi * sums[k + 1],
                       quarter_inverse_pi * sums[k + 2], quarter_inverse_pi * sums[k + 3]);
    }
}

void both(const LayerTriangle& triangle, const double* points, int stride, int count, double* out)
{
    const LayerPanel& panel = *triangle.face.panel;
    View view;
    for (int i = 0; i < count; i += lane_count) {
        look(triangle.face, points + i, stride, view);
        const Wide share = solid_angle(triangle.face, panel, view);
        const Wide omega = constant(1 / quarter_inverse_pi) * share;
        Wide s, lambda[3], hats[3], pull[3];
        flux(panel, view, omega, s, lambda, hats);
        for (int c = 0; c < 3; ++c) {
            pull[c] = constant(0.0) - (panel.slope[c][0] * view.L[0] + panel.slope[c][1] * view.L[1] +
                                       panel.slope[c][2] * view.L[2]);
            store(out + c * stride + i, lambda[c] * share + quarter_inverse_pi * (view.d * pull[c]));
            store(out + (4 + c) * stride + i, quarter_inverse_pi * hats[c]);
        }
        Wide product = constant(0.0);
        if (triangle.diagonal >= 0) {
            const int c = triangle.diagonal, j = (c + 1) % 3;
            Wide bend = triangle.product * s;
            for (int k = 0; k < 3; ++k)
                bend = bend - panel.slope[j][k] * (view.h[k] * (panel.slope[c][k] * view.L[k]) +
                                                   triangle.along[k] * (view.r[(k + 1) % 3] - view.r[k]));
            product = lambda[c] * lambda[j] * share +
                      quarter_inverse_pi * (view.d * (lambda[c] * pull[j] + lambda[j] * pull[c] + bend));
        }
        store(out + 3 * stride + i, product);
    }
}

} // namespace

const LayerKernels LayerKernels::SINEW_INSTRUCTIONS{sinew::single, sinew::both};

} // namespace sinew

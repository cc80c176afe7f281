// SPDX-License-Identifier: GPL-3.0-or-later
// The closed forms of CageKernels for lane_count points at a time, compiled once for each set of
// instructions.
//
// For a point x and a triangle, h is the height of x below the plane of the triangle, p_k the distance of the
// foot of x in that plane from side k (negative beyond it), t_a < t_b the beginning and the end of side k
// relative to the foot of x on its line, and D_k = sqrt(h^2 + p_k^2) the distance of x from that line.
// Everything follows from one integral per side, which two triangles share, and for Green coordinates from
// the solid angle.

#include "native/core/simd/lane_math.inl"

#ifdef __GNUC__
#define SINEW_APART __attribute__((noinline))
#else
#define SINEW_APART
#endif

namespace {

using sinew::CageEdge;
using sinew::CageTables;
using sinew::CageTriangle;
using L = Lanes<double>;

struct Vector
{
    L x, y, z;
};

inline L dot(const Vector& a, const Vector& b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
inline L dot(const double* a, const Vector& b)
{
    return constant(a[0]) * b.x + constant(a[1]) * b.y + constant(a[2]) * b.z;
}
inline Vector cross(const Vector& a, const Vector& b)
{
    return {a.y * b.z - a.z * b.y, a.z * b.x - a.x * b.z, a.x * b.y - a.y * b.x};
}

/// Entry i of an array with one number per lane in each entry.
inline double* at(double* lanes, int i) { return lanes + lane_count * static_cast<std::size_t>(i); }
inline const double* at(const double* lanes, int i)
{
    return lanes + lane_count * static_cast<std::size_t>(i);
}

inline Vector vector_at(const double* rays, int vertex)
{
    return {load(at(rays, 4 * vertex)), load(at(rays, 4 * vertex + 1)), load(at(rays, 4 * vertex + 2))};
}
inline L distance_at(const double* rays, int vertex) { return load(at(rays, 4 * vertex + 3)); }

/// The vectors from the points to every vertex: x, y, z and the length.
inline void aim(const CageTables& cage, const double* points, double* rays)
{
    const L x = load(points), y = load(at(points, 1)), z = load(at(points, 2));
    for (int v = 0; v < cage.vertex_count; ++v) {
        const double* const vertex = cage.vertices + 3 * static_cast<std::size_t>(v);
        const Vector r{constant(vertex[0]) - x, constant(vertex[1]) - y, constant(vertex[2]) - z};
        store(at(rays, 4 * v), r.x);
        store(at(rays, 4 * v + 1), r.y);
        store(at(rays, 4 * v + 2), r.z);
        store(at(rays, 4 * v + 3), root(dot(r, r)));
    }
}

inline void clear(double* lanes, int count)
{
    for (int i = 0; i < count; ++i)
        store(at(lanes, i), constant(0.0));
}

inline double size_of(double a) { return a < 0.0 ? -a : a; }
inline double root(double a) { return root(constant(a))[0]; }
inline double angle_between(double y, double x) { return angle_between(constant(y), constant(x))[0]; }

/// p times the integral of ds / ((D^2 + s^2)(p^2 + s^2)) over a side.
inline double edge_integral(double h, double p, double begin, double end)
{
    const double square = h * h + p * p, distance = root(square), length = end - begin;
    const double angle = angle_between(length * distance, square + begin * end);
    if (distance <= 32.0 * size_of(h)) {
        // By partial fractions: the angle in the plane less the angle in space, divided by h^2 = D^2 - p^2.
        const double side = size_of(p);
        const double flat = side > 0.0 ? angle_between(length * side, side * side + begin * end) : 0.0;
        return (p < 0.0 ? -1.0 : 1.0) * (flat - angle * side / distance) / (h * h);
    }
    // 1 / (p^2 + s^2) = sum of h^(2m) / (D^2 + s^2)^(m + 1). The integral of each power of 1 / (D^2 + s^2)
    // follows from that of the power before.
    const double at_begin = 1.0 / (square + begin * begin), at_end = 1.0 / (square + end * end);
    double from = begin, to = end, integral = angle / distance, sum = 0.0, power = 1.0;
    for (int m = 1; m <= 6; ++m) {
        from *= at_begin, to *= at_end;
        integral = ((to - from) + (2 * m - 1) * integral) / (2 * m * square);
        sum += power * integral;
        power *= h * h;
    }
    return p * sum;
}

inline double along(const CageEdge& edge, const double* rays, int vertex, int lane)
{
    double sum = 0.0;
    for (int axis = 0; axis < 3; ++axis)
        sum += edge.direction[axis] * at(rays, 4 * vertex + axis)[lane];
    return sum;
}

/// T of mean value, which is h times the integral of 1 / |y - x|^4 over the triangle, for one point whose
/// foot lies beyond a side. The terms of the sum that is used elsewhere have the size 1 / h, but T has the
/// size h, so that sum would lose its digits. Here, T is a sum of integrals of the sides that are as small as
/// T itself.
inline double integral_beyond(const CageTables& cage, const CageTriangle& triangle, const double* rays,
                              double h, const double* p, int lane)
{
    double sum = 0.0;
    if (size_of(h) > 1e-100) // a triangle whose plane has the point contributes nothing
        for (int k = 0; k < 3; ++k) {
            const CageEdge& edge = cage.edges[triangle.edges[k]];
            const double begin = along(edge, rays, edge.a, lane);
            sum += edge_integral(h, p[k], begin, begin + edge.length);
        }
    return -0.5 * h * sum;
}

constexpr double touch = 1e-14; ///< a point lies on a triangle if it is at most that far away

/// T of the lanes near the plane of triangle t. It is not inlined, so that the loop that calls it keeps its
/// registers.
SINEW_APART L near_plane(const CageTables& cage, int t, const double* rays, int near, L h, Vector p, L T,
                         int* on)
{
    for (int lane = 0; lane < lane_count; ++lane) {
        if (!(near >> lane & 1))
            continue;
        const double from_sides[3] = {p.x[lane], p.y[lane], p.z[lane]};
        double least = from_sides[0] < from_sides[1] ? from_sides[0] : from_sides[1];
        least = least < from_sides[2] ? least : from_sides[2];
        if (least >= -touch && size_of(h[lane]) <= touch) {
            on[lane] = on[lane] < 0 ? t : on[lane];
            T[lane] = 0.0;
        } else if (least < 0.0) {
            T[lane] = integral_beyond(cage, cage.triangles[t], rays, h[lane], from_sides, lane);
        }
    }
    return T;
}

/// |a x b| for the rays a, b to the ends of an edge, for the lanes that see the edge under an angle near pi:
/// there |a||b| + a.b would lose its digits.
SINEW_APART L flat_sines(const CageEdge& edge, const double* rays, int flat, L sine)
{
    for (int lane = 0; lane < lane_count; ++lane) {
        if (!(flat >> lane & 1))
            continue;
        const double *const a = at(rays, 4 * edge.a) + lane, *const b = at(rays, 4 * edge.b) + lane;
        double square = 1e-60;
        for (int axis = 0; axis < 3; ++axis) {
            const int next = (axis + 1) % 3, last = (axis + 2) % 3;
            const double part = *at(a, next) * *at(b, last) - *at(a, last) * *at(b, next);
            square += part * part;
        }
        sine[lane] = root(square);
    }
    return sine;
}

void mean_value(const CageTables& cage, const double* points, double* scratch, double* weights, double* sums,
                int* on)
{
    double* const rays = scratch;
    double* const integrals = at(scratch, 4 * cage.vertex_count);
    aim(cage, points, rays);
    clear(weights, cage.vertex_count);
    for (int lane = 0; lane < lane_count; ++lane)
        on[lane] = -1;

    // J, the integral of 1 / |y - x|^2 over an edge, is the angle of the edge divided by its distance. With
    // the rays a and b to the ends, |a x b|^2 = (|a||b| - a.b)(|a||b| + a.b).
    for (int e = 0; e < cage.edge_count; ++e) {
        const CageEdge& edge = cage.edges[e];
        const L product = distance_at(rays, edge.a) * distance_at(rays, edge.b);
        const L inner = dot(vector_at(rays, edge.a), vector_at(rays, edge.b));
        L sine = root(larger((product - inner) * (product + inner), constant(1e-60)));
        if (const int flat = mask_bits(above(constant(-0.9) * product, inner)))
            sine = flat_sines(edge, rays, flat, sine);
        store(at(integrals, e), constant(edge.length) * angle_over_sine(sine, inner));
    }

    for (int t = 0; t < cage.triangle_count; ++t) {
        const CageTriangle& triangle = cage.triangles[t];
        const Vector r0 = vector_at(rays, triangle.corners[0]), r1 = vector_at(rays, triangle.corners[1]),
                     r2 = vector_at(rays, triangle.corners[2]);
        const L h = dot(triangle.normal, r0);
        const L p0 = dot(triangle.outward[0], r1), p1 = dot(triangle.outward[1], r2),
                p2 = dot(triangle.outward[2], r0);
        const L J0 = load(at(integrals, triangle.edges[0])), J1 = load(at(integrals, triangle.edges[1])),
                J2 = load(at(integrals, triangle.edges[2]));
        const L half = constant(0.5);
        L T = half * (p0 * J0 + p1 * J1 + p2 * J2) / h;
        if (const int near = mask_bits(above(constant(triangle.near), magnitude(h))))
            T = near_plane(cage, t, rays, near, h, {p0, p1, p2}, T, on);
        const L g = half * h, g0 = g * J0, g1 = g * J1, g2 = g * J2;
        const L c0 = constant(triangle.cosines[0]), c1 = constant(triangle.cosines[1]),
                c2 = constant(triangle.cosines[2]);
        double* const w0 = at(weights, triangle.corners[0]);
        double* const w1 = at(weights, triangle.corners[1]);
        double* const w2 = at(weights, triangle.corners[2]);
        store(w0, load(w0) + constant(triangle.inverse_height[0]) * (p0 * T + (g0 + c2 * g1 + c1 * g2)));
        store(w1, load(w1) + constant(triangle.inverse_height[1]) * (p1 * T + (g1 + c0 * g2 + c2 * g0)));
        store(w2, load(w2) + constant(triangle.inverse_height[2]) * (p2 * T + (g2 + c1 * g0 + c0 * g1)));
    }

    L sum = constant(0.0), magnitudes = sum;
    for (int v = 0; v < cage.vertex_count; ++v) {
        const L w = load(at(weights, v));
        sum = sum + w;
        magnitudes = magnitudes + magnitude(w);
    }
    const L factor = constant(1.0) / sum;
    for (int v = 0; v < cage.vertex_count; ++v)
        store(at(weights, v), factor * load(at(weights, v)));
    store(sums, sum / magnitudes);
}

/// The inner product with a vector whose coordinates are `stride` numbers apart.
inline double along(const double* direction, const double* v, int stride)
{
    return direction[0] * v[0] + direction[1] * v[stride] + direction[2] * v[2 * stride];
}

/// A point is near a side if the sum of its distances from the ends is less than this times the length of the
/// side.
constexpr double near_side = 1.001;

/// The quantities of a side for a point near it. Distances from the ends would not say how near it is, so all
/// of them are computed from `foot`, the vector from the point to its foot on the line of the side. Both
/// triangles at the side use the same foot.
struct NearSide
{
    double foot[3], begin, end, square; ///< t_a, t_b, D^2
    double to_a, to_b; ///< distances of the ends from the point
    double gap; ///< |a| |b| + a.b for the vectors a, b to the ends; zero on the side

    NearSide(const CageEdge& edge, const double* rays, int lane)
    {
        const double* const a = at(rays, 4 * edge.a) + lane;
        const double* const b = at(rays, 4 * edge.b) + lane;
        const bool nearer_a = *at(a, 3) <= *at(b, 3);
        const double* const from = nearer_a ? a : b;
        const double t = along(edge.direction, from, lane_count);
        for (int axis = 0; axis < 3; ++axis)
            foot[axis] = *at(from, axis) - t * edge.direction[axis];
        // The foot is made orthogonal to the side a second time: compared with a short foot, the rounding
        // error of the first time is large.
        const double rest = along(edge.direction, foot, 1);
        square = 0.0;
        for (int axis = 0; axis < 3; ++axis) {
            foot[axis] -= rest * edge.direction[axis];
            square += foot[axis] * foot[axis];
        }
        begin = nearer_a ? t : t - edge.length;
        end = nearer_a ? t + edge.length : t;
        to_a = root(square + begin * begin);
        to_b = root(square + end * end);
        const double product = square + begin * end;
        gap = product < 0.0 ? edge.length * edge.length * square / (to_a * to_b - product)
                            : to_a * to_b + product;
    }

    bool touches() const { return square <= 1e-26 && begin <= 1e-13 && end >= -1e-13; }
};

/// h, p and the solid angle at one point near side k.
struct NearTriangle
{
    double h, p[3], half_angle; ///< half the solid angle, negative for a point above the triangle

    NearTriangle(const CageTables& cage, const CageTriangle& triangle, const double* rays, int k, int lane)
    {
        const CageEdge& edge = cage.edges[triangle.edges[k]];
        const NearSide side(edge, rays, lane);
        const double* const r[3] = {at(rays, 4 * triangle.corners[0]) + lane,
                                    at(rays, 4 * triangle.corners[1]) + lane,
                                    at(rays, 4 * triangle.corners[2]) + lane};
        h = along(triangle.normal, side.foot, 1);
        for (int i = 0; i < 3; ++i)
            p[i] = along(triangle.outward[i], r[(i + 1) % 3], lane_count);
        p[k] = along(triangle.outward[k], side.foot, 1);
        // The denominator of the solid angle is |c| gap + (b |a| + a |b|).c. a and b are the foot plus a
        // vector along the edge, of the length begin or end. With that, the bracket is a sum of small terms,
        // without cancellation.
        const double across = along(side.foot, r[k], lane_count),
                     parallel = along(edge.direction, r[k], lane_count);
        const double sum = side.to_a + side.to_b;
        const double lean = side.begin < 0.0 && side.end > 0.0
                                ? side.square * (side.end * side.end - side.begin * side.begin) /
                                      (side.end * side.to_a - side.begin * side.to_b)
                                : side.end * side.to_a + side.begin * side.to_b;
        const double x = *at(r[k], 3) * side.gap + across * sum + parallel * lean;
        const double y = size_of(h) * triangle.double_area;
        half_angle = y > 0.0 || x != 0.0 ? angle_between(y, x) : 0.0;
        half_angle = h < 0.0 ? -half_angle : half_angle;
    }
};

/// h, p and half the solid angle of a triangle for all lanes.
struct Near
{
    L h;
    Vector p;
    L angle;
};

/// Replaces the values of lanes near a side by those of NearTriangle, for the side with the least gap.
SINEW_APART Near near_sides(const CageTables& cage, const CageTriangle& triangle, const double* rays,
                            int near, Near found)
{
    for (int lane = 0; lane < lane_count; ++lane) {
        if (!(near >> lane & 1))
            continue;
        double gap[3];
        for (int k = 0; k < 3; ++k)
            gap[k] = at(rays, 4 * triangle.corners[(k + 1) % 3] + 3)[lane] +
                     at(rays, 4 * triangle.corners[(k + 2) % 3] + 3)[lane] -
                     near_side * cage.edges[triangle.edges[k]].length;
        const int first = gap[1] < gap[0] ? 1 : 0, k = gap[2] < gap[first] ? 2 : first;
        const NearTriangle close(cage, triangle, rays, k, lane);
        found.h[lane] = close.h;
        found.p.x[lane] = close.p[0];
        found.p.y[lane] = close.p[1];
        found.p.z[lane] = close.p[2];
        found.angle[lane] = close.half_angle;
    }
    return found;
}

/// The integral of 1 / |y - x| over an edge for the lanes near it. Sets the bits of the lanes that lie on it in
/// `touching`.
SINEW_APART L near_logs(const CageEdge& edge, const double* rays, int near, L log, int& touching)
{
    for (int lane = 0; lane < lane_count; ++lane) {
        if (!(near >> lane & 1))
            continue;
        const NearSide side(edge, rays, lane);
        const double s = side.to_a + side.to_b + edge.length;
        log[lane] = log_of_ratio(constant(s * s), constant(2.0 * side.gap + 1e-60))[0];
        touching |= side.touches() ? 1 << lane : 0;
    }
    return log;
}

int green(const CageTables& cage, const double* points, double* scratch, int* near_edge, double* phi,
          double* psi, double* winding)
{
    constexpr double quarter = 0.079577471545947668; // 1 / (4 pi)
    double* const rays = scratch;
    double* const logs = at(scratch, 4 * cage.vertex_count);
    aim(cage, points, rays);
    clear(phi, cage.vertex_count);
    L around = constant(0.0);
    int touching = 0;

    // The integral of 1 / |y - x| over an edge, divided by 4 pi, and the inner product of the rays to its
    // ends.
    for (int e = 0; e < cage.edge_count; ++e) {
        const CageEdge& edge = cage.edges[e];
        const L sum = distance_at(rays, edge.a) + distance_at(rays, edge.b);
        const L length = constant(edge.length), gap = sum - length;
        const auto near_lanes = above(constant(near_side * edge.length), sum);
        L log = log_of_ratio(sum + length, choose(near_lanes, length, gap));
        near_edge[e] = mask_bits(near_lanes);
        if (near_edge[e])
            log = near_logs(edge, rays, near_edge[e], log, touching);
        store(at(logs, 2 * e), constant(quarter) * log);
        store(at(logs, 2 * e + 1), dot(vector_at(rays, edge.a), vector_at(rays, edge.b)));
    }

    for (int t = 0; t < cage.triangle_count; ++t) {
        const CageTriangle& triangle = cage.triangles[t];
        const int *const v = triangle.corners, *const e = triangle.edges;
        const Vector r0 = vector_at(rays, v[0]), r1 = vector_at(rays, v[1]), r2 = vector_at(rays, v[2]);
        const L d0 = distance_at(rays, v[0]), d1 = distance_at(rays, v[1]), d2 = distance_at(rays, v[2]);
        L h = dot(triangle.normal, r0);
        Vector p{dot(triangle.outward[0], r1), dot(triangle.outward[1], r2), dot(triangle.outward[2], r0)};
        const L l0 = load(at(logs, 2 * e[0])), l1 = load(at(logs, 2 * e[1])), l2 = load(at(logs, 2 * e[2]));
        const L cosine = d0 * d1 * d2 + load(at(logs, 2 * e[0] + 1)) * d0 +
                         load(at(logs, 2 * e[1] + 1)) * d1 + load(at(logs, 2 * e[2] + 1)) * d2;
        L angle = signed_as(angle_between(constant(triangle.double_area) * magnitude(h), cosine), h);
        if (const int near = near_edge[e[0]] | near_edge[e[1]] | near_edge[e[2]]) {
            const Near found = near_sides(cage, triangle, rays, near, {h, p, angle});
            h = found.h, p = found.p, angle = found.angle;
        }
        angle = constant(2.0 * quarter) * angle;
        around = around + angle;
        store(at(psi, t), p.x * l0 + p.y * l1 + p.z * l2 - h * angle);
        const L g0 = h * l0, g1 = h * l1, g2 = h * l2;
        const L c0 = constant(triangle.cosines[0]), c1 = constant(triangle.cosines[1]),
                c2 = constant(triangle.cosines[2]);
        double* const f0 = at(phi, v[0]);
        double* const f1 = at(phi, v[1]);
        double* const f2 = at(phi, v[2]);
        store(f0, load(f0) + constant(triangle.inverse_height[0]) * (p.x * angle + (g0 + c2 * g1 + c1 * g2)));
        store(f1, load(f1) + constant(triangle.inverse_height[1]) * (p.y * angle + (g1 + c0 * g2 + c2 * g0)));
        store(f2, load(f2) + constant(triangle.inverse_height[2]) * (p.z * angle + (g2 + c1 * g0 + c0 * g1)));
    }
    store(winding, around);
    return touching;
}

void arc_integrals(const double* arcs, int blocks, double* integrals)
{
    constexpr int width = sinew::most_cage_lanes;
    for (int block = 0; block < blocks; ++block, arcs += 6 * width, integrals += 3 * width)
        for (int first = 0; first < width; first += lane_count) {
            const auto read = [&](int row) { return load(arcs + row * width + first); };
            const Vector a{read(0), read(1), read(2)}, b{read(3), read(4), read(5)}, normal = cross(a, b);
            const L sine = root(dot(normal, normal) + constant(1e-60));
            const L half = constant(0.5) * angle_over_sine(sine, dot(a, b));
            store(integrals + first, half * normal.x);
            store(integrals + width + first, half * normal.y);
            store(integrals + 2 * width + first, half * normal.z);
        }
}

void beyond_planes(const float* points, int count, const float* planes, int* beyond)
{
    constexpr float sure = 2e-6f;
    const float *ux = points, *uy = ux + count, *uz = uy + count;
    const float *px = uz + count, *py = px + count, *pz = py + count;
    const float *n0 = planes, *n1 = n0 + 4, *n2 = n1 + 4, *n3 = n2 + 4;
    for (int v = 0; v < count; ++v) { // without inner loops, so that the compiler vectorises it
        const float a = n0[0] * ux[v] + n0[1] * uy[v] + n0[2] * uz[v];
        const float b = n1[0] * ux[v] + n1[1] * uy[v] + n1[2] * uz[v];
        const float c = n2[0] * ux[v] + n2[1] * uy[v] + n2[2] * uz[v];
        const float d = n3[0] * px[v] + n3[1] * py[v] + n3[2] * pz[v] - n3[3];
        beyond[v] = (a < -sure ? 1 : 0) | (b < -sure ? 2 : 0) | (c < -sure ? 4 : 0) | (d > sure ? 8 : 0);
    }
}

} // namespace

#undef SINEW_APART

const sinew::CageKernels sinew::CageKernels::SINEW_INSTRUCTIONS{lane_count, ::mean_value, ::green,
                                                                ::arc_integrals, ::beyond_planes};

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/core/options.h"
#include "native/core/simd/aligned.h"
#include "native/methods/space/method.h"

#include <vector>

namespace sinew {

/// The settings of wires. `radius`, `scale` and `rotation` hold one number for all curves, or one per curve.
struct WireOptions
{
    std::vector<int> counts{}; ///< samples of each curve, in order; empty: all samples are one curve
    std::vector<bool> closed{};
    std::vector<double> radius{1.0};
    std::vector<double> scale{1.0};
    std::vector<double> rotation{1.0};
    Points domain{};
    double exponent = 1.0;
    double smoothing = 0.2;

    static constexpr auto table()
    {
        using O = WireOptions;
        return std::tuple{
            option("closed", &O::closed, Rebind::anew,
                   "None, a flag, or (k,) flags: the curves whose last sample is joined to the first"),
            option_of_each("radius", &O::radius, more_than(0), "how far from the curve points follow it"),
            option_of_each("scale", &O::scale, any_number(),
                           "of the distances from the curve, near the curve; it acts at rest, too"),
            option_of_each("rotation", &O::rotation, between(0, 1),
                           "how much of the turn of the curve points follow"),
            option("domain", &O::domain, Rebind::anew,
                   "None, or (c, 3) samples of domain curves, NaN for curves without one: in the direction "
                   "of its domain curve, a wire reaches as far as that"),
            option("exponent", &O::exponent, Rebind::anew, at_least(0),
                   "of several wires, those with a longer move prevail the more, the larger it is"),
            option("smoothing", &O::smoothing, Rebind::anew, at_least(0),
                   "how much farther than the nearest place of a curve others count, as a share; with 0 "
                   "only the nearest counts, and the warp jumps where that jumps")};
    }
};

/// Wires: curves that carry the space around them.
///
/// K. Singh, E. Fiume. "Wires: A Geometric Deformation Technique." SIGGRAPH 1998, pp. 405-414. Tutorial,
/// section 5.4.
///
/// R is a curve at rest, W the same curve now. A point x with its nearest point R(p), at the distance d, has
/// the share F = f(d / r) with f(t) = (1 - t^2)^2 for t < 1, else 0. It is scaled about R(p) by
/// 1 + (s - 1) F, then turned about R(p) by F times the smallest turn from R'(p) to W'(p), then moved by
/// F (W(p) - R(p)). With the moves D_i of several wires,
///
///     x' = x + sum_i D_i |D_i|^m / sum_i |D_i|^m
///
/// so that wires at the same place do not add up. R and W are sampled at the same parameters; p is a place
/// between two samples, not a share of the length. A point on a wire follows it exactly, and a point outside
/// every radius stays. The scale acts at rest, too; with scale 1, rest gives rest to the last bit.
///
/// Departs from the paper, where x jumps when its nearest point does, for example inside a bent wire: R(p),
/// W(p) and the turn are means over the segments of the curve, each at its own point nearest to x at the
/// distance d_j, with the weight l_j (1 - (d_j^2 - d^2) / (((1 + s)^2 - 1) d^2))^2 of all whose d_j is less
/// than (1 + s) d; l_j is the length. So x' is continuous, and nothing is averaged on the wire itself. s = 0
/// is the paper's rule.
///
/// A domain curve D limits a wire: towards D(p) the radius is |D(p) - R(p)|, and in a direction that has
/// the angle a < 90 degrees to it, r + (|D(p) - R(p)| - r) cos^2 a.
///
///   call          repeat it when ...            cost
///   constructor   the rest curves changed       O(samples)
///   bind()        the points changed            O(points x segments within reach)
///   warp()        the curves moved              O(samples + contacts); nothing for points out of reach
///
/// Memory: 4 bytes per point, and per point and wire in whose reach it is about 46 bytes, with 8 for each of
/// the samples that it follows, or one of three neighbours if that follows more: two, and with smoothing some
/// more far from the wire.
class Wires : public SpaceMethod
{
public:
    /// \param reference  (c, 3) samples of the curves at rest, one curve after the other.
    /// \throw InvalidConstraint  a sample is not finite, or a curve has no length (the elements are curves).
    /// \throw InvalidOption      an option is out of its range, or there is another number of values.
    explicit Wires(Points reference, const WireOptions& options = {});

    int curve_count() const { return static_cast<int>(options_.counts.size()); }
    Eigen::Index sample_count() const { return reference_.rows(); }

protected:
    void compute(PointsView points, SpaceReport& report, const Progress& progress) override;
    void displace(PointsView control, PointsView base, PositionsOut out) const override;
    std::vector<std::string> changed_settings(const SpaceMethod& former) const override;
    void swap_weights(SpaceMethod& other) override;

private:
    /// A run of samples.
    struct Curve
    {
        int begin, end;
        bool closed, has_domain;
        double radius, scale, rotation;
        double reach; ///< no point farther away than this follows
        Vector3 low, high; ///< the box of the samples
    };
    /// A point in the reach of a curve.
    struct Contact
    {
        Vector3 from; ///< x - R(p)
        double falloff; ///< F
        double stretch; ///< (s - 1) F
        int shares; ///< how many it has
    };
    /// A segment of a curve that a point is near to: its nearest place is a + along (b - a).
    struct Near
    {
        int from, to;
        double along, square, length; ///< the squared distance of the point, and how long the segment is
    };
    /// What is found of some points. Point i has the contacts [begins[i], begins[i + 1]).
    struct Found
    {
        std::vector<int> begins;
        std::vector<Contact> contacts;
        std::vector<int> samples; ///< for each share of a contact, the sample that it belongs to
        std::vector<double> shares; ///< of one contact, they sum to 1
        std::vector<Near> segments; ///< of the curve that is looked at, kept for its memory
    };
    /// The same as the kernels read it, see WireContacts. The last block is filled with contacts without
    /// shares.
    struct Contacts
    {
        std::vector<int> begins{0}, firsts{0}, rows{0}, samples;
        AlignedVector<double> shares, blocks;
    };

    void add_curves();
    void check_lengths() const;
    /// Samples at the same place have no direction between them, so a tangent is taken between others.
    void find_neighbours();
    void add_contacts(const Vector3& x, Found& found) const;
    void add_contact(const Curve& curve, const Vector3& x, Found& found) const;
    static void append(const Found& part, Found& waiting, Contacts& all);
    /// Moves contacts that wait into blocks: four each, and in the end what is left.
    static void pack(Found& waiting, bool end, Contacts& all);
    /// The turn of a sample as an axis times an angle.
    Vector3 turn(const Curve& curve, int sample, PointsView control) const;
    /// (c, 8) the move of each sample and 0, then its turn and 0; with rows of zeros behind, for WireKernels.
    AlignedVector<double> table(PointsView control) const;

    Points reference_;
    WireOptions options_;
    std::vector<Curve> curves_;
    std::vector<int> before_, after_; ///< samples between which the tangent at each sample is taken
    Contacts contacts_;
};

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/attachments/frames/patch.h"

#include "native/attachments/sampling.h"
#include "native/core/dense.h"

#include <algorithm>
#include <numeric>
#include <unordered_set>

namespace sinew {

namespace {

constexpr int most_contacts = 48;

void normalise(std::vector<double>& weights)
{
    const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
    for (double& w : weights)
        w /= sum;
}

Vector3 centroid(const std::vector<Vector3>& points, const std::vector<double>& weights)
{
    Vector3 sum = Vector3::Zero();
    double total = 0.0;
    for (std::size_t i = 0; i < points.size(); ++i) {
        sum += weights[i] * (points[i] - points[0]);
        total += weights[i];
    }
    return points[0] + sum / total;
}

/// The least change of weights that moves the centroid of points to `aim`, within bounds.
void tilt(std::vector<double>& weights, const std::vector<Vector3>& points, const Vector3& aim)
{
    normalise(weights);
    const Vector3 middle = centroid(points, weights);
    Matrix3 spread = Matrix3::Zero();
    for (std::size_t i = 0; i < points.size(); ++i)
        spread += weights[i] * (points[i] - middle) * (points[i] - middle).transpose();
    const Eigenvectors<3> axes = eigenvectors(spread);
    Vector3 slope = Vector3::Zero();
    for (int k = 0; k < 3; ++k) { // not along an axis along which the patch has hardly any width
        const double wide = axes.values[k];
        if (wide > 1e-3 * axes.values[2])
            slope += axes.vectors.col(k) * (axes.vectors.col(k).dot(aim - middle) / wide);
    }
    for (std::size_t i = 0; i < points.size(); ++i)
        weights[i] *= std::clamp(1.0 + (points[i] - middle).dot(slope), 0.05, 4.0);
    normalise(weights);
}

std::vector<Vector3> centres_of(const HostSurface& host, const std::vector<int>& triangles)
{
    std::vector<Vector3> centres;
    for (int t : triangles)
        centres.push_back(host.centres()[t]);
    return centres;
}

/// The triangles of the balls around the contacts, as far as the host joins them to the first one.
Patch joined_to_first(const HostSurface& host, const std::vector<Contact>& contacts, double radius)
{
    const double reach = radius * radius;
    double sum = 0.0;
    for (const Contact& contact : contacts)
        sum += contact.weight;
    std::vector<int> open{contacts.front().triangle};
    std::unordered_set<int> seen{open.front()}; // a patch is much smaller than its host
    Patch patch;
    while (!open.empty()) {
        const int t = open.back();
        open.pop_back();
        double kernel = 0.0;
        for (const Contact& contact : contacts) {
            const double far = (host.centres()[t] - contact.point).squaredNorm();
            if (far < reach)
                kernel += contact.weight * (1 - far / reach) * (1 - far / reach);
        }
        // What is beneath a contact counts also where triangles are so large that no centre is within reach.
        if (kernel == 0.0 && std::ranges::find(contacts, t, &Contact::triangle) == contacts.end())
            continue;
        patch.triangles.push_back(t);
        patch.weights.push_back(host.areas()[t] * std::max(kernel, 1e-12 * sum));
        for (int v : host.triangles()[t])
            for (int neighbour : host.around(v))
                if (seen.insert(neighbour).second)
                    open.push_back(neighbour);
    }
    return patch;
}

/// \param weight  which of a contact's numbers counts.
Vector3 centroid(const std::vector<Contact>& contacts, double Contact::* weight)
{
    std::vector<Vector3> points;
    std::vector<double> weights;
    for (const Contact& contact : contacts) {
        points.push_back(contact.point);
        weights.push_back(contact.*weight);
    }
    return centroid(points, weights);
}

/// Weighs the triangles of a patch by how near they are to the anchors.
void set_anchors(Patch& patch, const std::vector<Vector3>& centres, const std::vector<Contact>& contacts,
                 double radius)
{
    const double reach = radius * radius / 16;
    std::vector<double> near(centres.size(), 0.0);
    double total = 0.0;
    for (const Contact& contact : contacts) {
        total += contact.anchor;
        for (std::size_t i = 0; i < centres.size(); ++i) {
            const double rest = std::max(0.0, 1 - (centres[i] - contact.point).squaredNorm() / reach);
            near[i] += contact.anchor * rest * rest;
        }
    }
    patch.anchors = patch.weights;
    const double nearest = std::ranges::max(near);
    if (nearest > 0.0) // otherwise the triangles are too large to choose among them
        for (std::size_t i = 0; i < centres.size(); ++i)
            patch.anchors[i] *= near[i] / nearest + 1e-3;
    if (total > 0.0)
        tilt(patch.anchors, centres, centroid(contacts, &Contact::anchor));
    else
        normalise(patch.anchors);
}

} // namespace

Patch patch_beneath(const HostSurface& host, const std::vector<Contact>& contacts, int best, double radius,
                    int most)
{
    // The best contact first, then the heaviest ones; equal ones in their order.
    std::vector<Contact> heavy{contacts[best]};
    std::vector<int> order(contacts.size());
    std::iota(order.begin(), order.end(), 0);
    std::ranges::stable_sort(order, std::ranges::greater(), [&](int i) { return contacts[i].weight; });
    for (int i : order)
        if (i != best && contacts[i].weight > 1e-2 * contacts[order.front()].weight &&
            static_cast<int>(heavy.size()) < most_contacts)
            heavy.push_back(contacts[i]);

    Patch patch = joined_to_first(host, heavy, radius);
    std::vector<int> kept = patch.triangles;
    std::ranges::sort(kept);
    std::erase_if(
        heavy, [&](const Contact& contact) { return !std::ranges::binary_search(kept, contact.triangle); });
    const std::vector<Vector3> centres = centres_of(host, patch.triangles);
    tilt(patch.weights, centres, centroid(heavy, &Contact::weight));
    if (static_cast<int>(patch.triangles.size()) <= most) {
        set_anchors(patch, centres, heavy, radius);
        return patch;
    }

    const Vector3 aim = centroid(centres, patch.weights);
    const auto heaviest = std::ranges::max_element(patch.weights) - patch.weights.begin();
    Patch thinned;
    std::vector<Vector3> chosen;
    for (int i : farthest_points(centres, most, static_cast<int>(heaviest))) {
        thinned.triangles.push_back(patch.triangles[i]);
        chosen.push_back(centres[i]);
    }
    thinned.weights.assign(thinned.triangles.size(), 0.0);
    for (std::size_t i = 0; i < centres.size(); ++i) {
        const auto nearest = std::ranges::min_element(
            chosen, {}, [&](const Vector3& point) { return (point - centres[i]).squaredNorm(); });
        thinned.weights[nearest - chosen.begin()] += patch.weights[i];
    }
    tilt(thinned.weights, chosen, aim);
    set_anchors(thinned, chosen, heavy, radius);
    return thinned;
}

bool reaches_mirror_plane(const Patch& patch, const HostSurface& host)
{
    return std::ranges::any_of(patch.triangles,
                               [&](int t) { return host.is_near_mirror_plane(host.centres()[t]); });
}

Patch mirror_image(const Patch& patch, const HostSurface& host)
{
    Patch image{.triangles = {}, .weights = patch.weights, .anchors = patch.anchors, .images = {}};
    for (const int t : patch.triangles)
        image.images.push_back(host.mirror_image(host.triangles()[t]));
    return image;
}

void add_mirror_image(Patch& patch, const HostSurface& host)
{
    patch.images = mirror_image(patch, host).images;
    for (std::vector<double>* weights : {&patch.weights, &patch.anchors}) {
        for (double& weight : *weights)
            weight /= 2.0;
        weights->insert(weights->end(), weights->begin(), weights->end());
    }
}

} // namespace sinew

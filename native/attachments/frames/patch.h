// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/attachments/host_surface.h"

#include <vector>

namespace sinew {

/// A point of a host that lies beneath an attached part.
struct Contact
{
    Vector3 point;
    int triangle; ///< of the host's triangles()
    double weight;
    double anchor; ///< how much the point decides where the attached part is, not how it turns
};

/// Some triangles of a host. Both kinds of weights sum to 1.
struct Patch
{
    std::vector<int> triangles; ///< of the host's triangles()
    std::vector<double> weights; ///< for the turn
    std::vector<double> anchors; ///< for the place
    std::vector<Triangle> images; ///< of the host's part: further triangles, whose weights come after these
};

/// The patch beneath a frame: triangles t whose centre c_t is nearer than r to the contacts y_v, with weights
///
///     w_t = A_t sum_v c_v max(0, 1 - |c_t - y_v|^2 / r^2)^2,
///
/// of these the ones that are joined to the best contact over the host and inside the balls of radius r,
/// which keeps out another limb or lip nearby. They are thinned out to at most `most` and tilted: changed by
/// the least amount that puts their centroid where that of the contacts is. Of the contacts, the 48 heaviest
/// count.
///
/// A wide patch sags towards the inside of a bend by half its mean square width times the curvature. So the
/// place is read off the anchors: the same triangles, but near the contacts that are anchors.
/// Cost: O(contacts) for each triangle in the balls.
/// \param best  index of the best contact.
Patch patch_beneath(const HostSurface& host, const std::vector<Contact>& contacts, int best, double radius,
                    int most);

/// Whether a patch reaches the host's mirror plane, to an edge: what lies between two limbs follows one of
/// them.
bool reaches_mirror_plane(const Patch& patch, const HostSurface& host);

/// The image of a patch in the host's mirror plane. Its corners are vertices of the host, so the diagonals of
/// faces do not count.
Patch mirror_image(const Patch& patch, const HostSurface& host);

/// Joins a patch with its image in the host's mirror plane.
void add_mirror_image(Patch& patch, const HostSurface& host);

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/multiresolution/details/fairing.h"
#include "tests/native/methods/multiresolution/bumpy_plate.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <string>

namespace sinew {

/// The study's plate, whose ends in x and open border are held, and its base.
struct Study
{
    explicit Study(int cells, double height = 0.8)
        : mesh(bumps::plate(cells, height)), regions([&] {
              const Components parts = connected_components(mesh);
              return faired_regions(mesh, Regions(shapes::ends(mesh, 10.01 / cells), parts), parts);
          }()),
          fairing(mesh, regions, 6.0), rings(std::make_shared<const RingRotations>(mesh))
    {
        fairing.smooth(view(mesh.points()), base);
    }

    const Points& fine() const { return mesh.points(); }

    SurfaceMesh mesh;
    Regions regions;
    Fairing fairing;
    std::shared_ptr<const RingRotations> rings;
    Points base;
};

/// What a coding of details promises. Tolerances are lengths on a plate of side 10.
struct CodingTraits
{
    std::string name;
    std::function<std::unique_ptr<DetailCoding>(const Study&)> make;
    double bent_up, bent_down; ///< edge strain (rms) after a bend by 120 degrees, as measured once
    double zero = 1e-14, rigid = 1e-12;
    bool similar = false; ///< whether a scale of the base scales the details
};

inline void PrintTo(const CodingTraits& traits, std::ostream* out) { *out << traits.name; }

/// What every coding of details does.
class CodingContract : public testing::TestWithParam<CodingTraits>
{
};

} // namespace sinew

// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/surface/method.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace sinew {

/// One set of options of a surface method.
struct SurfaceVariant
{
    std::string name;
    std::function<std::shared_ptr<SurfaceMethod>(const SurfaceMesh&)> make;
    int factorizations = 1; ///< of one set_handles()
    bool separate = true;   ///< no part of the mesh feels another one
    double affine = 0.0;    ///< how exact one affine map of all handles is; 0: it is not reproduced
};

/// What a method promises beyond what all surface methods do, and how exactly. Tolerances are lengths on
/// `mesh`.
struct SurfaceTraits
{
    std::string name;
    std::vector<SurfaceVariant> variants; ///< the first has the default options
    SurfaceMesh mesh;                     ///< long in x
    SurfaceMesh large;                    ///< likewise; where bits and drags are compared
    double depth;                         ///< of the handles at its ends
    Poses bent;                           ///< of these handles: a large motion
    /// A closed motion of the handles of `large`, for t in [0, 1].
    std::function<Poses(double t)> drag;
    int drag_steps;
    double follow, slack; ///< a step moves the surface by at most follow * (step of the handle) + slack

    double rest = 0.0;               ///< handles at rest; 0: to the bit
    double incoming = 0.0; ///< likewise, for a shape that enters, each point moved by up to `noise`
    double noise = 1.0;
    double translation = 1e-6; ///< all handles translated
    std::optional<double> rigid{}; ///< all handles moved rigidly, a share of the size; none: not reproduced
    double held = 1e-13; ///< vertices of a handle
    double alone = 1e-12; ///< a vertex that is a handle
    double similar = 1e-6; ///< seen from elsewhere
    double apart = 1e-9; ///< what a part without handles changes in the others
    double messy = 20.0; ///< how far points of shapes::messy() go
    int degenerate_faces = 3; ///< of shapes::messy(), as reported; 0 for a method that needs no areas
    double folded = 1e-9; ///< what faces of one corner repeated change
    double soft = 1e-4; ///< gap at a handle of weight 1 - 1e-6
    double all_soft = 1e9; ///< gap where all handles have the weight 0.7
    int soft_iterations = 100;
    double rides = 0.0; ///< what a handle that moves with the incoming shape changes; 0: not asked
    bool turns_incoming = false; ///< with a shape that enters turned, all is turned, up to `similar`
    bool parts_apart = false; ///< parts with handles do not feel other parts with handles, up to `apart`
    int half_turns = 0; ///< vertices of `mesh` whose way a rule chooses where a handle turns by 180 degrees
    bool iterative = false; ///< each iteration lowers the energy
    int settles = 0;        ///< iterations after which unrelated starts meet; 0: they need not
    int settling = 1;       ///< for how many of the variants
    /// Where solves after the first one allocate no block of one number per vertex; none: they may.
    std::optional<SurfaceMesh> many{};
    bool many_enter = false; ///< also with a shape that enters
    bool many_soft = false;  ///< also with a soft handle
    std::vector<std::string> allocates{}; ///< the variants that may
    std::string updates{}; ///< an option of which rebind() updates the factor, and
    std::function<std::shared_ptr<SurfaceMethod>(const SurfaceMesh&)>
        updated{}; ///< ... an object with another value
    std::function<std::shared_ptr<SurfaceMethod>(const SurfaceMesh&)>
        other{}; ///< other options that need a new factor
};

inline void PrintTo(const SurfaceTraits& traits, std::ostream* out) { *out << traits.name; }

/// What every surface method does. A method takes part by one line in its own test:
///
///     INSTANTIATE_TEST_SUITE_P(ThinShell, SurfaceContract, testing::Values(traits()));
class SurfaceContract : public testing::TestWithParam<SurfaceTraits>
{
protected:
    const SurfaceTraits& traits() const { return GetParam(); }
    const SurfaceMesh& mesh() const { return traits().mesh; }
    std::vector<Handle> ends() const { return shapes::ends(mesh(), traits().depth); }
    /// A small mesh, and one of 1,271 vertices, as methods may treat large ones in another way.
    static std::vector<const SurfaceMesh*> sizes()
    {
        static const SurfaceMesh small = shapes::hill(8, 8), large = shapes::hill(40, 30);
        return {&small, &large};
    }
};

} // namespace sinew

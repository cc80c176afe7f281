// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/method.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

namespace sinew {

/// One set of options of a space method.
struct SpaceVariant
{
    std::string name;
    std::function<std::shared_ptr<SpaceMethod>()> make; ///< around the control of the traits
};

/// What a method promises beyond what all space methods do, and how exactly. Tolerances are shares of the
/// control's size.
struct SpaceTraits
{
    std::string name;
    std::vector<SpaceVariant> variants;
    Points control; ///< (c, 3) at rest
    Points points;  ///< (n, 3) that can be bound, n >= 200
    std::optional<double> translation = 1e-12; ///< translations of the control; none: not reproduced
    std::optional<double> similarity{}; ///< similarities of the control; none: not reproduced
    std::optional<double> affine{};     ///< affine maps
    double follow = 1.5;                ///< no point goes farther in a step than this times the control
    /// Not 'the displacements are those of the rest shape', but 'the shape that enters is deformed as the
    /// rest shape would be, up to this where both are moved rigidly'.
    std::optional<double> deforms_what_enters{};
    /// A point outside, and whether bind() refuses it.
    std::optional<Vector3> outside{};
    bool refuses_outside = false;
    std::function<std::shared_ptr<SpaceMethod>()> other{}; ///< around another control, or with other options
};

inline void PrintTo(const SpaceTraits& traits, std::ostream* out) { *out << traits.name; }

/// What every space method does. A method takes part by one line in its own test:
///
///     INSTANTIATE_TEST_SUITE_P(Green, SpaceContract, testing::Values(traits()));
class SpaceContract : public testing::TestWithParam<SpaceTraits>
{
protected:
    const SpaceTraits& traits() const { return GetParam(); }
};

} // namespace sinew

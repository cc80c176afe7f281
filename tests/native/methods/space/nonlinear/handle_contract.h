// SPDX-License-Identifier: GPL-3.0-or-later
#pragma once

#include "native/methods/space/nonlinear/handles/handle_method.h"
#include "tests/native/shapes.h"

#include <gtest/gtest.h>

#include <functional>
#include <memory>
#include <ostream>
#include <string>
#include <vector>

namespace sinew {

/// What a method with an energy, moved by handles, is to do.
struct HandleTraits
{
    std::string name;
    /// With a few nodes or cells.
    std::function<std::shared_ptr<HandleMethod>(const SurfaceMesh&, const HandlePoints&)> make;
    /// Constructors of which each has one option out of range.
    std::vector<std::function<void()>> out_of_range{};

    struct Answer
    {
        Points unknowns;
        SolveReport report;
    };
    enum class Start { usual, other };
    std::function<Answer(const HandleMethod&, const Poses&, Start, double tolerance, int max_iterations)>
        answer;
    /// How far the answers from two starts are apart at most, on a bar of length 24.
    double meet = 1e-3;
    /// A control at one point turns the end of the bar around it by at least these degrees of 90.
    double turns_alone = 70.0;
};

inline void PrintTo(const HandleTraits& traits, std::ostream* out) { *out << traits.name; }

/// What every such method does, besides what SpaceContract asks for:
///
///     INSTANTIATE_TEST_SUITE_P(RigidCells, HandleContract, testing::Values(handle_traits()));
class HandleContract : public testing::TestWithParam<HandleTraits>
{
protected:
    const HandleTraits& traits() const { return GetParam(); }
    /// Bound to a shape whose ends along x are the handles.
    std::shared_ptr<HandleMethod> bound(const SurfaceMesh& mesh) const;
};

} // namespace sinew

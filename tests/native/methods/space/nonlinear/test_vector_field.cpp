// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/methods/space/nonlinear/vector_field.h"

#include "tests/native/methods/space/contract.h"

#include <gtest/gtest.h>

namespace sinew::test_vector_field {

namespace {

/// A frame of a tool as its four points.
Points frame(const Vector3& move = Vector3::Zero())
{
    Points axes(4, 3);
    axes << 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1;
    return axes.rowwise() + move.transpose();
}

SpaceTraits traits()
{
    // Two tools: a drag of three frames, then a bend or a twist of one.
    Points rest(16, 3);
    rest << frame().replicate(3, 1), frame({0.2, 0.1, -0.3});
    const auto variant = [rest](const char* name, const VectorFieldOptions& options) {
        return SpaceVariant{name, [=] { return std::make_shared<VectorField>(rest, options); }};
    };
    const auto second = [](FieldTool kind) {
        return VectorFieldOptions{.counts = {3, 1},
                                  .tools = {FieldTool::drag, kind},
                                  .inner = {0.3, 0.1},
                                  .outer = {0.9, 1.5},
                                  .width = {0.5}};
    };
    VectorFieldOptions stepped = second(FieldTool::drag);
    stepped.order = 2;
    stepped.steps = 7;
    return {.name = "VectorField",
            .variants = {variant("bend", second(FieldTool::bend)), variant("twist", second(FieldTool::twist)),
                         variant("stepped", stepped)},
            .control = rest,
            .points = shapes::Random(4).points(600, 1.6),
            .translation = {}, // of what is in reach alone
            // The end of an axis of length 1 turns points that are up to 3 away, and what a bend squeezes on
            // its inner side moves aside faster than that.
            .follow = 12.0,
            .other = [=] { return std::make_shared<VectorField>(rest, second(FieldTool::drag)); }};
}

} // namespace

// What it does to points is in tests/bindings/spaces/test_vector_fields.py.
INSTANTIATE_TEST_SUITE_P(VectorField, SpaceContract, testing::Values(traits()));

} // namespace sinew::test_vector_field

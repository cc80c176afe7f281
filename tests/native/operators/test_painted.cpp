// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/operators/painted.h"

#include "tests/native/refusals.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>
#include <vector>

namespace sinew::test_painted {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();

std::vector<int> refused(const std::vector<double>& values)
{
    const auto error = refusal<InvalidOption>([&] { painted(values, 3, 0.0, "rigidity"); });
    EXPECT_NE(std::string(error.what()).find("rigidity"), std::string::npos);
    return error.elements();
}

} // namespace

TEST(Painted, gives_one_value_per_vertex)
{
    EXPECT_EQ(painted({2.5}, 3, 0.1, "rigidity"), std::vector<double>(3, 2.5));
    EXPECT_EQ(painted({1.0, 2.0, 3.0}, 3, 0.1, "rigidity"), (std::vector<double>{1.0, 2.0, 3.0}));
}

TEST(Painted, raises_what_is_painted_black)
{
    EXPECT_EQ(painted({0.0, 1.0, 4.0}, 3, 0.5, "rigidity"), (std::vector<double>{2.0, 2.0, 4.0}));
}

TEST(Painted, is_empty_where_all_is_zero)
{
    EXPECT_TRUE(painted({0.0}, 3, 0.1, "rigidity").empty());
    EXPECT_TRUE(painted({0.0, 0.0, 0.0}, 3, 0.1, "rigidity").empty());
}

TEST(Painted, refuses_what_is_no_stiffness_and_names_the_vertices)
{
    refused({});
    refused({1.0, 2.0});
    EXPECT_TRUE(refused({-1.0}).empty());
    EXPECT_TRUE(refused({infinite}).empty());
    EXPECT_EQ(refused({1.0, -1.0, infinite}), (std::vector<int>{1, 2}));
}

} // namespace sinew::test_painted

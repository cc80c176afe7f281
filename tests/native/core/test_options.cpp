// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/options.h"

#include "native/core/types.h"
#include "tests/native/refusals.h"

#include <limits>

namespace sinew::test_options {

struct Settings
{
    int sweeps = 4;
    double share = 0.5;
    double tolerance = 1e-4;
    RowMatrix map{};

    static constexpr auto table()
    {
        return std::tuple{option("sweeps", &Settings::sweeps, Rebind::update, between(0, 8), "how often"),
                          option("share", &Settings::share, Rebind::anew, from_to_below(0, 1), "how far"),
                          stopping_tolerance(&Settings::tolerance),
                          option("map", &Settings::map, Rebind::anew, "where")};
    }
};

TEST(Options, a_number_outside_its_range_is_refused_by_name)
{
    require_valid(Settings{});
    for (const Settings& wrong :
         {Settings{.sweeps = 9}, Settings{.sweeps = -1}, Settings{.share = 1.0}, Settings{.tolerance = -1e-9},
          Settings{.share = std::numeric_limits<double>::quiet_NaN()},
          Settings{.tolerance = std::numeric_limits<double>::infinity()}})
        EXPECT_THROW(require_valid(wrong), InvalidOption);
    const auto error = refusal<InvalidOption>([] { require_valid(Settings{.share = 1.5}); });
    EXPECT_STREQ(error.what(), "share: 1.5 is not a finite number in [0, 1)");
}

TEST(Options, a_range_says_itself_in_words)
{
    EXPECT_EQ(at_least(0).words(true), ">= 0");
    EXPECT_EQ(more_than(0).words(false), "> 0");
    EXPECT_EQ(between(1, 8).words(true), "1 to 8");
    EXPECT_EQ(between(0, 1).words(false), "in [0, 1]");
    EXPECT_EQ(any_number().words(false), "");
}

TEST(Options, those_that_a_bind_reads_are_compared)
{
    const double none = std::numeric_limits<double>::quiet_NaN();
    const RowMatrix map = RowMatrix::Constant(2, 2, none);
    const Settings first{.map = map};
    EXPECT_TRUE(changed(first, {.tolerance = 1.0, .map = map}).empty());
    EXPECT_EQ(changed(first, {.sweeps = 5}, {"mesh"}), (std::vector<std::string>{"mesh", "sweeps", "map"}));
    EXPECT_TRUE(is_updated<Settings>("sweeps"));
    EXPECT_FALSE(is_updated<Settings>("share"));
    EXPECT_FALSE(is_updated<Settings>("tolerance"));
    EXPECT_FALSE(is_updated<Settings>("mesh"));
}

} // namespace sinew::test_options

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/progress.h"

#include "tests/native/refusals.h"

#include <string>

namespace sinew::test_progress {

TEST(Progress, without_a_callback_never_cancels) { EXPECT_NO_THROW(Progress().tick(0.5, "anything")); }

TEST(Progress, hands_share_and_stage_to_the_callback)
{
    double seen = 0.0;
    std::string stage;
    const Progress progress([&](double fraction, const char* name) {
        seen = fraction;
        stage = name;
        return true;
    });
    progress.tick(0.25, "factorising");
    EXPECT_EQ(seen, 0.25);
    EXPECT_EQ(stage, "factorising");
}

TEST(Progress, a_false_answer_cancels_and_names_the_stage)
{
    const Progress progress([](double, const char*) { return false; });
    const auto error = refusal<Cancelled>([&] { progress.tick(0.5, "factorising"); });
    EXPECT_NE(std::string(error.what()).find("factorising"), std::string::npos);
}

} // namespace sinew::test_progress

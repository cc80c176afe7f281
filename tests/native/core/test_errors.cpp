// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/errors.h"

#include <gtest/gtest.h>

namespace sinew::test_errors {

// Their elements are seen in tests/bindings/test_errors.py.
TEST(Errors, list_only_some_of_many)
{
    EXPECT_EQ(list_some({}), "");
    EXPECT_EQ(list_some({4}), "4");
    EXPECT_EQ(list_some({4, 5, 6}, 3), "4, 5, 6");
    EXPECT_EQ(list_some({4, 5, 6, 7, 8}, 3), "4, 5, 6 and 2 more");
}

} // namespace sinew::test_errors

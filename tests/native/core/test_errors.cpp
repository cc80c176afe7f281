// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/errors.h"

#include "tests/native/refusals.h"

namespace sinew::test_errors {

TEST(Errors, carry_the_elements_at_fault)
{
    const auto error = refusal<Error>([] { throw InvalidMesh("bad", Error::Element::face, {3, 1}); });
    EXPECT_STREQ(error.what(), "bad");
    expect_elements(error, Error::Element::face, {3, 1});
}

TEST(Errors, name_no_element_unless_told)
{
    const InvalidOption error("bad");
    EXPECT_EQ(error.element_kind(), Error::Element::none);
    EXPECT_TRUE(error.elements().empty());
}

TEST(Errors, list_only_some_of_many)
{
    EXPECT_EQ(list_some({}), "");
    EXPECT_EQ(list_some({4}), "4");
    EXPECT_EQ(list_some({4, 5, 6}, 3), "4, 5, 6");
    EXPECT_EQ(list_some({4, 5, 6, 7, 8}, 3), "4, 5, 6 and 2 more");
}

} // namespace sinew::test_errors

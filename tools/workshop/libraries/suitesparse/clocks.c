// SPDX-License-Identifier: GPL-3.0-or-later
// METIS's clocks without getrusage. They are read only for what it prints, which nobody asks for.
#include <time.h>

double gk_CPUSeconds(void)
{
    return (double)clock() / CLOCKS_PER_SEC;
}

double gk_WClockSeconds(void)
{
    return gk_CPUSeconds();
}

// SPDX-License-Identifier: GPL-3.0-or-later
// rand() and srand() with the numbers that Linux's C library gives, an additive generator of lag 31, for METIS: so it
// finds the ordering that it finds there, and Arap's factors in single precision are rounded alike. Those of Windows
// have 15 bits, too few to shuffle a mesh of more than 32,768 vertices. Each thread has numbers of its own.
#include <stdint.h>

enum { LAG = 31, NEAR = 3, SKIPPED = 310 };

static __thread uint32_t last[LAG];
static __thread int place, is_seeded;

static uint32_t next(void)
{
    const uint32_t sum = last[place] += last[(place + LAG - NEAR) % LAG];
    place = (place + 1) % LAG;
    return sum;
}

void sinew_srand(unsigned seed)
{
    int64_t word = (int32_t)(seed ? seed : 1);
    for (int i = 0; i < LAG; ++i) {
        last[i] = (uint32_t)word;
        word = 16807 * word % 2147483647;
        if (word < 0)
            word += 2147483647;
    }
    place = NEAR;
    is_seeded = 1;
    for (int i = 0; i < SKIPPED; ++i)
        next();
}

int sinew_rand(void)
{
    if (!is_seeded)
        sinew_srand(1);
    return (int)(next() >> 1);
}

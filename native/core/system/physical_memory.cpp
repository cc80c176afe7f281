// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/core/system/physical_memory.h"

#ifdef _WIN32
#ifndef NOMINMAX
#define NOMINMAX
#endif
#include <windows.h>
#elif defined(__APPLE__)
#include <cstddef>
#include <sys/sysctl.h>
#else
#include <algorithm>
#include <fstream>
#include <unistd.h>
#endif

namespace sinew {

std::int64_t physical_memory()
{
#ifdef _WIN32
    MEMORYSTATUSEX status{};
    status.dwLength = sizeof status;
    return GlobalMemoryStatusEx(&status) ? static_cast<std::int64_t>(status.ullTotalPhys) : 0;
#elif defined(__APPLE__)
    std::int64_t bytes = 0;
    std::size_t size = sizeof bytes;
    return sysctlbyname("hw.memsize", &bytes, &size, nullptr, 0) == 0 ? bytes : 0;
#else
    const auto bytes =
        std::max<std::int64_t>(std::int64_t{sysconf(_SC_PHYS_PAGES)} * sysconf(_SC_PAGESIZE), 0);
    std::int64_t most = 0; // where a container has no limit, the file has a word
    return std::ifstream("/sys/fs/cgroup/memory.max") >> most ? std::min(bytes, most) : bytes;
#endif
}

} // namespace sinew

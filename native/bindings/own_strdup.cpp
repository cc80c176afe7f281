// SPDX-License-Identifier: GPL-3.0-or-later
#if defined(__linux__)

#include <cstdlib>
#include <cstring>

// pybind11 frees what strdup() gave. The module is loaded with RTLD_DEEPBIND into a host that may
// replace malloc (Blender does): libc's strdup then allocates by the host's malloc, while our free
// is libc's. This one keeps both ends with the same allocator. The same holds for any other libc
// function that allocates for its caller: none may be used in native/.
extern "C" char* strdup(const char* text)
{
    const std::size_t size = std::strlen(text) + 1;
    void* copy = std::malloc(size);
    return copy ? static_cast<char*>(std::memcpy(copy, text, size)) : nullptr;
}

#endif

// SPDX-License-Identifier: GPL-3.0-or-later
// What Python calls first, compiled for every processor: one that cannot run the rest gets a message.
// It includes no header of ours, as the linker could take an inline function from another file for it.
#include <Python.h>

#ifdef SINEW_NEEDS_SSE42
#include <cpuid.h>
#endif

// NOLINTBEGIN(readability-identifier-naming): Python's names
extern "C" PyObject* PyInit_sinew_native_bound(); // module.cpp

PyMODINIT_FUNC PyInit_sinew_native()
{
#ifdef SINEW_NEEDS_SSE42
    unsigned a = 0, b = 0, c = 0, d = 0;
    if (!__get_cpuid(1, &a, &b, &c, &d) || !(c & bit_SSE4_2)) {
        PyErr_SetString(PyExc_ImportError, "the processor of this computer lacks SSE4.2, which Sinew needs");
        return nullptr;
    }
#endif
    return PyInit_sinew_native_bound();
}

// NOLINTEND(readability-identifier-naming)

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/method_binding.h"

namespace sinew::bindings {
void bind_core(py::module_& module);
void bind_mesh(py::module_& module);
void bind_operators(py::module_& module);
void bind_solvers(py::module_& module);
void bind_systems(py::module_& module);
void bind_surface(py::module_& module);
void bind_affine_basis(py::module_& module);
void bind_space(py::module_& module);
void bind_cage(py::module_& module);
void bind_handle_methods(py::module_& module);
void bind_subdivision(py::module_& module);
void bind_automatic_cage(py::module_& module);
void bind_one_call(py::module_& module);
} // namespace sinew::bindings

PYBIND11_MODULE(sinew_native_bound, module) // entry.cpp calls it
{
    module.doc() = "Shape deformation: NumPy in, NumPy out. Points are (n, 3) float64, angles radians, "
                   "Laplacians positive semi-definite and weak.";
    module.attr("__version__") = SINEW_VERSION;
    using namespace sinew::bindings;
    bind_core(module);
    bind_mesh(module);
    bind_operators(module);
    bind_solvers(module);
    bind_surface(module);
    bind_systems(module);
    bind_space(module);
    bind_cage(module);
    bind_handle_methods(module);
    bind_subdivision(module);
    bind_automatic_cage(module);
    MethodBinding::bind_all(module);
    bind_affine_basis(module);
    bind_one_call(module);
}

// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/surface.h"
#include "native/methods/multiresolution/multiresolution.h"

#include <utility>
#include <vector>

namespace sinew::bindings {

namespace {

void bind_multiresolution(py::module_& module)
{
    SurfaceClass<Multiresolution> method(
        module, "Multiresolution",
        R"(Multiresolution deformation [Kobbelt et al. 1998, Botsch et al. 2008], tutorial section 4.4.

Another method moves a smooth base of the surface, and the details are put back on it: they turn with the base where it
bends or twists, also if that method turns none itself, as the thin shell. set_handles() binds the base method and costs
one factorisation more per band; a frame is one of the base method, mostly for an incoming shape, and the details.
Handles and open borders have no details, so handles are met exactly.)");
    define_constructor(
        method,
        +[](const MultiresolutionOptions& options, const SurfaceMesh& mesh,
            const std::shared_ptr<SurfaceMethod>& base) {
            const py::gil_scoped_release unlocked;
            return std::make_shared<Multiresolution>(mesh, base, options);
        },
        {{"mesh", "SurfaceMesh, the rest shape"},
         {"base", "SurfaceMethod on the same mesh, which moves the smooth shape; it belongs to this object "
                  "from now on"}},
        "Raises InvalidOption for a base on another mesh, or for an option out of its range.",
        py::arg("mesh"), py::arg("base").none(false), py::kw_only());
    method.def(
        "levels",
        [](const Multiresolution& method) {
            std::vector<Points> levels;
            {
                const py::gil_scoped_release unlocked;
                levels = method.levels();
            }
            py::list found;
            for (Points& level : levels)
                found.append(to_numpy(std::move(level)));
            return found;
        },
        "[(n, 3)] the rest shape and what each band left of it, bands + 1 shapes; the rest shape alone "
        "before\n"
        "set_handles().");
}

const MethodBinding multiresolution_binding(&bind_multiresolution);

} // namespace

} // namespace sinew::bindings

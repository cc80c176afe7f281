// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/methods/space/cage/harmonic.h"

namespace sinew::bindings {

namespace {

void bind_harmonic(py::module_& module)
{
    bind_cage_method<Harmonic, HarmonicOptions>(
        module, "Harmonic",
        R"(Harmonic coordinates [Joshi et al. 2007], section 5.4, by boundary elements or on a lattice.

The weights are not negative, sum to 1, have linear precision and no maximum inside. For up to 600 triangles, the
first bind() solves for the boundary of the cage; for more, each bind() solves on a lattice inside. With boundary
elements, bind() also raises InvalidMesh for faces without area and for faces that touch one another.)")
        .def_property_readonly(
            "unknowns", &read<&Harmonic::unknowns, Harmonic>,
            "After bind(): the unknowns of the flux on the boundary, or the nodes of the lattice.")
        .def_property_readonly(
            "residual_rms", &read<&Harmonic::residual_rms, Harmonic>,
            "After bind(): the root mean square difference between the weights and the data on the cage; 0 "
            "with a lattice.")
        .def_property_readonly(
            "residual_max", &read<&Harmonic::residual_max, Harmonic>,
            "After bind(): the largest of these differences. They are measured at some points "
            "of the cage; apart from that, no error inside is larger.");
}

const MethodBinding harmonic_binding(&bind_harmonic);

} // namespace

} // namespace sinew::bindings

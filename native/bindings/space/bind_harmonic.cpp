// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/methods/space/cage/harmonic.h"

namespace sinew::bindings {

namespace {

HarmonicOptions harmonic_options(const PointWeightOptions& weights, const std::string& quality,
                                 const std::string& outside, const std::string& solver)
{
    return {weights,
            choose<HarmonicQuality>(quality, "quality",
                                    {{"fast", HarmonicQuality::fast},
                                     {"medium", HarmonicQuality::medium},
                                     {"fine", HarmonicQuality::fine},
                                     {"finest", HarmonicQuality::finest}}),
            cage_outside(outside),
            choose<HarmonicSolver>(solver, "solver",
                                   {{"auto", HarmonicSolver::automatic},
                                    {"boundary", HarmonicSolver::boundary},
                                    {"lattice", HarmonicSolver::lattice}})};
}

void bind_harmonic(py::module_& module)
{
    bind_cage_method<Harmonic>(
        module, "Harmonic",
        R"(Harmonic coordinates [Joshi et al. 2007], section 5.4, by boundary elements or on a lattice.

The weights are not negative, sum to 1, have linear precision and no maximum inside. For up to 600 triangles, the
first bind() solves for the boundary of the cage; for more, each bind() solves on a lattice inside. With boundary
elements, bind() also raises InvalidMesh for faces without area and for faces that touch one another.)",
        &harmonic_options,
        R"(quality     'fast', 'medium', 'fine' or 'finest': at most 1000, 2000, 4100 or 12000 unknowns on the cage,
            with time proportional to their cube and memory to their square; or 96, 160, 256 or 384 steps
            of the lattice along the cage's longest side.
outside     points outside: 'error' names them, 'mean_value' gives them mean value weights.
solver      'boundary' elements or a 'lattice'; 'auto' takes the lattice for more than 600 triangles.
)",
        py::arg("quality") = "medium", py::arg("outside") = "error", py::arg("solver") = "auto")
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

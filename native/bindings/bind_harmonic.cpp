// SPDX-License-Identifier: GPL-3.0-or-later
#include "native/bindings/cage.h"
#include "native/space/cage/harmonic.h"

namespace sinew::bindings {

namespace {

HarmonicOptions options(const PointWeightOptions& weights, const std::string& quality,
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
        R"(Harmonic coordinates [Joshi et al. 2007], section 5.4, by boundary elements or on a cut lattice.

Non-negative, sum 1, linear precision, no maximum inside. Up to 600 triangles, the first bind() solves the
cage's boundary; with more, each bind() solves a lattice inside. With boundary elements, bind() also raises
InvalidMesh for faces without area and faces that touch one another.)",
        &options,
        R"(quality     'fast', 'medium', 'fine' or 'finest': at most 1000, 2000, 4100 or 12000 unknowns on the cage,
            whose cube is the time and whose square the memory; or 96, 160, 256 or 384 steps of the
            lattice along the cage's longest side.
outside     points outside: 'error' names them, 'mean_value' gives them mean value weights.
solver      'boundary' elements or a 'lattice'; 'auto' takes the lattice beyond 600 triangles.
)",
        py::arg("quality") = "medium", py::arg("outside") = "error", py::arg("solver") = "auto")
        .def_property_readonly("unknowns", &Harmonic::unknowns,
                               "Unknowns of the boundary's flux or nodes of the lattice, once bound.")
        .def_property_readonly(
            "residual_rms", &Harmonic::residual_rms,
            "Root mean square gap of the weights to the data on the cage, once bound; 0 on a "
            "lattice.")
        .def_property_readonly("residual_max", &Harmonic::residual_max,
                               "The largest one, a bound of the error anywhere but for its sampling.");
}

const MethodBinding binding(&bind_harmonic);

} // namespace

} // namespace sinew::bindings

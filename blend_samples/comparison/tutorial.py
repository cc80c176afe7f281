# SPDX-License-Identifier: GPL-3.0-or-later
"""The figures and tables of the tutorial, one row each: what each of them shows here, and what makes its picture.

The page docs/methods/tutorial.md has the sentences, and the tests that each row names assert them.
"""

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

from . import figures as f
from .cases import plane

REST = {"At rest": f.at_rest}
SHELL = {"Thin Shell": f.by("thin_shell")}
ARAP = {"As-Rigid-As-Possible": f.by("arap")}
GRADIENTS = {"Gradient Editing": f.by("gradient_editing")}
details = partial(f.around, wavelength=20.0)


@dataclass(frozen=True)
class Row:
    """A figure or a table: the section that it stands in, what is seen of it here, the test that asserts this, and
    what draws it. A row without ``draw`` is the picture of a sample; one without either is not yet rebuilt."""

    name: str
    section: str
    shows: str
    test: str = ""
    draw: f.Draw | None = None
    sample: str = ""

    @property
    def picture(self) -> str:
        """The name of its picture, or nothing."""
        return self.sample or (f"tutorial-{int(self.name.split()[1]):02}" if self.draw else "")


def solvers(name: str) -> Row:
    """What waits for the choice between solvers."""
    return Row(name, "A", f"{name} is not yet rebuilt, as it compares solvers that Sinew does not have yet.")


ROWS = (
    Row(
        "Figure 1",
        "2.2",
        "Each step splits the faces of a control mesh into four, and takes it nearer to a smooth limit.",
        "test_each_step_of_subdivision_has_four_times_the_faces_and_is_nearer_to_the_limit",
        f.subdivided,
    ),
    Row(
        "Figure 2",
        "2.3",
        "Four times as many faces take a quarter of the error, of places and of principal curvatures.",
        "test_four_times_the_faces_have_a_quarter_of_the_error",
        f.spheres,
    ),
    Row(
        "Figure 3",
        "2.3",
        "The diagnosis marks the vertex or the edge where sheets meet that are more than one surface.",
        "test_the_diagnosis_names_what_is_not_manifold",
        f.not_manifold,
    ),
    Row(
        "Figure 4",
        "3.2",
        "The weight of an edge is half the sum of the cotangents of two angles, and the mass of a vertex is its area.",
        "test_weights_and_masses_are_those_of_the_drawn_angles_and_areas",
        f.ring_of_a_vertex,
    ),
    Row(
        "Figure 5",
        "3.2",
        "On uneven faces, only the cotangents with areas give the smooth bend whose mean curvature changes evenly.",
        "test_the_cotangent_laplacian_with_areas_sees_the_surface_and_not_its_faces",
        f.edits(
            f.uneven_strip,
            {"Irregular faces": f.with_edges}
            | {"Uniform": f.in_curvature("uniform")}
            | {"Cotangent": f.in_curvature("cotan")}
            | {"Cotangent + Area": f.in_curvature("cotan_voronoi")},
        ),
    ),
    Row(
        "Figure 6",
        "4.1",
        "A grid of splines is creased with degree 1, and smoother but less round than the thin shell with degree 3.",
        "test_splines_of_degree_one_are_creased_and_smoother_ones_less_round_than_the_thin_shell",
        f.edits(
            f.lifted_disc,
            {"Spline Surface, degree 1": f.by("spline_surface", degree=1)}
            | {"Spline Surface, 8 x 8": f.by("spline_surface")}
            | {"Spline Surface, 20 x 20": f.by("spline_surface", columns=20, rows=20)}
            | SHELL,
        ),
    ),
    Row(
        "Figure 7",
        "4.2",
        "A field that is 1 on the handle and 0 at the frame damps the tilt of the handle.",
        "test_the_field_is_one_on_the_handle_and_damps_its_move",
        f.propagated,
    ),
    Row(
        "Figure 8",
        "4.2",
        "Inside a lifted ring, the field by distances dents the sheet, and the thin shell does not.",
        "test_propagation_by_distance_dents_the_inside_of_a_handle",
        f.edits(
            partial(f.lifted_disc, hollow=True),
            REST
            | {"Propagation, geodesic": f.by("propagation", field="geodesic")}
            | {"Propagation, harmonic": f.by("propagation")}
            | SHELL,
        ),
    ),
    Row(
        "Figure 9",
        "4.3",
        "Stretching alone gives a tent with a crease at the handle, bending alone a round hill, and both something between.",
        "test_stretching_makes_a_tent_and_bending_a_hill",
        sample="plate",
    ),
    Row(
        "Figure 10",
        "4.4",
        "The thin shell shears the bumps of a lifted plane, normal displacements turn them, and a nonlinear method strains it least.",
        "test_only_what_turns_details_keeps_bumps_upright",
        f.edits(plane, REST | SHELL | {"and normal displacements": f.around("normal_displacements")} | ARAP),
    ),
    Row(
        "Figure 11",
        "4.4",
        "The wave of the outline is taken off a bar, the smooth bar is bent, and the wave comes back on it.",
        "test_two_bands_come_apart_and_together_again",
        f.in_two_bands(f.bellows, 14.0),
    ),
    Row(
        "Figure 12",
        "4.4",
        "Decomposition, editing and reconstruction, one by one: what an artist sees is the first and the last.",
        "test_two_bands_come_apart_and_together_again",
        f.in_two_bands(f.bent_bumps, 20.0),
    ),
    Row(
        "Figure 13",
        "4.4.1",
        "Bumps that are stored in global coordinates lean over in a bend, and stand upright in local frames.",
        "test_details_in_global_coordinates_lean_over",
        f.edits(
            f.bent_bumps,
            REST
            | {"In global coordinates": f.by("thin_shell")}
            | {"In local frames": f.around("displacement_vectors")}
            | ARAP,
        ),
    ),
    Row(
        "Figure 14",
        "4.4.3",
        "In a tight bend, normal displacements press high bumps together, volumes and transfer keep them apart.",
        "test_volumes_and_transfer_keep_bumps_apart",
        f.edits(
            partial(f.bent_bumps, 0.12, 140.0),
            REST
            | {"Normal displacements": details("normal_displacements")}
            | {"Displacement volumes": details("displacement_volumes")}
            | {"Deformation transfer": details("deformation_transfer")},
        ),
    ),
    Row(
        "Figure 15",
        "4.5.1",
        "Gradients that nobody turns squash the cylinder, turned triangles come apart, and one Poisson system joins them.",
        "test_one_system_joins_the_turned_triangles",
        f.edits(f.arc, REST | {"Gradients at rest": f.gradients_at_rest, "Turned triangles": f.torn} | GRADIENTS),
    ),
    Row(
        "Figure 16",
        "4.5.3",
        "When the head of an animal is lifted far, linear methods turn its body too little or too much.",
        "test_a_handle_that_moves_far_turns_too_little_or_too_much",
        f.edits(
            f.beast,
            SHELL
            | GRADIENTS
            | {"Laplacian, implicit": f.by("laplacian_editing", transforms="implicit")}
            | ARAP
            | {"Nonlinear Thin Shell": f.by("thin_shell_nonlinear")},
        ),
    ),
    Row(
        "Figure 17",
        "4.6",
        "Each linear method fails at a translation, a bend, a twist or a pull, and the nonlinear one at none.",
        "test_nonlinear_methods_are_below_implicit_laplacian_editing",
        sample="gallery",
    ),
    Row(
        "Figure 18",
        "5",
        "One lattice warps the space in which a ship of meshes, curves, text and hair stands, and the ship with it.",
        "test_one_lattice_moves_all_that_stands_in_it",
        sample="longship",
    ),
    Row(
        "Figure 19",
        "5.1",
        "The rows of a lattice show as steps in a ridge that lies across them, also with more and finer rows.",
        "test_the_rows_of_a_lattice_show_in_a_ridge_across_them",
        sample="ffd",
    ),
    Row(
        "Figure 20",
        "5.3",
        "The boiler of a locomotive of thousands of loose parts is stretched, and the wheels that handles hold stay round.",
        "test_wheels_that_handles_hold_stay_round",
        sample="machine",
    ),
    Row(
        "Figure 21",
        "5.4",
        "A cow follows a coarse cage around it by mean value coordinates, and by three other kinds.",
        "test_a_cow_follows_its_coarse_cage",
        sample="coordinates",
    ),
    Row(
        "Figure 22",
        "6",
        "As rigid as possible, a bumpy plane bends by 170 degrees with its bumps as they were.",
        "test_bumps_stay_as_they_are_in_a_large_bend",
        f.bent_further,
    ),
    *map(solvers, ("Figure 23", "Figure 24", "Table 1", "Table 2")),
)

# SPDX-License-Identifier: GPL-3.0-or-later
"""What the documents say of methods is what rows and headers say."""

import re
import struct
from pathlib import Path
from types import SimpleNamespace

import pytest
from workshop import describe_methods
from workshop.places import ROOT

HEADER = """/// Moves points.
///
///   call     repeat it when ...   cost
///   solve()  the handles moved    O(n)
class Base
{
};
"""

# The methods and operators of the tutorial, there or planned. What Sinew has beyond them needs no line here.
TUTORIAL = (
    "affine_basis arap conjugate_gradients curvature deformation_transfer degenerate_removal "
    "dense_solvers displacement_vectors displacement_volumes embedded_deformation factor_updates ffd "
    "geodesic_distance gradient gradient_editing green handle_aware_isolines harmonic "
    "hierarchical_smoothing incomplete_factors inverse_ffd isotropic_remeshing laplacian_cotan "
    "laplacian_cotan_voronoi laplacian_editing laplacian_uniform mean_value mesh_diagnosis "
    "mesh_puppetry mesh_sequence mls multigrid multiresolution multiresolution_space "
    "normal_displacements orderings positive_mean_value primo propagation pyramid_coordinates rbf "
    "rigid_cells rotation_invariant_coordinates semi_regular_remeshing silhouette_sketch "
    "space_propagation sparse_cholesky sparse_lu spline_surface subdivision subdivision_editing "
    "subdivision_warp subspace_laplacian thin_shell thin_shell_nonlinear vector_field "
    "volumetric_graph_laplacian wires"
)


def test_every_page_says_what_rows_and_headers_say() -> None:
    pages = [page.relative_to(ROOT).as_posix() for page in describe_methods.outdated(ROOT)]
    assert not pages, f"run tools/describe_methods, out of date: {pages}"


def test_every_method_of_the_tutorial_is_listed_once() -> None:
    found = describe_methods.entries(ROOT)
    ids = [entry.id for entry in found]
    assert len(ids) == len(set(ids))
    assert set(ids) >= set(TUTORIAL.split())
    there = {entry.id for entry in found if entry.link.startswith(describe_methods.PAGES)}
    tools = {"silhouette_sketch", "subdivision_warp"}  # no deformers: they have a page, and no row
    assert there == {row.id for row in describe_methods.registry(ROOT).METHODS} | tools
    assert all((ROOT / entry.link).is_file() for entry in found if entry.link)


SEVEN = {
    "picture": r"!\[.+\]\(\.\./manual/images/",
    "parameters": r"\| parameter \| default \| unit \| what it does \|\n\|-.*\n\| \w",
    "cost": r"What a call costs:\n\n```text\n\w|## Cost\n\n\w",
    "failure": r"\| fails \| \w.+\. \|",
    "paper": r"\| paper \| \w.+\d{4}.* \|",
    "program": r"```python\n(.+\n){8,12}```",
    "links to source and test": r"\| library \| \[native/.*\|\n(\|.*\n)*\| tests \| \[tests/",
}


def test_every_page_has_the_seven_parts_and_words_of_its_own() -> None:
    links = {entry.link for entry in describe_methods.entries(ROOT)}
    for page in sorted(link for link in links if link.startswith(describe_methods.PAGES)):
        text = (ROOT / page).read_text(encoding="utf-8")
        for part, pattern in SEVEN.items():
            assert re.search(rf"^({pattern})", text, flags=re.MULTILINE), f"{page} has no {part}"
        own = text.split(describe_methods.END)[-1]  # what it is good and bad at, at least
        assert len(own) > 400, page


def test_the_listing_counts_the_methods_and_has_the_sizes_that_platforms_want() -> None:
    listing = ROOT / "docs/listing"
    count = len(describe_methods.registry(ROOT).METHODS)
    assert f"**{count} methods**" in (listing / "README.md").read_text()
    for name, size in {"icon": (256, 256), "feature": (1920, 1080)}.items():
        assert struct.unpack(">2I", (listing / f"{name}.png").read_bytes()[16:24]) == size


def test_a_page_keeps_its_own_words(tmp_path: Path) -> None:
    page = tmp_path / "page.md"
    page.write_text(f"Before\n{describe_methods.BEGIN}\nold\n{describe_methods.END}\nAfter\n")
    text = describe_methods._with(page, "new")
    assert text == f"Before\n{describe_methods.BEGIN}\nnew\n{describe_methods.END}\nAfter\n"
    page.write_text("No marks\n")
    with pytest.raises(SystemExit, match="has no marks"):
        describe_methods._with(page, "new")


def test_a_class_costs_what_its_base_costs(tmp_path: Path) -> None:
    home = tmp_path / "native"
    home.mkdir()
    (home / "base.h").write_text(HEADER)
    derived = home / "derived.h"
    derived.write_text("class Derived : public Base\n{\n};\n")
    table = ["call     repeat it when ...   cost", "solve()  the handles moved    O(n)"]
    assert describe_methods._costs(tmp_path, derived, "Derived") == table
    derived.write_text("class Derived\n{\n};\n")
    with pytest.raises(SystemExit, match="no cost table"):
        describe_methods._costs(tmp_path, derived, "Derived")


@pytest.mark.parametrize(("default", "words"), [(True, "on"), (False, "off"), (0.5, "0.5"), (40, "40")])
def test_a_default_is_written_as_an_artist_reads_it(default: object, words: str) -> None:
    assert describe_methods._default(SimpleNamespace(default=default)) == words

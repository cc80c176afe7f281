# SPDX-License-Identifier: GPL-3.0-or-later
"""What artists want to do, and the methods that do it. Panels, menus and the manual follow these rows."""

from dataclasses import KW_ONLY, dataclass

from .methods import BY_ID, Method
from .names import is_numbered
from .traits import Trait, first

_MOST = 3  # tasks that are suggested


@dataclass(frozen=True)
class Task:
    """Something that an artist wants to do.

    ``deformer``: what a deformer that was made for it is called. ``purpose``: what it is for. ``methods``:
    their ids, the recommended one first; none if nothing stays behind. ``other_names``: what other programs
    call it, which finds the recommended method. ``suits``: what it is suggested for, that which it suits best
    first. ``page``: the page of the manual. ``icon``: Blender's icon in menus. ``picture``: the sample, and
    after a colon which part of it, that shows the task; empty where that is the one of its recommended
    method. ``stands_behind``: its deformer corrects what other modifiers do, and goes behind them.
    """

    id: str
    label: str
    deformer: str
    purpose: str
    _: KW_ONLY
    methods: tuple[str, ...] = ()
    other_names: tuple[str, ...] = ()
    suits: tuple[Trait, ...] = ()
    page: str
    icon: str
    picture: str = ""
    stands_behind: bool = False

    @property
    def recommended(self) -> Method | None:
        """The method that a deformer of this task starts with."""
        return BY_ID[self.methods[0]] if self.methods else None

    @property
    def shown_as(self) -> str:
        """The name of its picture: its own, or that of its recommended method."""
        return self.id if self.picture else self.methods[0]

    @property
    def more(self) -> tuple[Method, ...]:
        """The other methods that are chosen by themselves, and not put around another one by a switch."""
        return tuple(BY_ID[method] for method in self.methods[1:] if not BY_ID[method].wraps)


TASKS = (
    Task(
        "limb",
        "Bend a Limb",
        "Limb",
        "arms, legs, tails, necks",
        methods=(
            "arap",
            "subspace_laplacian",
            "laplacian_editing",
            "gradient_editing",
            "rotation_invariant_coordinates",
            "handle_aware_isolines",
            "hierarchical_smoothing",
            "volumetric_graph_laplacian",
            "multiresolution",
        ),
        other_names=("Cluster", "Bulge", "Muscle"),
        page="bend-a-limb",
        icon="MOD_SIMPLEDEFORM",
    ),
    Task(
        "joint",
        "Correct a Joint",
        "Joint",
        "an elbow that bones have bent",
        methods=("arap",),
        other_names=("Corrective Shape", "Delta Mush"),
        suits=(Trait.MOVED,),
        page="correct-an-elbow",
        icon="BONE_DATA",
        picture="elbow",
        stands_behind=True,
    ),
    Task(
        "sheet",
        "Shape a Sheet",
        "Sheet",
        "flags, leaves, skirts",
        methods=(
            "thin_shell",
            "primo",
            "thin_shell_nonlinear",
            "spline_surface",
            "propagation",
            "subdivision_editing",
        ),
        suits=(Trait.SHEET,),
        page="shape-a-sheet",
        icon="MOD_CLOTH",
    ),
    Task(
        "box",
        "Put in a Box",
        "Box",
        "everything, several objects",
        methods=("ffd",),
        other_names=("Squash and Stretch", "FFD Box"),
        suits=(Trait.SURFACE, Trait.POINTS),
        page="put-in-a-box",
        icon="LATTICE_DATA",
    ),
    Task(
        "cage",
        "Wrap in a Cage",
        "Cage",
        "characters, props",
        methods=("mean_value", "positive_mean_value", "harmonic", "green"),
        other_names=("Wrap Deformer", "Mesh Deform"),
        suits=(Trait.SURFACE, Trait.BONES),
        page="wrap-in-a-cage",
        icon="MESH_ICOSPHERE",
    ),
    Task(
        "parts",
        "Move Loose Parts",
        "Parts",
        "text, hair, scans, props of parts",
        methods=(
            "mls",
            "rbf",
            "embedded_deformation",
            "rigid_cells",
            "space_propagation",
            "inverse_ffd",
            "multiresolution_space",
        ),
        other_names=("Proportional Drag", "Soft Selection", "Puppet Pin"),
        suits=(Trait.POINTS, Trait.LOOSE),
        page="move-loose-parts",
        icon="STICKY_UVS_DISABLE",
    ),
    Task(
        "lines",
        "Lift Brows, Folds",
        "Brows",
        "brows, lips, cloth folds",
        methods=("wires",),
        page="brows-and-folds",
        icon="CURVE_DATA",
    ),
    Task(
        "clay",
        "Push like Clay",
        "Clay",
        "push, twist, bend, volume stays",
        methods=("vector_field",),
        other_names=("Soft Modification", "Taper"),
        page="push-like-clay",
        icon="SCULPTMODE_HLT",
    ),
    Task(
        "figure",
        "Pose by Bones",
        "Figure",
        "a figure and its skin",
        methods=("mesh_puppetry",),
        other_names=("Skin Weights",),
        suits=(Trait.BONES,),
        page="pose-by-bones",
        icon="ARMATURE_DATA",
    ),
    Task(
        "animation",
        "Edit an Animation",
        "Animation",
        "a shot, a cache",
        methods=("mesh_sequence",),
        other_names=("Jiggle",),
        suits=(Trait.CACHED,),
        page="edit-an-animation",
        icon="RENDER_ANIMATION",
    ),
    Task(
        "morph",
        "Morph to a Mesh",
        "Morph",
        "between two twins",
        methods=("pyramid_coordinates",),
        other_names=("Blend Shape",),
        suits=(Trait.TWIN,),
        page="morph-and-copy",
        icon="MOD_DATA_TRANSFER",
    ),
    Task(
        "once",
        "Shape It Once",
        "",
        "no modifier",
        page="shape-it-once",
        icon="VIEW_PAN",
        picture="silhouette",
    ),
)
TASK_BY_ID: dict[str, Task] = {task.id: task for task in TASKS}


def task_of(method: Method) -> Task:
    """The task that a method is for; for a method of several tasks the first one."""
    return next(task for task in TASKS if method.id in task.methods)


def task_for(method: Method, name: str) -> Task:
    """The task of a deformer with this method and this name: the one that it was made for, if that shows."""
    fitting = (task for task in TASKS if method.id in task.methods and is_numbered(name, (task.deformer,)))
    return next(fitting, task_of(method))


def suggested(there: frozenset[Trait]) -> tuple[Task, ...]:
    """At most three tasks for what is selected, first those for what is special about it."""
    fitting = [(first(task.suits, there), task) for task in TASKS]
    best = sorted([(rank, task) for rank, task in fitting if rank is not None], key=lambda pair: pair[0])
    return tuple(task for _rank, task in best[:_MOST])


def found(wanted: str) -> tuple[tuple[Task, Method | None], ...]:
    """The methods in whose words all wanted words occur, each once, with the first task that leads to it.

    First come those that have the words as whole words of their own, of these the recommended ones. A task
    without a method stands for itself.
    """
    words = wanted.lower().split()
    hits: dict[str, tuple[tuple[bool, bool], Task, Method | None]] = {}
    for task in TASKS:
        for place, method in enumerate([BY_ID[name] for name in task.methods] or [None]):
            own = f"{method.label} {method.known_as} {method.search}" if method else ""
            others = " ".join(task.other_names) if place == 0 else ""
            text = f"{task.label} {task.purpose} {own} {others}".lower()
            if all(word in text for word in words):
                is_own = set(words) <= set(own.lower().split())
                key = method.id if method else task.id
                hits.setdefault(key, ((not is_own, place > 0), task, method))
    return tuple((task, method) for _rank, task, method in sorted(hits.values(), key=lambda hit: hit[0]))

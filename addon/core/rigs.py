# SPDX-License-Identifier: GPL-3.0-or-later
"""The rigs of *Try It*: which models they are, what is set up on them, and the steps that the panel shows."""

from collections.abc import Mapping
from dataclasses import KW_ONLY, dataclass, field
from enum import Enum, auto

from .labels import label_of
from .methods import BY_ID


class Done(Enum):
    """What is seen when an artist has done a step."""

    STARTED = auto()  # there is a deformer
    POSED = auto()  # a control is not at rest
    AT_REST = auto()  # all controls are
    METHOD = auto()  # the deformer has another method than the rig began with
    FRAME = auto()  # the frame is not the last one, in which the rig opens
    RADIUS = auto()  # a wire reaches farther than any did
    PINNED = auto()  # a bone is pinned


@dataclass(frozen=True)
class Step:
    """What the panel asks for, and what is seen when it is done. ``method``: what ``{}`` in the text names.
    ``more``: the number that has to be passed.
    """

    text: str
    done: Done
    method: str = ""
    more: float = 0.0

    @property
    def shown(self) -> str:
        """The text, with the name of the method as Sinew shows it."""
        return self.text.format(label_of(BY_ID[self.method])) if self.method else self.text


@dataclass(frozen=True)
class Rig:
    """A model in a file of the add-on, ``rigs/<id>.blend``, which is a task of that id where there is one.

    ``objects``: their names there, that which is moved first. ``setup``: the operators that run on it when it
    opens, with their arguments; names of objects become those that they have in the file of the artist.
    ``posing``: the armature that is active then, in Pose Mode. ``drags``: whether Sinew Drag is taken up.
    ``view``: from where it is seen: degrees from above, and around it; ``room``: how much of the viewport is
    seen, in sizes of the model. ``coloured``: regions are shown.
    """

    id: str
    label: str
    purpose: str
    _: KW_ONLY
    icon: str
    objects: tuple[str, ...]
    steps: tuple[Step, ...]
    setup: tuple[tuple[str, Mapping[str, object]], ...] = field(default=(), hash=False)
    posing: str = ""
    drags: bool = True
    view: tuple[float, float] = (12.0, 20.0)
    room: float = 1.25
    coloured: bool = False


_RESET = Step("Press Reset Pose", Done.AT_REST)

RIGS = (
    Rig(
        "limb",
        "Bend a Limb",
        "Open a pillar with a handle at its tip, and bend it",
        icon="MOD_SIMPLEDEFORM",
        objects=("Pillar",),
        setup=(
            ("handle_add", {"kind": "HANDLE", "vertex_group": "Tip"}),
            ("handle_add", {"kind": "FIXED", "vertex_group": "Foot"}),
        ),
        steps=(
            Step("Press on the orange tip and drag", Done.POSED),
            Step("Press the name of the method and choose {}", Done.METHOD, "subspace_laplacian"),
            _RESET,
        ),
        coloured=True,
    ),
    Rig(
        "joint",
        "Correct an Elbow",
        "Open an arm that its bones have bent, and correct the elbow",
        icon="BONE_DATA",
        objects=("Yeti Arm", "Yeti Arm Rig"),
        steps=(
            Step("Press Correct a Joint", Done.STARTED),
            Step("Press on the elbow and pull it out", Done.POSED),
            Step("Go to another frame: it rides along", Done.FRAME),
        ),
        drags=False,
        room=1.9,
    ),
    Rig(
        "lines",
        "A Face with Wires",
        "Open a face that curves along brows and mouth move",
        icon="CURVE_DATA",
        objects=("Yeti Head", "Brow.L", "Brow.R", "Mouth"),
        setup=(
            ("wire_add", {"curve": "Mouth", "radius": 0.15}),
            ("wire_add", {"curve": "Brow.L", "radius": 0.13}),
            ("wire_add", {"curve": "Brow.R", "radius": 0.13}),
        ),
        steps=(
            Step("Press on a brow and drag it up", Done.POSED),
            Step("Make Radius larger: more of the face follows", Done.RADIUS, more=0.16),
            _RESET,
        ),
        view=(6.0, 0.0),
    ),
    Rig(
        "cage",
        "A Cow in a Cage",
        "Open a cow that a coarse cage around it moves",
        icon="MESH_ICOSPHERE",
        objects=("Cow", "Cow Cage"),
        setup=(("cage_add", {"method": "mean_value", "source": "OBJECT", "cage": "Cow Cage"}),),
        steps=(
            Step("Press on the head and drag: a point of the cage moves", Done.POSED),
            Step("Press the name of the method and choose {}", Done.METHOD, "green"),
            _RESET,
        ),
    ),
    Rig(
        "figure",
        "Drag a Figure",
        "Open a mannequin, and pose it by its bones",
        icon="ARMATURE_DATA",
        objects=("Mannequin Skin", "Mannequin Rig"),
        setup=(("puppet_rig", {"armature": "Mannequin Rig", "automatic": True}),),
        steps=(
            Step("Press on a hand and drag", Done.POSED),
            Step("Click a foot: now it is pinned", Done.PINNED),
            _RESET,
        ),
        posing="Mannequin Rig",
        view=(8.0, 12.0),
    ),
)
RIG_BY_ID = {rig.id: rig for rig in RIGS}


def rig_after(rig: Rig) -> Rig | None:
    """The next rig, if there is one."""
    place = RIGS.index(rig) + 1
    return RIGS[place] if place < len(RIGS) else None

# SPDX-License-Identifier: GPL-3.0-or-later
"""Space methods that tools on a path control."""

from .schema import Choice, Control, Family, Float, Int, Method, Moved, Reproduced

TOOLS = (
    ("drag", "Drag", "A ball moves and turns with the tool, and what is around it gives way"),
    ("twist", "Twist", "What lies above the tool turns about the tool's Z axis"),
    ("bend", "Bend", "What lies above the tool turns about axes across the tool's Z axis"),
)

ROWS = (
    Method(
        id="vector_field",
        number=47,
        label="Clay",
        known_as="Vector Fields",
        search="clay smudge grab push twist bend taper",
        family=Family.SPACE_NONLINEAR,
        control=Control.TOOLS,
        native="VectorField",
        section="7",
        paper="Angelidis et al. 2006, von Funck et al. 2006",
        summary="Pushes, twists and bends like clay; the volume stays",
        fails="Lets wide sheets flow around what pushes them",
        picture="vector_field: bend",
        main=("inner", "outer"),
        moves=frozenset(Moved),
        reproduces=Reproduced.RIGID_MOTIONS,
        bind_seconds=lambda points, size, _options: 5e-7 * points + 1e-9 * points * size,
        parameters=(
            Float(
                "tolerance",
                1e-5,
                minimum=1e-9,
                maximum=0.1,
                soft_maximum=0.01,
                precision=6,
                step=1e-5,
                rebinds=True,
                advanced=True,
                unit="share of Outer",
                label="Tolerance",
                description="Set how exactly the flow is followed on each piece of the path of a tool",
            ),
            Int(
                "steps",
                0,
                maximum=4096,
                soft_maximum=200,
                rebinds=True,
                advanced=True,
                unit="steps per piece of a path",
                label="Steps",
                description="Set how many steps each piece of a path takes; 0 takes as many as each point "
                "needs",
            ),
        ),
        control_parameters=(
            Choice(
                "tools",
                "drag",
                TOOLS,
                rebinds=True,
                label="Tool",
                description="Choose what the tool does to the space around it",
            ),
            Float(
                "inner",
                0.25,
                minimum=-1e9,
                unit="length",
                rebinds=True,
                label="Inner",
                description="Move all within this distance of a drag with it, or keep what is below this "
                "height of a twist or bend",
            ),
            Float(
                "outer",
                1.0,
                minimum=1e-6,
                unit="length",
                rebinds=True,
                label="Outer",
                description="Keep what is beyond this distance of a drag, or turn all above this height of "
                "a twist or bend",
            ),
            Float(
                "width",
                1.0,
                minimum=1e-6,
                unit="length",
                rebinds=True,
                label="Width",
                description="Turn all within this distance of the Z axis of a twist or bend, and nothing "
                "from twice the distance on",
            ),
            Float(
                "progress",
                1.0,
                maximum=1.0,
                soft_maximum=1.0,
                label="Progress",
                description="Key how far the tool has gone on its path, from where it rests to where it is "
                "now",
            ),
        ),
    ),
)

# SPDX-License-Identifier: GPL-3.0-or-later
"""Space methods that tools on a path control."""

from .schema import Choice, Control, Family, Float, Int, Method, Moved, Reproduced, Span, items

TOOLS = items(
    drag="A ball moves and turns with the tool, and what is around it gives way",
    twist="What lies above the tool turns about the tool's Z axis",
    bend="What lies above the tool turns about axes across the tool's Z axis",
)

ROWS = (
    Method(
        id="vector_field",
        number=47,
        label="Clay",
        known_as="Vector Fields",
        search="clay smudge grab push twist bend taper",
        family=Family.SPACE_NONLINEAR,
        section="7",
        paper="Angelidis et al. 2006, von Funck et al. 2006",
        summary="Pushes, twists and bends like clay; the volume stays",
        fails="Lets wide sheets flow around what pushes them",
        picture="vector_field: bend",
        control=Control.TOOLS,
        moves=frozenset(Moved),
        reproduces=Reproduced.RIGID_MOTIONS,
        bind_seconds=lambda points, size, _options: 5e-7 * points + 1e-9 * points * size,
        main=("inner", "outer"),
        parameters=(
            Float(
                "tolerance",
                "Tolerance",
                1e-5,
                Span(1e-9, 0.1, soft=0.01, digits=6, step=1e-5),
                advanced=True,
                unit="share of Outer",
            ).described("Set how exactly the flow is followed on each piece of the path of a tool"),
            Int(
                "steps", "Steps", 0, Span(0, 4096, soft=200), advanced=True, unit="steps per piece of a path"
            ).described("Set how many steps each piece of a path takes; 0 takes as many as each point needs"),
        ),
        control_parameters=(
            Choice("tools", "Tool", "drag", TOOLS).described(
                "Choose what the tool does to the space around it"
            ),
            Float("inner", "Inner", 0.25, Span(-1e9), unit="length").described(
                "Move all within this distance of a drag with it, or keep what is below this "
                "height of a twist or bend"
            ),
            Float("outer", "Outer", 1.0, Span(1e-6), unit="length").described(
                "Keep what is beyond this distance of a drag, or turn all above this height of "
                "a twist or bend"
            ),
            Float("width", "Width", 1.0, Span(1e-6), unit="length").described(
                "Turn all within this distance of the Z axis of a twist or bend, and nothing "
                "from twice the distance on"
            ),
            Float("progress", "Progress", 1.0, Span(0.0, 1.0, soft=1.0), rebinds=False).described(
                "Key how far the tool has gone on its path, from where it rests to where it is now"
            ),
        ),
    ),
)

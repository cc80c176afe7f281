# SPDX-License-Identifier: GPL-3.0-or-later
"""Models in one pose of a cage, which different coordinates follow in different ways."""

from collections.abc import Callable, Iterable, Mapping, Sequence

import bmesh
import bpy
import numpy as np

from .. import markers, posing
from ..lineup import POSE_FRAME, Lineup
from ..materials import plain_material
from ..models.objects import grid_faces, mesh_object
from ..studio import Shot

KINDS = {"Mean Value": "mean_value", "Green": "green"}
PAINT = {  # of the fish
    "Body": (0.85, 0.30, 0.06),
    "Fin": (0.55, 0.10, 0.03),
    "White": (0.85, 0.85, 0.82),
    "Pupil": (0.02, 0.02, 0.03),
    "Dot": (0.95, 0.72, 0.25),
}
MIDDLE, LAYER = 1.05, 0.012  # its height, and how far apart its layers are
# Of the lighthouse
SEGMENTS = 16
WALL, STRIPE, STONE, GLASS, DARK = range(5)  # material slots
HEIGHT = 2.3

# from the ground up: radius, height, how sharp the rim is, material of the ring of faces above
PROFILE = (
    (0.52, 0.00, 1.0, STONE),
    (0.52, 0.10, 0.9, STONE),
    (0.42, 0.12, 0.9, WALL),
    (0.395, 0.34, 0.0, WALL),
    (0.375, 0.50, 0.0, STRIPE),
    (0.355, 0.66, 0.0, STRIPE),
    (0.335, 0.82, 0.0, WALL),
    (0.315, 0.98, 0.0, WALL),
    (0.298, 1.14, 0.0, STRIPE),
    (0.283, 1.30, 0.0, STRIPE),
    (0.270, 1.46, 0.0, WALL),
    (0.262, 1.58, 0.9, STONE),
    (0.385, 1.62, 0.9, STONE),
    (0.385, 1.69, 0.9, STONE),
    (0.215, 1.70, 0.9, GLASS),
    (0.215, 1.98, 0.9, STRIPE),
    (0.300, 1.99, 0.9, STRIPE),
    (0.200, 2.12, 0.0, STRIPE),
    (0.075, 2.20, 0.6, STONE),
    (0.060, 2.26, 0.0, STONE),
)
WINDOWS = ((4, 11), (7, 12), (9, 11))  # ring of faces, segment
DOOR = (2, 13)
# Of the tower's cage by floor: height, half the width, how far it leans
STOREYS = ((-0.04, 0.60, 0.0), (0.58, 0.52, 0.10), (1.14, 0.47, 0.42), (1.70, 0.47, 0.86), (2.30, 0.47, 1.22))
RINGS = (0.06, 1.0, 1.94)  # heights in the cage of quads
SQUEEZED = ((1.0, 1.0, 0.0), (0.45, 1.0, 0.0), (1.9, 1.0, -0.15))  # by ring: width, depth, lift


def share_pose(
    rest: bpy.types.Object,
    methods: Iterable[tuple[bpy.types.Object, str]],
    posed: Callable[[np.ndarray], np.ndarray],
    values: Mapping[int, float],
    thickness: float,
) -> None:
    """Pose objects, each by a method, by copies of a cage in one pose; the cage itself stays at rest.
    ``posed`` turns its points (c, 3) into those of the pose; ``values`` is its strength per frame."""
    objects = list(methods)
    cages = [posing.share_cage(rest, obj, method) for obj, method in objects]
    rest.data = rest.data.copy()  # the others share their mesh, and its poses
    posing.add_pose(cages[0], "Pose", posed(posing.vertices(rest)), values)
    for cage in (rest, *cages):
        markers.add_cage_edges(cage, thickness)
    rest.hide_render = True
    for obj, _method in objects:
        posing.check_posed(obj)


def stack_of_boxes(floors: Iterable[tuple[float, float]], parent: bpy.types.Object) -> bpy.types.Object:
    """A cage of boxes, one on the other: of each floor its height and half its width."""
    corners = ((-1, -1), (1, -1), (1, 1), (-1, 1))
    points = [(x * half, y * half, z) for z, half in floors for x, y in corners]
    sides = grid_faces(len(points) // 4, 4, around=True).tolist()
    return mesh_object("Boxes", points, [(3, 2, 1, 0), tuple(range(len(points)))[-4:], *sides], parent)


def lighthouse(name: str = "Lighthouse") -> bpy.types.Object:
    """Of few faces, from a lathe: a Subdivision makes it smooth, creases keep its rims sharp."""
    angle = 2 * np.pi * np.arange(SEGMENTS) / SEGMENTS
    ring = np.stack((np.cos(angle), np.sin(angle)), 1)
    rows = [np.column_stack((radius * ring, np.full(SEGMENTS, z))) for radius, z, *_ in PROFILE]
    points = np.vstack((*rows, [(0, 0, 0), (0, 0, HEIGHT)]))
    bottom, top = len(points) - 2, len(points) - 1
    faces, slots, sharp = [], [], {}
    for k, (_, _, sharpness, slot) in enumerate(PROFILE):
        for s in range(SEGMENTS):
            here, beside = k * SEGMENTS + s, k * SEGMENTS + (s + 1) % SEGMENTS
            sharp[min(here, beside), max(here, beside)] = sharpness
            last = k + 1 == len(PROFILE)
            faces.append((here, beside, top) if last else (here, beside, beside + SEGMENTS, here + SEGMENTS))
            opening = (k, s) in WINDOWS or (k, s) == DOOR
            slots.append(DARK if opening else slot)
    faces += [((s + 1) % SEGMENTS, s, bottom) for s in range(SEGMENTS)]
    slots += [STONE] * SEGMENTS

    surfaces = [
        plain_material("Wall", (0.80, 0.77, 0.71), roughness=0.6),
        plain_material("Stripe", (0.42, 0.035, 0.025), roughness=0.5),
        plain_material("Stone", (0.27, 0.25, 0.23), roughness=0.7),
        plain_material("Glass", (0.85, 0.62, 0.20), roughness=0.1, specular=0.6),
        plain_material("Opening", (0.02, 0.022, 0.03), roughness=0.3),
    ]
    obj = mesh_object(name, points, faces, smooth=True, slots=slots, materials=surfaces)
    for edge in obj.data.edges:
        edge.crease = sharp.get(tuple(sorted(edge.vertices)), 0.0)
    return obj


def lean(towers: Sequence[bpy.types.Object]) -> None:
    for tower in towers:
        posing.subdivide(tower, 3, 3)
    rest = stack_of_boxes([storey[:2] for storey in STOREYS], towers[0])
    aside = np.outer(np.repeat([storey[2] for storey in STOREYS], 4), (1.0, 0.0, 0.0))
    sway = {1: 0.0, POSE_FRAME: 1.0, 52: 1.0, 72: -0.8, 96: 0.0}
    share_pose(rest, zip(towers[1:], KINDS.values()), lambda points: points + aside, sway, 0.014)


def block() -> bpy.types.Object:
    """A chequered block, symmetric about x = 0."""
    mesh, edit = bpy.data.meshes.new("Block"), bmesh.new()
    bmesh.ops.create_cube(edit, size=1.0)
    bmesh.ops.subdivide_edges(edit, edges=edit.edges[:], cuts=23, use_grid_fill=True)
    for face in edit.faces:
        x, y, z = np.floor((np.array(face.calc_center_median()) + 0.5) * 6 - 1e-4)
        face.material_index = int(abs(x - 2.5) + y + z) % 2
    bmesh.ops.scale(edit, vec=(1.0, 1.0, 1.8), verts=edit.verts)
    bmesh.ops.translate(edit, vec=(0.0, 0.0, 1.0), verts=edit.verts)
    edit.to_mesh(mesh)
    edit.free()
    mesh.materials.append(plain_material("Light", (0.78, 0.72, 0.62)))
    mesh.materials.append(plain_material("Dark", (0.10, 0.17, 0.26)))
    return posing.add_object("Block", mesh)


def squeeze(blocks: Sequence[bpy.types.Object]) -> None:
    rest = stack_of_boxes([(z, 0.56) for z in RINGS], blocks[0])
    width, depth, lift = np.repeat(SQUEEZED, 4, axis=0).T

    def posed(points: np.ndarray) -> np.ndarray:
        return points * np.column_stack((width, depth, np.ones_like(lift))) + np.outer(lift, (0, 0, 1))

    values = {1: 0.0, POSE_FRAME: 1.0, 60: 1.0, 84: 0.0}
    share_pose(rest, [(block, "green") for block in blocks[1:]], posed, values, 0.016)
    for block, faces in zip(blocks[1:], ("triangles", "quads")):
        block.sinew.deformers[-1].parameters.faces = faces
        posing.operate(block, "bind")
        posing.check_posed(block)
        print(f"> {faces}: {asymmetry(block):.4f} of the width from its mirror image", flush=True)


def asymmetry(obj: bpy.types.Object) -> float:
    """How far the posed block is from its own mirror image, as a share of its width at rest."""
    shapes = []
    for frame in (1, POSE_FRAME):
        bpy.context.scene.frame_set(frame)
        shapes.append(posing.shape(obj).astype(np.float64))
    rest, posed = shapes
    keys = {tuple(np.round(point, 4)): index for index, point in enumerate(rest)}
    image = [keys[tuple(np.round(point * (-1, 1, 1), 4) + 0.0)] for point in rest]
    return float(np.linalg.norm(posed[image] * (-1, 1, 1) - posed, axis=1).max() / np.ptp(rest[:, 0]))


def arch(blocks: Sequence[bpy.types.Object]) -> None:
    """Bend the second and third by four boxes, in steps: the third by their smooth surface."""
    heights = np.linspace(0.0, 2.0, 5)
    rest = stack_of_boxes([(height, 0.56) for height in heights], blocks[0])

    def bent(points: np.ndarray) -> np.ndarray:
        turn = np.radians(20.0) * np.repeat(np.arange(5.0), 4)
        bones = (heights[1] - heights[0]) * np.column_stack((np.sin(turn), np.cos(turn)))
        ends = np.cumsum(bones[::4], axis=0) - bones[0] + (0.0, heights[0])
        across = np.column_stack((np.cos(turn), -np.sin(turn)))
        posed = points.copy()
        posed[:, (0, 2)] = np.repeat(ends, 4, axis=0) + points[:, :1] * across
        return posed

    values = {1: 0.0, POSE_FRAME: 1.0, 60: 1.0, 84: 0.0}
    share_pose(rest, [(block, "mean_value") for block in blocks[1:]], bent, values, 0.016)
    blocks[2].sinew.deformers[-1].parameters.smooth = "automatic"
    posing.operate(blocks[2], "bind")
    posing.check_posed(blocks[2])


def fish() -> bpy.types.Object:
    """A drawing of layers, one a little before the other; each shape is one face of many corners."""
    s = np.linspace(0.0, 1.0, 40)
    back = np.column_stack((-1.0 + 1.5 * s, 0.5 * np.sin(np.pi * s) ** 0.8))
    tail = np.array([(0.5, 0.0), (0.7, 0.16), (1.0, 0.45), (0.92, 0.15), (0.9, 0.0)])
    angle = 2 * np.pi * np.arange(48) / 48
    circle = np.column_stack((np.cos(angle), np.sin(angle)))
    dots = [(x, y) for x in (-0.4, -0.15, 0.1) for y in (-0.2, 0.0, 0.2)] + [(0.32, 0.0)]
    shapes = [  # the outline, its paint, its layer
        (np.concatenate((tail, tail[-2:0:-1] * (1, -1))), 1, 0),
        (np.concatenate((back, back[-2:0:-1] * (1, -1))), 0, 1),
        (0.1 * circle + (-0.68, 0.09), 2, 2),
        (0.05 * circle + (-0.7, 0.09), 3, 3),
        *((0.075 * circle + dot, 4, 2) for dot in dots),
    ]
    points = [(x, -LAYER * layer, y + MIDDLE) for line, _paint, layer in shapes for x, y in line]
    corners = iter(range(len(points)))
    faces = [tuple(next(corners) for _ in line) for line, _paint, _layer in shapes]
    surfaces = [plain_material(name, colour, roughness=0.7) for name, colour in PAINT.items()]
    return mesh_object("Fish", points, faces, slots=[shape[1] for shape in shapes], materials=surfaces)


def bend(fish: Sequence[bpy.types.Object]) -> None:
    """In a rectangle as one face, with corners along its sides, which becomes an arc of the same height."""
    x = np.linspace(-1.12, 1.12, 7)
    around = [(a, 0.0, z + MIDDLE) for z, side in ((-0.6, x), (0.6, x[::-1])) for a in side]
    outline = mesh_object("Outline", around, [tuple(range(len(around)))], parent=fish[0])

    def bent(points: np.ndarray) -> np.ndarray:
        radius = 1.15
        angle, arm = points[:, 0] / radius, radius + MIDDLE - points[:, 2]
        return np.column_stack((arm * np.sin(angle), points[:, 1], 0.72 + radius - arm * np.cos(angle)))

    values = {1: 0.0, POSE_FRAME: 1.0, 60: -0.6, 84: 0.0}
    share_pose(outline, zip(fish[1:], KINDS.values()), bent, values, 0.02)
    for obj, method in zip(fish[1:], KINDS.values()):
        print(f"> {method}: dots are {ovalness(obj):.3f} times as long as wide", flush=True)


def ovalness(obj: bpy.types.Object) -> float:
    """The greatest ratio of the two axes of a dot."""
    bpy.context.scene.frame_set(POSE_FRAME)
    posed = posing.shape(obj).astype(np.float64)
    dots = [posed[list(face.vertices)][:, [0, 2]] for face in obj.data.polygons if face.material_index == 4]
    lengths = [np.linalg.svd(dot - dot.mean(0), compute_uv=False) for dot in dots]
    return float(max(longer / shorter for longer, shorter in lengths))


LINEUPS = {
    "lighthouse": Lineup(
        about="A subdivided lighthouse in a leaning cage: mean values shear it, Green turns its parts.",
        build=lighthouse,
        row=dict.fromkeys(("Rest", *KINDS)),
        spacing=2.1,
        finish=lean,
        shot=Shot((0.35, 0.0, 1.06), 7.2, 9.0, 26.0, lit=1.0, picture=(1440, 560), text=0.19, front=-1.5),
    ),
    "quad_cages": Lineup(
        about="A symmetric pose of a cage of quads: two triangles per quad lean to one side, quads do not.",
        build=block,
        row=dict.fromkeys(("Rest", "Triangles", "Quads")),
        spacing=2.9,
        finish=squeeze,
        shot=Shot((0, 0, 0.92), 9.2, 7.0, 26.0, 1.0, picture=(1440, 460), samples=24, text=0.21, front=-1.6),
    ),
    "smooth_cages": Lineup(
        about="Four boxes bend a block: in steps by their faces, evenly by their smooth surface.",
        build=block,
        row=dict.fromkeys(("Rest", "Off", "Smooth")),
        spacing=3.1,
        finish=arch,
        shot=Shot(
            (0.4, 0, 0.95), 9.6, 7.0, 26.0, 1.0, picture=(1440, 460), samples=16, text=0.21, front=-1.6
        ),
    ),
    "flat_art": Lineup(
        about="Flat art in a flat cage: with mean_value its dots become oval, with green they stay round.",
        build=fish,
        row=dict.fromkeys(("Rest", *KINDS)),
        spacing=3.1,
        finish=bend,
        shot=Shot((0.0, 0.0, 1.05), 9.8, 5.0, 26.0, lit=1.0, picture=(1440, 400), samples=24, text=0.2),
    ),
}

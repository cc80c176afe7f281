# SPDX-License-Identifier: GPL-3.0-or-later
"""How the object that controls a deformer rests: its place, its own points, and the values of its shape keys.

The rest mesh of a control is what its modifiers make of it, which does not tell these. So it keeps them
beside its vertices, and Reset Pose puts them back.
"""

from collections.abc import Iterator

import numpy as np
from bpy.types import ID, Mesh, Object, ShapeKey, bpy_prop_collection
from idprop.types import IDPropertyGroup

from ...core.errors import SinewError
from ...ids import Keys
from ...properties import deformers_of

_PLACE, _POINTS, _VALUES = "place", "points", "values"
# Elements, what of them is edited, and how many numbers each of these has.
_Numbers = tuple[bpy_prop_collection, tuple[str, ...], int]


def note(mesh: Mesh, control: Object) -> None:
    """Let a new rest mesh, in the frame of the control, keep how the control is now."""
    mesh[Keys.REST_POSE] = {
        _PLACE: np.eye(4).ravel().tolist(),
        _POINTS: read(control).tobytes(),
        _VALUES: {key.name: key.value for key in keys_of(control)},
    }


def move(mesh: Mesh, by: np.ndarray) -> None:
    """The rest mesh was moved by a map (4, 4), and the place goes with it."""
    kept = _kept(mesh)
    if kept is not None:
        mesh[Keys.REST_POSE] = {**kept, _PLACE: (by @ _matrix(kept)).ravel().tolist()}


def carry_over(held: Mesh, made: Mesh) -> None:
    """Let another rest mesh of the same control keep the same."""
    kept = _kept(held)
    if kept is not None:
        made[Keys.REST_POSE] = kept


def place_of(mesh: Mesh) -> np.ndarray | None:
    """Where the control rests, (4, 4) in the frame of its rest mesh; None in files of earlier builds."""
    kept = _kept(mesh)
    return None if kept is None else _matrix(kept)


def put_back(control: Object, mesh: Mesh) -> None:
    """Give a control the points and the values of shape keys that its rest mesh keeps, if they still fit."""
    kept = _kept(mesh)
    if kept is None:
        return
    for key in keys_of(control):
        key.value = kept[_VALUES].get(key.name, 0.0)
    put_points(control, np.frombuffer(kept[_POINTS], dtype=np.float32))


def _kept(mesh: Mesh | None) -> dict | None:
    """What the rest mesh keeps; None if there is nothing, or nothing that Sinew would write."""
    found = None if mesh is None else mesh.get(Keys.REST_POSE)
    if not isinstance(found, IDPropertyGroup):
        return None
    kept = found.to_dict()
    place, points, values = (kept.get(name) for name in (_PLACE, _POINTS, _VALUES))
    is_whole = isinstance(place, list) and len(place) == 16 and isinstance(points, bytes)
    is_whole = is_whole and len(points) % 4 == 0 and isinstance(values, dict)
    return kept if is_whole and all(isinstance(value, float) for value in values.values()) else None


def _matrix(kept: dict) -> np.ndarray:
    return np.array(kept[_PLACE], dtype=np.float64).reshape(4, 4)


def put_points(control: Object, points: np.ndarray) -> None:
    """Give a control these numbers for its points, float32 (n,), unless it has more or fewer of them."""
    now = read(control)
    if len(points) != len(now) or np.array_equal(points, now) or control.data.library is not None:
        return
    if control.mode == "EDIT":
        raise SinewError(f"{control.name} is in Edit Mode - leave it first")
    _write(control, points)


def is_edited(control: Object, mesh: Mesh | None) -> bool:
    """Whether the points of a control itself are others than its rest mesh keeps."""
    kept = _kept(mesh)
    return kept is not None and read(control).tobytes() != kept[_POINTS]


def keys_of(control: Object) -> Iterator[ShapeKey]:
    """The shape keys of a control that pose it, and not those that show deformers on it."""
    keys = getattr(control.data, "shape_keys", None)
    shown = {deformer.shape_key for deformer in deformers_of(control)}
    for key in () if keys is None else keys.key_blocks:
        if key != keys.reference_key and key.name not in shown:
            yield key


def read(control: Object) -> np.ndarray:
    """The numbers that edits of an object change, float32 (n,); none of one without points."""
    found = [np.zeros(0, dtype=np.float32)]
    for elements, names, size in _own(control):
        for name in names:
            values = np.empty(size * len(elements), dtype=np.float32)
            elements.foreach_get(name, values)
            found.append(values)
    return np.concatenate(found)


def points_of(control: Object) -> np.ndarray:
    """The points that edits of an object move, (n, 3) in its own frame; none of one without points."""
    return read(control)[_places(control)[:, :1] + np.arange(3)]


def with_point_moved(control: Object, values: np.ndarray, point: int, by: np.ndarray) -> np.ndarray:
    """The numbers of an object, as ``read`` gives them, after a map (4, 4) of a point and its handles."""
    found = values.copy()
    for first in _places(control)[point]:
        found[first : first + 3] = by[:3, :3] @ values[first : first + 3] + by[:3, 3]
    return found


def _places(control: Object) -> np.ndarray:
    """Where the coordinates of each point begin among the numbers, and those of its two handles, (n, 3).

    A point without handles is there three times.
    """
    found, first = [np.zeros((0, 3), dtype=np.intp)], 0
    for elements, names, size in _own(control):
        count = size * len(elements)
        starts = first + size * np.arange(len(elements))[:, None] + count * np.arange(len(names))
        found.append(np.pad(starts, ((0, 0), (0, 3 - len(names))), mode="edge"))
        first += count * len(names)
    return np.concatenate(found)


def _write(control: Object, values: np.ndarray) -> None:
    """Replace these numbers; with shape keys also those of the data, which Blender keeps like its Basis."""
    for numbers in (_own(control), list(_of_data(control.type, control.data))):
        first = 0
        for elements, names, size in numbers:
            for name in names:
                after = first + size * len(elements)
                elements.foreach_set(name, values[first:after])
                first = after
    control.data.update_tag()


def _own(control: Object) -> list[_Numbers]:
    """What holds the points of an object as the artist edits them. Those of curves with keys are not read."""
    keys = getattr(control.data, "shape_keys", None)
    if keys is None:
        return list(_of_data(control.type, control.data))
    return [] if control.type == "CURVE" else [(keys.reference_key.data, ("co",), 3)]


def _of_data(kind: str, data: ID | None) -> Iterator[_Numbers]:
    if kind == "MESH":
        yield data.vertices, ("co",), 3
    elif kind == "LATTICE":
        yield data.points, ("co_deform",), 3
    elif kind in ("CURVES", "POINTCLOUD") and "position" in data.attributes:
        yield data.attributes["position"].data, ("vector",), 3
    for spline in data.splines if kind == "CURVE" else ():
        yield spline.points, ("co",), 4
        yield spline.bezier_points, ("co", "handle_left", "handle_right"), 3

# SPDX-License-Identifier: GPL-3.0-or-later
"""F-curves of actions.

Blender 4.4 introduced slots; since 5.0 only the channel bags of layers hold the curves.
"""

from bpy.types import ID, Action, AnimData, FCurve


def action_curves(owner: ID) -> list[tuple[Action, FCurve]]:
    """The F-curves that animate a datablock, from its action and its NLA strips, each with its action."""
    animation = owner.animation_data
    if animation is None:
        return []
    users: list[AnimData] = [animation]
    users += [strip for track in animation.nla_tracks for strip in track.strips]
    found: dict[tuple[str, object], tuple[Action, object]] = {}
    for user in users:
        if user.action is not None:
            slot = getattr(user, "action_slot", None)
            found[user.action.name_full, getattr(slot, "handle", None)] = (user.action, slot)
    return [(action, curve) for action, slot in found.values() for curve in _curves(action, slot)]


def _curves(action: Action, slot: object) -> list[FCurve]:
    return [curve for bag in _bags(action, slot) for curve in bag.fcurves]


def _bags(action: Action, slot: object) -> list:
    """The objects that hold the F-curves: the action itself, or the channel bags of one slot."""
    if not hasattr(action, "layers"):
        return [action]
    if slot is None:
        return []
    bags = [strip.channelbag(slot) for layer in action.layers for strip in layer.strips]
    return [bag for bag in bags if bag is not None]


def remove_action_curve(action: Action, curve: FCurve) -> None:
    """Remove an F-curve from its action."""
    slots = getattr(action, "slots", None)
    for slot in (None,) if slots is None else slots:
        for bag in _bags(action, slot):
            if any(other == curve for other in bag.fcurves):
                bag.fcurves.remove(curve)
                return

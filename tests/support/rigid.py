"""A board, a recipe and a program moved together: turned about z and put elsewhere."""

from dataclasses import dataclass, replace

import numpy as np

from programs.program import Command, MoveTo, SetNozzle, Wait
from recipes.paths import StraightLine

_POSITION_MM = 5e-3
_AXIS = 1e-4
_TIME_S = 1e-3 + 1e-9


@dataclass(frozen=True)
class Motion:
    """A turn about z, degrees, and then a shift, mm."""

    turn_deg: float
    shift: tuple[float, float, float]

    @property
    def matrix(self):
        if self.turn_deg % 90 == 0:  # exactly, so that a written file loses nothing
            c, s = [(1, 0), (0, 1), (-1, 0), (0, -1)][int(self.turn_deg // 90) % 4]
        else:
            c, s = np.cos(np.radians(self.turn_deg)), np.sin(np.radians(self.turn_deg))
        return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])

    def points(self, points):
        """(..., 3) points."""
        return points @ self.matrix.T + np.array(self.shift)

    def place(self, place):
        """A point of the plan."""
        x, y, _ = self.points(np.array([*place, 0.0])).tolist()
        return (x, y)


def moved_bodies(bodies, motion):
    """The bodies of a board, moved."""
    return tuple(
        replace(
            body,
            patches=motion.points(body.patches),
            normals=body.normals @ motion.matrix.T,
            pads=tuple(moved_pad(pad, motion) for pad in body.pads),
        )
        for body in bodies
    )


def moved_pad(pad, motion):
    """A pad, moved."""
    x_mm, y_mm = motion.place((pad.x_mm, pad.y_mm))
    return replace(pad, x_mm=x_mm, y_mm=y_mm, turn_rad=pad.turn_rad + np.radians(motion.turn_deg))


def moved_recipe(recipe, motion):
    """A recipe whose absolute directions and places are moved."""
    limits = recipe.limits
    change = {}
    if limits.park_mm is not None:
        change["park_mm"] = motion.place(limits.park_mm)
    if limits.tool_azimuth_deg is not None:
        change["tool_azimuth_deg"] = limits.tool_azimuth_deg + motion.turn_deg
    templates = {name: moved_template(spec, motion) for name, spec in recipe.templates.items()}
    return recipe.model_copy(update={"templates": templates, "limits": limits.model_copy(update=change)})


def moved_template(spec, motion):
    """A template whose absolute direction and places are moved."""
    if isinstance(spec, StraightLine):
        ends = {"from_mm": motion.place(spec.from_mm), "to_mm": motion.place(spec.to_mm)}
        return spec.model_copy(update=ends)
    if isinstance(getattr(spec, "direction_deg", None), float | int):
        return spec.model_copy(update={"direction_deg": spec.direction_deg + motion.turn_deg})
    return spec


def differences(program, moved, motion, most=5):
    """Where a program of the moved board is not the moved program: the first few places, in words."""
    if len(program.instructions) != len(moved.instructions):
        found = [f"{len(program.instructions)} instructions become {len(moved.instructions)}"]
    else:
        found = []
    for number, (one, other) in enumerate(zip(program.instructions, moved.instructions, strict=False)):
        found += [f"{number}: {why}: {one} and {other}" for why in _unlike(one, other, motion)]
        if len(found) >= most:
            break
    return found


def _unlike(one, other, motion):
    if type(one) is not type(other) or one.made_by != other.made_by:
        yield "not the same"
        return
    if abs(one.time_s - other.time_s) > _TIME_S:
        yield "time"
    match one:
        case MoveTo():
            if np.abs(motion.points(np.array(one.position)) - other.position).max() > _POSITION_MM:
                yield "position"
            mine, theirs = _axes(one.quaternion), _axes(other.quaternion)
            if np.abs(motion.matrix @ mine - theirs).max() > _AXIS:
                yield "direction"
        case Wait():
            if abs(one.duration_s - other.duration_s) > _TIME_S:
                yield "length"
        case Command() | SetNozzle():
            if replace(one, time_s=0.0) != replace(other, time_s=0.0):
                yield "words"


def _axes(quaternion):
    """(3, 2) tool +X and jet axis of a unit quaternion."""
    w, x, y, z = quaternion
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 1 - 2 * (x * x + y * y)],
        ]
    )

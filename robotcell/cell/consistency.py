"""What a cell says in one place and contradicts in another."""

import math
from collections.abc import Iterator

from robotcell.cell.io_spec import InputOutput, Output, Outputs
from robotcell.cell.spec import CellSpec
from robotcell.robot.robot import Robot
from specs.yaml.located import YamlPath
from specs.yaml.problems import Problem
from specs.yaml.schema import name_nearest

_SLACK = 1e-9


def find_problems(spec: CellSpec) -> list[Problem]:
    """Find channels that are not there, values that a channel cannot take, numbers that stand twice."""
    outputs = spec.io.outputs
    problems = [*_find_twins(outputs), *_find_scales(spec.io)]
    for name, nozzle in spec.nozzles.items():
        path: YamlPath = ("nozzles", name, "valve")
        problems += _check_name(nozzle.valve, outputs, path)
        if nozzle.valve in outputs and outputs[nozzle.valve].kind != "digital":
            problems.append(
                Problem(path, f"{nozzle.valve} is {outputs[nozzle.valve].kind}; a valve needs a digital output")
            )
    for key, setting in spec.io.settings.items():
        problems += _check_name(setting.output, outputs, ("io", "settings", key, "output"))
    for kind in ("functions", "solutions"):
        for name, values in getattr(spec.io, kind).items():
            problems += _check_values(values, outputs, ("io", kind, name))
    problems += _check_values(spec.io.grip.open, outputs, ("io", "grip", "open"))
    problems += _check_values(spec.io.grip.close, outputs, ("io", "grip", "close"))
    return problems


def find_home_problems(spec: CellSpec, robot: Robot) -> list[Problem]:
    """Find a home that has too many or too few values, or lies outside the joints' limits."""
    home = spec.home_deg_mm
    names = ", ".join(joint.name for joint in robot.joints)
    if len(home) != robot.dof:
        return [Problem(("home_deg_mm",), f"has {len(home)} values; {robot.name} has {robot.dof} joints: {names}")]
    problems: list[Problem] = []
    for index, (value, joint) in enumerate(zip(home, robot.joints, strict=True)):
        unit, word = (1e-3, "mm") if joint.kind == "prismatic" else (math.pi / 180, "degrees")
        if not joint.lowest - _SLACK <= unit * value <= joint.highest + _SLACK:
            limits = f"{joint.lowest / unit:g} to {joint.highest / unit:g}"
            problems.append(
                Problem(("home_deg_mm", index), f"{joint.name} goes from {limits} {word}, not to {value:g}")
            )
    return problems


def _find_twins(outputs: dict[str, Output]) -> Iterator[Problem]:
    taken: dict[tuple[str, int], str] = {}
    for name, output in outputs.items():
        other = taken.setdefault((output.kind, output.number), name)
        if other != name:
            message = f"{output.kind} output {output.number} is {other} already; each has its own number"
            yield Problem(("io", "outputs", name, "number"), message)


def _find_scales(io: InputOutput) -> Iterator[Problem]:
    """A channel of mA cannot mean the full scale that one of volts has if nothing is said."""
    for kind, channels in (("outputs", io.outputs), ("sensors", io.sensors)):
        for name, channel in channels.items():
            if channel.unit == "mA" and "full_scale" not in channel.model_fields_set:
                yield Problem(("io", kind, name, "unit"), "mA needs a full_scale too, such as full_scale: 20")


def _check_name(name: str, outputs: dict[str, Output], path: YamlPath) -> Iterator[Problem]:
    if name not in outputs:
        yield Problem(path, f"{name!r} is no output; {name_nearest(name, outputs)}")


def _check_values(values: Outputs, outputs: dict[str, Output], path: YamlPath) -> Iterator[Problem]:
    for name, value in values.items():
        yield from _check_name(name, outputs, (*path, name))
        kind = outputs[name].kind if name in outputs else "analog"
        if kind == "digital" and value not in (0, 1):
            yield Problem((*path, name), f"is digital: 0 or 1, not {value:g}")
        if kind == "group" and (value < 0 or value != int(value)):
            yield Problem((*path, name), f"is a group of bits: a whole number from 0, not {value:g}")

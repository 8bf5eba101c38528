"""Split a timed program into the stages of its process, each with its solution and finely sampled poses."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from boards.board import Side
from cleaning.errors import CleaningError
from cleaning.parameters.model import Liquid, Parameters
from geometry.arrays import Indices, Points, Scalars
from geometry.frames import rotation_angles
from programs.playback import Timeline, build_timeline, play
from programs.program import Command, Instruction, TimedProgram
from recipes.nozzles import Nozzle
from recipes.recipe import Function, Recipe, Use, use_of
from specs.finding import Finding
from specs.finding_rules import LIQUID_UNKNOWN, LOOP_ONCE
from specs.source import Source


@dataclass(frozen=True, slots=True, eq=False)
class Samples:
    """The open nozzle at n moments of a stage, in order of time, each standing for a share of the spraying.

    Board frame, mm, s.
    """

    times: Scalars
    """(n,) middle of each share, from the beginning of the program."""
    seconds: Scalars
    """(n,) spraying time that the sample stands for; their sum is the stage's spraying time."""
    tcp: Points
    """(n, 3) orifice."""
    axes: NDArray[np.float64]
    """(n, 3, 3) rotation of T_board_tool: columns are the nozzle's reference azimuth, its second axis, the jet."""
    made_by: Indices
    """(n,) index into ``makers``."""
    makers: tuple[Source, ...]

    @property
    def templates(self) -> NDArray[np.str_]:
        """(n,) The template of each: ``"around"`` of ``"sequence[0]/around/U1"``; empty where there is none."""
        return np.array([maker.template for maker in self.makers], dtype=np.str_)[self.made_by]


@dataclass(frozen=True, eq=False)
class Stage:
    """One step of the sequence as the program carries it out."""

    made_by: Source
    """Recipe path of the step, such as ``"sequence[0]"``."""
    function: str
    use: Use
    nozzle_name: str
    nozzle: Nozzle
    solution: str
    liquid: Liquid
    pressure_pa: float
    """At the nozzle, above ambient."""
    temperature_c: float
    begin_s: float
    end_s: float
    samples: Samples
    repeats: int = 1
    """How often a loop may do it, at most; its samples are those of once."""
    water_g_m3: float | None = None
    """What its rinse water carries, as salt, where a cascade of tanks is followed; else it follows from the liquid."""

    @cached_property
    def spray_s(self) -> float:
        """How long the jet is on."""
        return float(self.samples.seconds.sum())

    @cached_property
    def side(self) -> Side:
        """The side that it sprays: by where the jet points for most of the time."""
        return "bottom" if float(self.samples.seconds @ self.samples.axes[:, 2, 2]) > 0 else "top"


_PA_PER_BAR = 1e5
_ROOM_C = 20.0
_PRESSURES_BAR = (0.0, 1e4)
_TEMPERATURES_C = (-50.0, 500.0)
_LONGEST_S = 1.0
_LONGEST_RAD = np.radians(4.0)
_NO_WAY = (np.empty((0, 3)), np.empty((0, 3, 3)), np.empty(0, dtype=np.int64))
_NONE = Samples(np.empty(0), np.empty(0), *_NO_WAY, makers=())


@dataclass(frozen=True, slots=True, eq=False)
class Staged:
    """The stages of a program that spray, in order, and what was noticed."""

    stages: tuple[Stage, ...]
    findings: tuple[Finding, ...]


def stages_of(program: TimedProgram, recipe: Recipe, parameters: Parameters, longest_mm: float = 3.0) -> Staged:
    """Cut a program at its FUNCTION instructions and sample the open nozzle of each.

    The body of a loop counts once, as in the program's totals: how often a sensor will require it is not known here.

    Args:
        program: Any program that was planned with this recipe.
        recipe: Has the functions and nozzles that the program names.
        parameters: Have the liquids.
        longest_mm: Way of the orifice that one sample stands for at most; 4 degrees or a second count as much.

    Raises:
        CleaningError: the program names a function or nozzle that the recipe does not have, sets a pressure or
            temperature that cannot be, or never sprays.
        ProgramError: the program has no move.
    """
    timeline = build_timeline(program)
    commands = ((at, item) for at, item in enumerate(program.instructions) if isinstance(item, Command))
    begins = [at for at, item in commands if item.keyword == "FUNCTION"]
    stages: list[Stage] = []
    findings: list[Finding] = []
    for begin, end in zip(begins, [*begins[1:], len(program.instructions)], strict=True):
        until_s = program.instructions[min(end, len(program.instructions) - 1)].time_s
        stage, noticed = _read(program.instructions[begin:end], until_s, recipe, parameters)
        samples = _sample(timeline, stage, longest_mm)
        if len(samples.times):
            stages.append(replace(stage, samples=samples))
            findings += noticed
    if not stages:
        raise CleaningError("the program never sprays, so that it cleans nothing. Plan one whose paths spray.")
    return Staged(tuple(stages), tuple(findings))


def choose_liquid(name: str, function: Function, nozzle: Nozzle, parameters: Parameters) -> tuple[Liquid, str]:
    """Look a function's solution up by its name; an unknown one is taken for the first known one of the same use.

    Gases dry. What has ``rinse`` or ``water`` in the name of its function or solution rinses; all else washes.

    Args:
        name: Of the function.
        function: Names its solution.
        nozzle: An air knife sprays gas unless the function states otherwise.
        parameters: Hold the known liquids.

    Returns:
        The liquid, and a sentence on what was assumed; empty if nothing was.
    """
    if function.solution in parameters.liquids:
        return parameters.liquids[function.solution], ""
    use = use_of(name, function, nozzle)
    like = next((known for known, liquid in parameters.liquids.items() if liquid.use == use), "")
    values = f"the values of {like}" if like else "the values of air" if use == "dry" else "the values of pure water"
    known = ", ".join(parameters.liquids)
    return (
        parameters.liquids[like] if like else Liquid(use=use, density_kg_m3=1.0 if use == "dry" else 1000.0),
        f"{function.solution} is not in the parameter set {parameters.parameters}, so that it counts as a liquid for "
        f"{use} with {values}. Add it under liquids, or use one of {known}.",
    )


def _read(
    instructions: Sequence[Instruction], end_s: float, recipe: Recipe, parameters: Parameters
) -> tuple[Stage, list[Finding]]:
    """Read the commands of one stretch; its samples are still missing."""
    commands = [item for item in instructions if isinstance(item, Command)]
    first = {command.keyword: command for command in reversed(commands)}
    settings = {item.arguments[0]: item.arguments[1] for item in reversed(commands) if item.keyword == "SET"}
    made_by, function = first["FUNCTION"].made_by, first["FUNCTION"].arguments[0]
    nozzle = first["NOZZLE"].arguments[0] if "NOZZLE" in first else ""
    if function not in recipe.functions or nozzle not in recipe.nozzles:
        missing = f"function {function}" if function not in recipe.functions else f"nozzle {nozzle or '(none)'}"
        raise CleaningError(
            f"the program uses {missing}, which the recipe {recipe.recipe} does not have. Give the recipe that the "
            "program was planned with, or plan it again."
        )
    requested = recipe.functions[function]
    liquid, assumed = choose_liquid(function, requested, recipe.nozzles[nozzle], parameters)
    findings = [Finding(LIQUID_UNKNOWN, assumed, made_by)] if assumed else []
    repeats = int(first["REPEAT"].arguments[0]) if "REPEAT" in first else 1
    if repeats > 1:
        message = (
            f"{function} is repeated until a sensor ends it, {repeats} times at most. Times, litres and pictures are "
            "those of once; verdicts state how often it must be done."
        )
        findings.append(Finding(LOOP_ONCE, message, made_by))
    warmth = _setting(settings, "temperature_c", requested.temperature_c, _TEMPERATURES_C, made_by)
    pressure = _setting(settings, "pressure_bar", requested.pressure_bar, _PRESSURES_BAR, made_by)
    stage = Stage(
        made_by=made_by,
        function=function,
        use=liquid.use,
        nozzle_name=nozzle,
        nozzle=recipe.nozzles[nozzle],
        solution=requested.solution,
        liquid=liquid,
        pressure_pa=_PA_PER_BAR * (requested.pressure_bar if pressure is None else pressure),
        temperature_c=_ROOM_C if warmth is None else warmth,
        begin_s=instructions[0].time_s,
        end_s=end_s,
        samples=_NONE,
        repeats=repeats,
    )
    return stage, findings


def _setting(
    settings: Mapping[str, str], key: str, usual: float | None, limits: tuple[float, float], made_by: Source
) -> float | None:
    """Read what the program sets, which anyone may have edited; else what the recipe requests."""
    if key not in settings:
        return usual
    try:
        value = float(settings[key])
    except ValueError:
        value = math.nan
    low, high = limits
    if not low < value < high:  # the negation catches NaN too
        raise CleaningError(
            f"{made_by} sets {key} to {settings[key]}, which must be a number above {low:g} and below {high:g}. "
            "Correct the SET in the program, or plan it again."
        )
    return value


def _sample(timeline: Timeline, stage: Stage, longest_mm: float) -> Samples:
    """Sample the open nozzle between the stage's two times."""
    way = np.linalg.norm(np.diff(timeline.tcp, axis=0), axis=1) / longest_mm
    turn = rotation_angles(timeline.quaternion[:-1], timeline.quaternion[1:]) / _LONGEST_RAD
    due = np.maximum(np.maximum(way, turn), np.diff(timeline.times) / _LONGEST_S)
    spent = np.concatenate([[0.0], np.cumsum(due)])  # samples that are due up to each key pose
    # Intervals of the stage in which the jet is on.
    inside = timeline.switch_times[(timeline.switch_times > stage.begin_s) & (timeline.switch_times < stage.end_s)]
    bounds = np.concatenate([[stage.begin_s], inside, [stage.end_s]])
    switched = np.searchsorted(timeline.switch_times, 0.5 * (bounds[1:] + bounds[:-1]), side="right")
    spraying = timeline.switched_on[switched] & (bounds[1:] > bounds[:-1])
    spans = zip(bounds[:-1][spraying].tolist(), bounds[1:][spraying].tolist(), strict=True)
    edges = [_cut(timeline.times, spent, on, off) for on, off in spans]
    if not edges:
        return _NONE
    times = np.concatenate([0.5 * (each[1:] + each[:-1]) for each in edges])
    states = play(timeline, times)
    seconds = np.concatenate([np.diff(each) for each in edges])
    axes = Rotation.from_quat(states.quaternion, scalar_first=True).as_matrix()
    return Samples(times, seconds, states.tcp, axes, states.made_by, states.makers)


def _cut(times: Scalars, spent: Scalars, on: float, off: float) -> Scalars:
    """Times that cut an interval into shares of equal due."""
    ends = np.interp([on, off], times, spent)
    inside = (times > on) & (times < off)
    due, at = np.concatenate([ends[:1], spent[inside], ends[1:]]), np.concatenate([[on], times[inside], [off]])
    shares = max(1, int(np.ceil(ends[1] - ends[0] - 1e-9)))
    cut = np.interp(np.linspace(ends[0], ends[1], shares + 1), due, at)
    cut[0], cut[-1] = on, off
    return cut

"""Timed programs that every robot language has to say."""

import math
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from each_workpiece import BOARD_RECIPE
from small_plans import (
    JET,
    LIMITS,
    PASS,
    TRANSFER,
    Axes,
    down,
    leaning,
    pause,
    plan_of,
    random_plan,
    spray,
    transfer,
)

from boards.load import load_board
from geometry.frames import align_signs
from programs.motion.installation import Installation
from programs.motion.layout import Tracking, on_time
from programs.plan import Command, Jet, PlanItem, SprayPass, Transfer
from programs.pose import Pose, compose, rotate
from programs.program import MoveTo, SetNozzle, TimedProgram
from recipes.load import load_recipe
from rulesengine.planning.pipeline import run
from rulesengine.timing.time_plan import time_plan
from specs.source import Source

KNIFE = Jet("dry", "knife", "hot-air", 400.0, False)


def command(keyword: str, *words: str) -> Command:
    return Command(keyword, words, "s")


def begin(nozzle: str = "ring60", tool: int = 1, function: str = "clean") -> list[PlanItem]:
    return [
        command("FUNCTION", function),
        command("NOZZLE", nozzle, "TOOL", str(tool)),
        command("SOLUTION", "saponifier-15"),
        command("SET", "pressure_bar", "3.500"),
    ]


def turning(before: Axes, after: Axes) -> Axes:
    """From one orientation to another."""
    return np.vstack((before[0][:1], after[0][:1])), np.vstack((before[1][:1], after[1][:1]))


def three_speeds() -> TimedProgram:
    """Three speeds, pauses, a turn on the spot, a stroke that is passed through without a stop, a blended corner."""
    first, second = leaning([0.0, 0.0], 0.4), leaning([0.0, np.pi / 2], 0.4)
    items = [
        *begin(),
        transfer([[0, 0, 110], [0, 0, 50]]),
        spray([[0, 0, 50], [60, 0, 50]], 20.0),
        pause(0.35),
        spray([[60, 0, 50], [60, 40, 50], [20, 40, 50]], 60.0),
        transfer([[20, 40, 50], [20, 40, 60]]),
        transfer([[20, 40, 60], [20, 40, 60]], axes=turning(down(1), first)),
        spray([[20, 40, 60], [80, 40, 60]], 120.0, first),
        spray([[80, 40, 60], [80, 40, 60]], 120.0, second),
        pause(0.1),
    ]
    return time_plan(plan_of(*items), LIMITS)


def short_strokes() -> TimedProgram:
    """Jets and gaps shorter than the valve follows."""
    items: list[PlanItem] = [*begin(), transfer([[0, 0, 110], [0, 0, 50]])]
    x = 0.0
    for length, gap in ((0.2, 5.0), (3.0, 0.1), (3.0, 8.0), (0.05, 0.05), (10.0, 2.0)):
        items += [
            spray([[x, 0, 50], [x + length, 0, 50]], 100.0),
            transfer([[x + length, 0, 50], [x + length + gap, 0, 50]]),
        ]
        x += length + gap
    return time_plan(plan_of(*items), LIMITS)


def in_flight() -> TimedProgram:
    """The jet begins and ends in the middle of long moves, several times on one of them."""
    program = time_plan(
        plan_of(*begin(), transfer([[0, 0, 50], [200, 30, 50]], 100.0), transfer([[200, 30, 50], [0, 30, 50]], 100.0)),
        LIMITS,
    )
    end_s = program.totals.duration_s
    moments = [0.3, 0.55, 0.7, 0.9, 1.1, 1.3, 1.5, 1.7, 1.85, 2.0, 2.6, end_s - 0.25]
    switches = [SetNozzle(moment, number % 2 == 0, Source.parse("s/flight")) for number, moment in enumerate(moments)]
    told = sorted((*program.instructions, *switches), key=lambda item: item.time_s)
    return replace(program, instructions=tuple(told))


def loop() -> TimedProgram:
    """A loop whose body begins with the jet."""
    items = [
        *begin(),
        transfer([[0, 0, 110], [0, 0, 50]]),
        command("REPEAT", "4", "UNTIL", "resistivity_mohm_cm", ">=", "1.0"),
        spray([[0, 0, 50], [40, 0, 50]], 60.0),
        transfer([[40, 0, 50], [40, 10, 50]]),
        spray([[40, 10, 50], [0, 10, 50]], 60.0),
        transfer([[0, 10, 50], [0, 0, 50]]),
        command("ENDREPEAT"),
        transfer([[0, 0, 50], [0, 0, 110]]),
    ]
    return time_plan(plan_of(*items), LIMITS)


def two_tools() -> TimedProgram:
    """A nozzle, then an air knife, and back."""
    blow = replace_jet(spray([[40, 0, 50], [0, 0, 50]], 40.0))
    items = [
        *begin(),
        transfer([[0, 0, 110], [0, 0, 50]]),
        spray([[0, 0, 50], [40, 0, 50]], 60.0),
        *begin("knife", 2, "dry"),
        blow,
        transfer([[0, 0, 50], [0, 0, 110]]),
        command("GRIP", "close"),
        *begin(),
        transfer([[0, 0, 110], [0, 0, 50]]),
        spray([[0, 0, 50], [20, 20, 50]], 60.0),
    ]
    return time_plan(plan_of(*items), LIMITS)


def bottom() -> TimedProgram:
    """The board turned over: the nozzle comes from below, as seen from the board."""
    up = (np.tile([0.0, 0.0, 1.0], (2, 1)), np.tile([0.0, -1.0, 0.0], (2, 1)))
    over = turning(down(1), up)
    items = [
        *begin(),
        transfer([[0, 0, 110], [-60, 0, 110]]),
        command("CALL", "flip_to_bottom"),
        Transfer(np.array([[-60, 0, 110], [-60, 0, -110]], dtype=np.float64), *over, 100.0, TRANSFER),
        transfer([[-60, 0, -110], [0, 0, -50]], axes=up),
        SprayPass(np.array([[0, 0, -50], [50, 5, -50]], dtype=np.float64), *up, np.array([55.0]), JET, PASS),
    ]
    return time_plan(plan_of(*items), LIMITS)


def faces() -> TimedProgram:
    """A part with faces along +-x and +-y: the jet lies along each axis of the part, and twice at each face."""
    items: list[PlanItem] = [*begin(), transfer([[0, 0, 200], [0, 0, 150]])]
    before, at = down(1), np.array([0.0, 0.0, 150.0])
    for x, y in ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)):
        jet = np.array([x, y, 0.0])
        axes = np.tile(jet, (2, 1)), np.tile([0.0, 0.0, -1.0] if x > 0.0 else np.cross(jet, [0.0, 0.0, 1.0]), (2, 1))
        begins = -80.0 * jet + [0.0, 0.0, 40.0]
        items.append(Transfer(np.array([at, begins]), *turning(before, axes), 100.0, TRANSFER))
        at = begins + 30.0 * np.array([-y, x, 0.0])
        items.append(SprayPass(np.array([begins, at]), *axes, np.array([55.0]), JET, PASS))
        before = axes
    return time_plan(plan_of(*items), LIMITS)


def panel() -> TimedProgram:
    """Lines over two boards of a panel, as if they were for a component that is named by its board too."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "two.yaml").write_text("panel: {board: tiny, nx: 2, pitch_mm: [33, 24]}\n", "utf-8")
        (folder / "lines.yaml").write_text(BOARD_RECIPE, "utf-8")
        program = run(load_recipe(str(folder / "lines.yaml")), load_board(folder / "two.yaml")).program
    told = (replace(item, made_by=replace(item.made_by, components=("U1@2",))) for item in program.instructions)
    return replace(program, instructions=tuple(told))


def odd_names() -> TimedProgram:
    """Names that no controller takes."""
    program = three_speeds()
    told = tuple(
        replace(item, made_by=Source.parse(f"Größe Ω/{item.made_by}/" + 60 * "x")) for item in program.instructions
    )
    origin = replace(program.origin, board="Ω 7/3 " + 60 * "long ", recipe="größe")
    return replace(program, origin=replace(origin, board=origin.board.strip()), instructions=told)


def at_random() -> TimedProgram:
    """Many strokes, straight and curved, turning and not."""
    return time_plan(plan_of(*begin(), *random_plan(5, 25).items), LIMITS)


def planned() -> TimedProgram:
    """The smallest sample board with the library's recipe."""
    return run(load_recipe("smt-aqueous"), load_board(Path("tiny"))).program


def joints_of(program: TimedProgram) -> Tracking:
    """The tracking of some six joints that move as the orifice does."""
    moves = [move for move in program.instructions if isinstance(move, MoveTo)]
    turns = align_signs(np.array([move.quaternion for move in moves]))
    return on_time(program, np.hstack((0.01 * np.array([move.position for move in moves]), turns[:, 1:])))


def machine_joints_of(program: TimedProgram, cell: Installation) -> Tracking:
    """The tracking of a machine with tool points: C follows the jet's azimuth, and stays where the jet is upright."""
    machine, place, rows, before = cell.tool_point, cell.T_base_board, list[list[float]](), 0.0
    assert machine is not None
    for item in program.instructions:
        if isinstance(item, Command) and item.keyword == "CALL":
            place = cell.placements.get(item.words[0], place)
        if isinstance(item, MoveTo):
            tip = compose(place, Pose(item.position, item.quaternion))
            x, y, z = rotate(tip.quaternion, (0.0, 0.0, 1.0))
            if math.hypot(x, y) > 1e-6:
                before += math.remainder(math.atan2(y, x) - before, math.tau)
            at = [a + b for a, b in zip(tip.position, machine.base, strict=True)]
            rows.append([*at, before, math.atan2(math.hypot(x, y), -z)])
    return on_time(program, machine.joints(np.array(rows)))


def replace_jet(item: SprayPass) -> SprayPass:
    return replace(item, jet=KNIFE)


PROGRAMS: dict[str, Callable[[], TimedProgram]] = {
    made.__name__: cache(made)
    for made in (
        *(three_speeds, short_strokes, in_flight, loop, two_tools, bottom, faces, panel, odd_names, at_random),
        planned,
    )
}
"""By name; a dialect has to say all of them."""

"""Cells as robot programs see them, for tests."""

import math
from dataclasses import replace

from programs.motion.installation import (
    Assignment,
    Channel,
    Contact,
    Handshake,
    Installation,
    Joint,
    JointConvention,
    Maker,
    Payload,
    Sensor,
    Setting,
    Tool,
    ToolPointMachine,
    Valve,
    Wait,
)
from programs.pose import Pose
from programs.posts.dialects import DIALECTS

WASH = Channel("digital", "doWash", 1)
AIR = Channel("digital", "doAir", 2)
GRIPPER = Channel("digital", "doGripper", 3)
MEDIUM = Channel("group", "goMedium", 1)
PRESSURE = Channel("analog", "aoPressure", 1)
HEAT = Channel("analog", "aoHeat", 2)

RING = Valve(WASH, open_lag_s=0.04, close_lag_s=0.02, min_pulse_s=0.03)
KNIFE = Valve(AIR, open_lag_s=0.1, close_lag_s=0.05, min_pulse_s=0.05)

WAITS = (
    Wait("part_present", Contact("diPart", 3), True, None, 0.0, 30.0),
    Wait("door_closed", Contact("diDoor", 4), False, None, 0.0, 12.5, "close the door", watched=True),
    Wait("pressure", None, True, Sensor("aiPressure", 2, 1.25, -2.5), 3.0, 20.0, quantity="supply_bar"),
)

_HALF = math.radians(15)


def small_cell(maker: Maker | None = None) -> Installation:
    """Two nozzles at an angle on the flange, a board that lies askew, an output for each word of the library recipe.

    The arm is of that maker; a FANUC controller counts its third joint from level.
    """
    level = JointConvention(
        tuple(tuple(float(i == j) - float((i, j) == (2, 1)) for j in range(6)) for i in range(6)), (0.0,) * 6
    )
    return Installation(
        cell="bench",
        robot="arm",
        T_base_board=Pose((400.0, -120.5, 35.25), (math.cos(_HALF), 0.0, 0.0, math.sin(_HALF))),
        tools={
            1: Tool("ring60", Pose((0.0, 30.0, 142.5), (0.9238795, 0.0, 0.3826834, 0.0)), payload=Payload(0.8)),
            2: Tool("knife", Pose((0.0, -45.0, 120.0), (0.9238795, 0.0, -0.3826834, 0.0)), payload=Payload(1.1)),
        },
        valves={"ring60": RING, "knife": KNIFE},
        functions=dict.fromkeys(("clean", "rinse", "dry"), ()),
        solutions={
            "saponifier-15": (Assignment(MEDIUM, 1.0),),
            "di-water": (Assignment(MEDIUM, 2.0),),
            "hot-air": (Assignment(MEDIUM, 3.0),),
        },
        settings={"pressure_bar": Setting(PRESSURE, 2.0, 0.5), "temperature_c": Setting(HEAT, 0.1)},
        grips={"open": (Assignment(GRIPPER, 0.0),), "close": (Assignment(GRIPPER, 1.0),)},
        sensors={"resistivity_mohm_cm": Sensor("aiResistivity", 1, 2.0)},
        waits=WAITS,
        placements={"flip_to_bottom": Pose((400.0, 120.0, 60.0), (0.0, 1.0, 0.0, 0.0))},
        joints=tuple(Joint(f"j{number}", "revolute") for number in range(1, 7)),
        home=(0.0, -0.5, 0.6, 0.0, 1.2, 0.0),
        maker=maker,
        convention=level if maker == "fanuc" else None,
    )


def bare_cell(maker: Maker | None = None) -> Installation:
    """Nothing but the tools and the valves."""
    cell = small_cell(maker)
    return Installation("bare", cell.robot, cell.T_base_board, cell.tools, cell.valves, joints=cell.joints, maker=maker)


def for_language(cell: Installation, dialect: str) -> Installation:
    """A cell whose robot is of the maker of a language, where that has one."""
    maker = DIALECTS[dialect].maker
    return replace(cell, maker=maker, convention=small_cell(maker).convention)


ARM_LANGUAGES = {name: each for name, each in DIALECTS.items() if not each.needs_tool_points}
"""Languages that a cell without tool points can have."""
MACHINE_LANGUAGES = [name for name in DIALECTS if name not in ARM_LANGUAGES]
"""Languages of machines whose controller takes tool points."""


def small_machine() -> Installation:
    """The small cell with a gantry whose head turns about C and tilts about B, the other way round than counted."""
    cell = small_cell()
    slides = [Joint(name, "prismatic", 500.0, 3000.0) for name in "XYZ"]
    head = [Joint(name, "revolute", 3.0, 30.0) for name in "CB"]
    return replace(
        cell,
        robot="gantry",
        joints=(*slides, *head),
        home=(0.0, -50.0, 300.0, 0.5, 0.0),
        tool_point=ToolPointMachine(180.0, (10.0, 0.0, -20.0), 3, math.pi / 2, (1.0, -1.0), 0.0),
    )


LAMP, BUSY, DONE, FAULT = (
    Channel("digital", name, 20 + at) for at, name in enumerate(("doLamp", "doBusy", "doDone", "doFault"))
)
LINE = Handshake(Contact("diStart", 11), BUSY, DONE, FAULT, Contact("diPart", 3))
HEAVY = Payload(1.25, (-1.5, 2.0, 80.5), (0.001, 0.002, 0.0), is_stated=True)


def full_cell(name: str) -> Installation:
    """The small cell, or machine, of a language with all that a cell may state."""
    cell = for_language(small_cell(), name) if name in ARM_LANGUAGES else small_machine()
    tools = {number: replace(tool, payload=HEAVY) for number, tool in cell.tools.items()}
    return replace(cell, lamp=LAMP, handshake=LINE, tools=tools)

"""ABB RAPID, with and without the paint option."""

from programs.motion.lower import Capability
from programs.posts.abb.paint import Paint, PaintReader
from programs.posts.abb.read import RapidReader
from programs.posts.abb.write import Rapid
from programs.posts.dialect import Dialect, FileForm
from programs.timing.controller import Controller

_CONTROLLER = Controller(
    blending="zone",
    settle_s=0.05,
    look_ahead=20,
    least_line_s=0.01,
    most_lines=10_000,
    sources={
        "blending": "RAPID overview: zones that overlap shrink to half the distance of their points",
        "acceleration_mm_s2": "RAPID overview: acceleration is that of the motors, so the joints limit it",
    },
)
DIALECT = Dialect(
    title="ABB RAPID",
    notes="Modules for RobotWare 6 and 7; outputs by TriggEquip and TriggIO. Load the .pgf, or the one .mod. "
    "Identify the tools' loads before running.",
    capability=Capability(
        controller_class=1,
        timing="distance and time",
        cycle_s=0.002,
        most_events=8,  # TriggL takes Trigg_1 and \T2 to \T8
        longest_lead_s=0.5,  # assumed: what TriggIO \Time and EquipLag take without a change of Event Preset Time
        step_mm_s=0.1,
    ),
    form=FileForm(".mod", beside=(".pgf",)),
    longest_line=200,
    most_steps=2000,  # of a module: with a target and an instruction for each, below 5,000 lines; assumed
    write=Rapid.write,
    rebuild=RapidReader.rebuild,
    controller=_CONTROLLER,
    maker="abb",
    without_joints="Stand the arm in the configuration that it is to keep (ConfJ\\Off, ConfL\\Off).",
)
PAINT_DIALECT = Dialect(
    title="ABB RAPID, RobotWare Paint",
    notes="For IRC5P: brush 0 shuts the guns, brush 1 opens the one that the string sBrush1 names, and so on; fill the "
    "brush table so. Where the process controller leads the guns itself, give the cell's valves no lag.",
    capability=Capability(
        controller_class=3,
        timing="boundary",  # assumed: a SetBrush without a plane acts where the next PaintL begins
        cycle_s=0.004,  # assumed, of the process controller
        step_mm_s=0.1,
    ),
    form=FileForm(".mod", beside=(".pgf",)),
    longest_line=200,
    most_steps=2000,
    write=Paint.write,
    rebuild=PaintReader.rebuild,
    controller=_CONTROLLER,
    maker="abb",
    without_joints="Stand the arm in the configuration that it is to keep (ConfJ\\Off, ConfL\\Off).",
)

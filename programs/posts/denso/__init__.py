"""Denso PacScript."""

from programs.motion.analog import Counting
from programs.motion.lower import Capability
from programs.posts.denso.read import PacScriptReader
from programs.posts.denso.write import PacScript
from programs.posts.dialect import Dialect, FileForm
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="Denso PacScript",
    notes="For RC8 and newer; outputs by Next and Arrive. Speeds are percents: put 100 divided by the arm's greatest "
    "speeds into PER_MM_S and PER_DEG_S, and run at ExtSpeed 100. Corners are passed from 1 mm before them or more. "
    "Groups are IOB, analog channels IOW, 10000 at full scale.",
    capability=Capability(
        controller_class=2,
        timing="percent",
        cycle_s=0.008,  # assumed: Arrive looks at the encoders, and a task runs every few milliseconds
        step_percent=1.0,
        most_events=8,  # assumed
        step_mm_s=0.1,
        # Words of 16 bits; 10,000 at full scale is assumed: the module and its configuration decide.
        analog=Counting(full=10_000.0, step=1.0),
    ),
    form=FileForm(".pcs"),
    longest_line=200,  # assumed
    most_steps=1000,  # of a program; assumed
    write=PacScript.write,
    rebuild=PacScriptReader.rebuild,
    controller=Controller(
        blending="zone",
        acceleration_mm_s2=2000.0,
        turn_acceleration_deg_s2=1800.0,
        joint_speed_share=0.1,
        settle_s=0.05,
        look_ahead=10,
        least_line_s=0.008,
        most_lines=10_000,
    ),
    maker="denso",
    without_joints="Stand the arm in the figure that it is to keep: positions keep the one that it has (-1).",
)

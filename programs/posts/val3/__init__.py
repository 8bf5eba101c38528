"""Stäubli VAL 3."""

from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.val3.project import PERIOD_S
from programs.posts.val3.read import Val3Reader
from programs.posts.val3.write import Val3
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="Staubli VAL3",
    notes="A project for CS8 and CS9, VAL3 s7 and newer: copy its folder to the controller and link "
    "the variables do, go, ao and ai. A task of 4 ms sets outputs on the path, as direct ones run ahead of the motion.",
    capability=Capability(
        controller_class=4,
        timing="boundary",
        cycle_s=PERIOD_S,
        step_mm_s=0.1,
        switches_at_rest=True,  # the way of the last 60 ms before a stop is of the controller's own ramp
    ),
    form=FileForm(".pjx", several=(".pjx", ".dtx", ".pgx"), is_project=True),
    longest_line=200,  # assumed
    most_steps=1500,  # of a program; assumed, an array takes 9,999 points
    write=Val3.write,
    rebuild=Val3Reader.rebuild,
    controller=Controller(
        blending="zone",
        settle_s=0.05,
        look_ahead=20,
        least_line_s=0.004,
        most_positions=9_999,
        sources={"most_positions": "size of an array"},
    ),
    maker="staubli",
    without_joints="Stand the arm in the configuration that it is to keep: points have ssame, esame, wsame.",
)

"""KUKA KRL."""

from programs.motion.analog import Counting
from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.kuka.read import KrlReader
from programs.posts.kuka.write import Krl
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="KUKA KRL",
    notes="A .src and a .dat for KSS 8; outputs by TRIGGER WHEN PATH. Groups are SIGNALs of $config.dat, $ANOUT counts "
    "from -1 to 1. LIN keeps the configuration of the first PTP.",
    capability=Capability(
        controller_class=1,
        timing="distance and time",
        cycle_s=0.004,  # assumed: the interpolation cycle of a KR C4; integrators report 1 ms for triggers
        references=("end",),  # PATH counts from the end point; ONSTART needs a newer KSS
        step_mm=0.01,
        step_mm_s=0.1,
        most_events=8,  # integrators report eight triggers at work at once
        analog=Counting(full=1.0),  # $ANOUT and $ANIN count from -1 to 1 of full scale
    ),
    form=FileForm(".src", several=(".src", ".dat")),
    longest_line=200,
    most_steps=1500,  # of a module: about 4,500 lines of .src; assumed, nobody states a limit
    write=Krl.write,
    rebuild=KrlReader.rebuild,
    controller=Controller(
        blending="zone",
        acceleration_mm_s2=2300.0,
        turn_speed_deg_s=200.0,
        turn_acceleration_deg_s2=1000.0,
        joint_speed_share=0.1,
        settle_s=0.05,
        look_ahead=3,
        least_line_s=0.012,
        most_lines=20_000,
        sources={
            "turn_acceleration_deg_s2": "$ACC.ORI1 of the program's text",
            "look_ahead": "$ADVANCE = 3, which BAS(#INITMOV) sets",
            "least_line_s": "interpolation cycle of 12 ms (RRS interface of KUKA)",
        },
    ),
    maker="kuka",
    without_joints="Stand the arm in the configuration that it is to keep: PTP without S and T keeps it.",
)

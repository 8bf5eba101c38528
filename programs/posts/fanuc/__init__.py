"""FANUC TP in its text form (LS)."""

from programs.motion.analog import Counting
from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.fanuc.read import TpReader
from programs.posts.fanuc.write import Tp
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="FANUC TP",
    notes="ASCII programs for R-30iA and newer (option ASCII Upload). Run the program that ends in FR once, or enter "
    "your own UFRAME and UTOOL; the .txt names them. Analog channels count 2000 at full scale.",
    capability=Capability(
        controller_class=1,
        timing="time",
        cycle_s=0.008,  # assumed: the interpolator's period of an R-30iB
        references=("end",),
        step_s=0.01,  # TB has two decimals
        step_mm_s=1.0,  # whole mm/sec
        most_events=1,  # one TB on a motion
        # AI and AO are whole numbers: users cite the manual of the AAD04A, 2000 for 10 V; assumed of other modules.
        analog=Counting(full=2000.0, step=1.0),
    ),
    form=FileForm(".ls", several=(".ls", ".txt")),
    longest_line=120,
    most_steps=800,  # of a program, each motion an instruction and a position; assumed, the memory is the limit
    write=Tp.write,
    rebuild=TpReader.rebuild,
    controller=Controller(
        blending="overlap",
        rise_s=0.03,
        acceleration_mm_s2=2000.0,
        turn_acceleration_deg_s2=1800.0,
        joint_speed_share=0.1,
        settle_s=0.05,
        look_ahead=10,
        least_line_s=0.016,
        most_positions=9_999,
        sources={"least_line_s": "two periods of the interpolator of 8 ms, assumed"},
    ),
    maker="fanuc",
)

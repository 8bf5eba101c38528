"""Mitsubishi MELFA-BASIC V and VI."""

from programs.motion.analog import Counting
from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.melfa.read import MelfaBasicReader
from programs.posts.melfa.write import MelfaBasic
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="Mitsubishi MELFA-BASIC",
    notes="For CR750, CR800 and the like; outputs by Wth at the beginning of a move. Base is the robot seen from the "
    "board; the controller keeps Base and Tool, so main ends with the defaults. Groups are M_Outb, analog channels "
    "M_Outw, 10000 at full scale. Where joints are not known structure flag 7 is assumed.",
    capability=Capability(
        controller_class=3,
        timing="boundary",
        cycle_s=0.0071,  # assumed: the motion cycle of CR750; CR800 has half of it
        step_mm_s=0.1,
        # Words of 16 bits; 10,000 at full scale is assumed: the module and its configuration decide.
        analog=Counting(full=10_000.0, step=1.0),
    ),
    form=FileForm(".prg", several=(".prg",)),
    longest_line=127,  # of a step (manual of CR1D)
    most_steps=2000,  # of a program: below 8,000 of the 32,767 step numbers; assumed
    write=MelfaBasic.write,
    rebuild=MelfaBasicReader.rebuild,
    controller=Controller(
        blending="zone",
        acceleration_mm_s2=2000.0,
        turn_speed_deg_s=180.0,
        turn_acceleration_deg_s2=1800.0,
        joint_speed_share=0.1,
        settle_s=0.05,
        look_ahead=10,
        least_line_s=0.0071,
        most_lines=32_767,
        sources={"most_lines": "step numbers of a program (manual of CR1D)"},
    ),
    maker="mitsubishi",
)

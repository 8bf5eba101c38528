"""LinuxCNC G-code."""

from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.linuxcnc.read import GCodeReader
from programs.posts.linuxcnc.write import GCode
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="LinuxCNC G-code",
    notes="For gantries with trivial kinematics, where joint values are the axes, or 5axiskins, where tool points are: "
    "the cell's kinematics states which. No tool lengths are used (G49); G54 is the board's origin. The header lists "
    "the outputs to wire; num_dio and num_aio may be few.",
    capability=Capability(
        least_part_s=0.0,  # jets at their places come before blocks of 20 ms
        controller_class=3,
        timing="boundary",
        cycle_s=0.001,  # the servo thread of the sample configurations
        step_mm_s=0.1 / 60.0,
        switches_at_rest=True,  # a block of 40 ms before a stop would slow others down; its own ramp is not the plan's
    ),
    form=FileForm(".ngc"),
    longest_line=200,  # the interpreter takes 255 characters (LINELEN)
    most_steps=5000,  # of a subroutine; assumed, for previews: the interpreter itself reads from disk, line by line
    write=GCode.write,
    rebuild=GCodeReader.rebuild,
    controller=Controller(
        blending="tolerance",
        look_ahead=50,
        least_line_s=0.001,
        blend_acceleration_share=0.5,
        stops_in_turning_line=True,
        sources={
            "look_ahead": "ARC_BLEND_OPTIMIZATION_DEPTH of the INI file, 50",
            "least_line_s": "SERVO_PERIOD, 1 ms",
            "blend_acceleration_share": "tp.c: parabolic blends have half the acceleration",
            "stops_in_turning_line": "tp.c: no look-ahead over lines with turning axes",
        },
    ),
    needs_joints=True,
    takes_axes=True,
)

"""SINUMERIK 840D programs under TRAORI."""

from programs.motion.analog import Counting
from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.sinumerik.read import SinumerikReader
from programs.posts.sinumerik.write import Sinumerik
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="SINUMERIK 840D (TRAORI)",
    notes="For a machine with two rotary axes in its head and TRAORI. G54 is the board's origin. Inputs and outputs "
    "count from 1: the header lists them. No controller has executed it yet.",
    capability=Capability(
        controller_class=3,
        timing="boundary",
        cycle_s=0.004,  # assumed: of interpolation
        step_mm_s=0.1 / 60.0,
        switches_at_rest=True,  # the way of the last 40 ms before a stop is of the controller's own ramp
        analog=Counting(full=10000.0, step=1.0),  # millivolts, assumed
    ),
    form=FileForm(".mpf", several=(".mpf", ".spf")),
    longest_line=200,
    most_steps=5000,  # of one program; assumed
    write=Sinumerik.write,
    rebuild=SinumerikReader.rebuild,
    controller=Controller(blending="tolerance", rise_s=0.05, look_ahead=150, least_line_s=0.002),
    needs_joints=True,
    takes_axes=True,
    needs_tool_points=True,
)

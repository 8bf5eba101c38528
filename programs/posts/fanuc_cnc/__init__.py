"""FANUC CNC G-code under G43.4."""

from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.fanuc_cnc.read import FanucCncReader
from programs.posts.fanuc_cnc.write import FanucCnc
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="FANUC CNC G-code (30i, G43.4)",
    notes="For a machine with two rotary axes in its head and tool center point control (G43.4). G54 is the board's "
    "origin. Outputs are M codes: the header lists them. No controller has executed it yet.",
    capability=Capability(
        controller_class=3,
        timing="boundary",
        cycle_s=0.008,  # assumed: of the ladder that takes the M codes
        step_mm_s=0.1 / 60.0,
        switches_at_rest=True,  # the way of the last 40 ms before a stop is of the controller's own ramp
    ),
    form=FileForm(".nc"),
    longest_line=200,
    most_steps=5000,  # of one program; assumed
    write=FanucCnc.write,
    rebuild=FanucCncReader.rebuild,
    controller=Controller(blending="tolerance", rise_s=0.05, look_ahead=200, least_line_s=0.001),
    needs_joints=True,
    takes_axes=True,
    needs_tool_points=True,
)

"""HEIDENHAIN Klartext under FUNCTION TCPM."""

from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.heidenhain.read import HeidenhainReader
from programs.posts.heidenhain.write import Heidenhain
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="HEIDENHAIN Klartext (TNC, TCPM)",
    notes="For a machine with two rotary axes in its head and FUNCTION TCPM (M128). The preset is the machine's zero. "
    "Outputs are M functions: the header lists them. No controller has executed it yet.",
    capability=Capability(
        controller_class=3,
        timing="boundary",
        cycle_s=0.01,  # assumed: of the PLC that takes the M functions
        step_mm_s=0.1 / 60.0,
        switches_at_rest=True,  # the way of the last 40 ms before a stop is of the controller's own ramp
    ),
    form=FileForm(".h"),
    longest_line=220,
    most_steps=5000,  # of one program; assumed
    write=Heidenhain.write,
    rebuild=HeidenhainReader.rebuild,
    controller=Controller(blending="tolerance", rise_s=0.05, look_ahead=200, least_line_s=0.003),
    needs_joints=True,
    takes_axes=True,
    needs_tool_points=True,
)

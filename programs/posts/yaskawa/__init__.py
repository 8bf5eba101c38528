"""Yaskawa INFORM."""

from programs.motion.analog import Counting
from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.yaskawa.read import InformReader
from programs.posts.yaskawa.write import Inform
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="Yaskawa INFORM",
    notes="Relative jobs for DX100 and newer; set parameter S2C714 for ENWAIT. Enter the user frames and tools that "
    "the .TXT lists. After rising the robot goes to the first pose by MOVJ.",
    capability=Capability(
        controller_class=1,
        timing="time",
        cycle_s=0.004,  # assumed: the interpolation cycle of a YRC1000
        references=("end",),
        step_s=0.01,  # T has two decimals; DIS would be exact only where the robot does not slow down
        most_events=1,  # ENWAIT lets one instruction go ahead
        step_mm_s=0.1,
        analog=Counting(step=1e-3),  # AOUT takes volts
        reads_sensors=False,  # analog inputs come by an option, and each by its own
    ),
    form=FileForm(".JBI", several=(".JBI", ".TXT")),
    longest_line=120,
    most_steps=1000,  # of a job; assumed, the memory is the limit, and positions are numbered up to C09998
    write=Inform.write,
    rebuild=InformReader.rebuild,
    controller=Controller(
        blending="zone",
        rise_s=0.03,
        acceleration_mm_s2=2000.0,
        turn_acceleration_deg_s2=1800.0,
        joint_speed_share=0.1,
        settle_s=0.05,
        look_ahead=10,
        least_line_s=0.008,
        most_positions=9_998,
        sources={"most_positions": "positions are numbered up to C09998"},
    ),
    maker="yaskawa",
    writes_joints=False,
)

"""Universal Robots URScript."""

from programs.motion.analog import Counting
from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.ur.read import UrScriptReader
from programs.posts.ur.write import UrScript
from programs.timing.controller import Controller

DIALECT = Dialect(
    title="URScript",
    notes="For PolyScope 5; a thread watches the path. Analog outputs count from 0 to 1, inputs in volts or amperes; "
    "group outputs are integer output registers. Several files: one Script node for each, the numbered ones before the "
    "main one, which calls itself. One file: sent to the controller as it is; a Script node has to call it.",
    capability=Capability(
        controller_class=4,
        timing="distance",
        cycle_s=0.002,  # the thread runs once in each cycle of the controller, 500 Hz; the e-Series
        references=("start",),
        step_mm=0.001,
        step_mm_s=0.1,
        most_events=8,
        # By the script manual of the e-Series outputs take a level from 0 to 1, where 1 is 10 V or, in the domain of
        # currents, 20 mA, and inputs are read in volts or amperes. That 0 is 4 mA then is reported by users of RTDE.
        analog=Counting(full=1.0, least=0.0, zero_ma=4.0, reads_amperes=True),
    ),
    form=FileForm(".script", also=(".urscript",)),
    longest_line=200,
    most_steps=1500,  # of a script file; assumed, nobody states a limit, and larger scripts take long to load
    write=UrScript.write,
    rebuild=UrScriptReader.rebuild,
    controller=Controller(
        blending="zone",
        acceleration_mm_s2=1200.0,
        joint_speed_share=0.1,
        look_ahead=100,
        least_line_s=0.008,
        times_are_whole=True,
        most_bytes=2_000_000,
        sources={"acceleration_mm_s2": "stated by each movel", "times_are_whole": "script manual: t overrules a and v"},
    ),
    maker="universal-robots",
    without_joints="Stand the arm in the configuration that it is to keep: movej takes the nearest one.",
)

"""A table of joint values by time."""

from programs.motion.lower import Capability
from programs.posts.dialect import Dialect, FileForm
from programs.posts.joint_table.read import rebuild
from programs.posts.joint_table.write import write

DIALECT = Dialect(
    title="Joint look-up table",
    notes="CSV for a controller that plays joint values at times: degrees and mm, straight from row to row. "
    "Loops and calls are words in the column of events.",
    # Each signal has a row at its own time; times have six decimals.
    capability=Capability(controller_class=1, timing="distance and time", cycle_s=5e-7, most_events=10**6),
    form=FileForm(".csv"),
    longest_line=250,
    write=write,
    rebuild=rebuild,
    needs_joints=True,
    writes_joints=False,
)

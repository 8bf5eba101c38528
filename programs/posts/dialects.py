"""Every language a program can be exported in, by name."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TypeAlias

from programs.motion.installation import Installation
from programs.motion.lower import Capability, Lowered
from programs.posts.abb import paint as abb_paint
from programs.posts.abb import read as abb_reader
from programs.posts.abb import read_paint as abb_paint_reader
from programs.posts.abb import write as abb
from programs.posts.denso import read as denso_reader
from programs.posts.denso import write as denso
from programs.posts.epson import read as epson_reader
from programs.posts.epson import write as epson
from programs.posts.fanuc import read as fanuc_reader
from programs.posts.fanuc import write as fanuc
from programs.posts.joint_table import read as joint_table_reader
from programs.posts.joint_table import write as joint_table
from programs.posts.kuka import read as kuka_reader
from programs.posts.kuka import write as kuka
from programs.posts.linuxcnc import read as linuxcnc_reader
from programs.posts.linuxcnc import write as linuxcnc
from programs.posts.melfa import read as melfa_reader
from programs.posts.melfa import write as melfa
from programs.posts.reading.rebuilt import Rebuilt
from programs.posts.ur import read as ur_reader
from programs.posts.ur import write as ur
from programs.posts.val3 import read as val3_reader
from programs.posts.val3 import write as val3
from programs.posts.yaskawa import read as yaskawa_reader
from programs.posts.yaskawa import write as yaskawa

ProgramFiles: TypeAlias = Mapping[str, str]
"""Text by file name, the one to start with first."""


@dataclass(frozen=True, slots=True)
class Dialect:
    """One controller's language: how it is written and read, and what it can time."""

    title: str
    render: Callable[[Lowered, Installation], ProgramFiles]
    """Pure: the same motion and cell give the same bytes."""
    read: Callable[[ProgramFiles], Rebuilt]
    capability: Capability
    longest_line: int
    """Characters; a test holds every program to it."""
    notes: str
    """What the integrator has to know, one or two sentences."""
    needs_joints: bool = False
    """Whether the joint motion has to be known."""


DIALECTS: Mapping[str, Dialect] = {
    "abb": Dialect(abb.TITLE, abb.render, abb_reader.read, abb.CAPABILITY, abb.LONGEST_LINE, abb.NOTES),
    "abb-paint": Dialect(
        abb_paint.TITLE,
        abb_paint.render,
        abb_paint_reader.read,
        abb_paint.CAPABILITY,
        abb_paint.LONGEST_LINE,
        abb_paint.NOTES,
    ),
    "fanuc": Dialect(fanuc.TITLE, fanuc.render, fanuc_reader.read, fanuc.CAPABILITY, fanuc.LONGEST_LINE, fanuc.NOTES),
    "kuka": Dialect(kuka.TITLE, kuka.render, kuka_reader.read, kuka.CAPABILITY, kuka.LONGEST_LINE, kuka.NOTES),
    "linuxcnc": Dialect(
        linuxcnc.TITLE,
        linuxcnc.render,
        linuxcnc_reader.read,
        linuxcnc.CAPABILITY,
        linuxcnc.LONGEST_LINE,
        linuxcnc.NOTES,
        needs_joints=True,
    ),
    "ur": Dialect(ur.TITLE, ur.render, ur_reader.read, ur.CAPABILITY, ur.LONGEST_LINE, ur.NOTES),
    "yaskawa": Dialect(
        yaskawa.TITLE,
        yaskawa.render,
        yaskawa_reader.read,
        yaskawa.CAPABILITY,
        yaskawa.LONGEST_LINE,
        yaskawa.NOTES,
    ),
    "epson": Dialect(epson.TITLE, epson.render, epson_reader.read, epson.CAPABILITY, epson.LONGEST_LINE, epson.NOTES),
    "denso": Dialect(denso.TITLE, denso.render, denso_reader.read, denso.CAPABILITY, denso.LONGEST_LINE, denso.NOTES),
    "melfa": Dialect(melfa.TITLE, melfa.render, melfa_reader.read, melfa.CAPABILITY, melfa.LONGEST_LINE, melfa.NOTES),
    "val3": Dialect(val3.TITLE, val3.render, val3_reader.read, val3.CAPABILITY, val3.LONGEST_LINE, val3.NOTES),
    "joint-table": Dialect(
        joint_table.TITLE,
        joint_table.render,
        joint_table_reader.read,
        joint_table.CAPABILITY,
        joint_table.LONGEST_LINE,
        joint_table.NOTES,
        needs_joints=True,
    ),
}

"""Every language a program can be exported in, by name."""

from collections.abc import Mapping

from programs.posts import joint_table
from programs.posts.dialect import Dialect
from programs.posts.gcode import fanuc_cnc, heidenhain, linuxcnc, sinumerik
from programs.posts.robots import abb, abb_paint, denso, epson, fanuc, kuka, melfa, ur, val3, yaskawa

DIALECTS: Mapping[str, Dialect] = {
    "abb": abb.DIALECT,
    "abb-paint": abb_paint.DIALECT,
    "fanuc": fanuc.DIALECT,
    "kuka": kuka.DIALECT,
    "linuxcnc": linuxcnc.DIALECT,
    "heidenhain": heidenhain.DIALECT,
    "sinumerik": sinumerik.DIALECT,
    "fanuc-cnc": fanuc_cnc.DIALECT,
    "ur": ur.DIALECT,
    "yaskawa": yaskawa.DIALECT,
    "epson": epson.DIALECT,
    "denso": denso.DIALECT,
    "melfa": melfa.DIALECT,
    "val3": val3.DIALECT,
    "joint-table": joint_table.DIALECT,
}

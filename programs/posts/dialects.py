"""Every language a program can be exported in, by name."""

from collections.abc import Mapping

from programs.posts import joint_table
from programs.posts.dialect import Dialect
from programs.posts.gcode import fanuc_cnc, heidenhain, linuxcnc, sinumerik
from programs.posts.robots import denso, epson, fanuc, melfa, ur, yaskawa
from programs.posts.robots.abb import paint as abb_paint
from programs.posts.robots.abb import read as abb
from programs.posts.robots.kuka import read as kuka
from programs.posts.robots.val3 import read as val3

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

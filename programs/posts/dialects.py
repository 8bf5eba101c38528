"""Every language a program can be exported in, by name."""

from collections.abc import Mapping

from programs.posts import (
    abb,
    denso,
    epson,
    fanuc,
    fanuc_cnc,
    heidenhain,
    joint_table,
    kuka,
    linuxcnc,
    melfa,
    sinumerik,
    ur,
    val3,
    yaskawa,
)
from programs.posts.dialect import Dialect

DIALECTS: Mapping[str, Dialect] = {
    "abb": abb.DIALECT,
    "abb-paint": abb.PAINT_DIALECT,
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

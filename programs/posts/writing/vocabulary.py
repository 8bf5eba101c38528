"""Names that each language takes: their form and length, its words, and the names that a program gives by itself."""

import re
from collections.abc import Set as AbstractSet
from dataclasses import dataclass

from programs.errors import ProgramError


@dataclass(frozen=True, slots=True)
class Vocabulary:
    """What is a name in one language. Letters count without regard to their case, as most controllers read them."""

    language: str
    """In messages."""
    longest: int
    """Characters of a name."""
    words: AbstractSet[str] = frozenset()
    """Words of the language, and names that every program has; lower case."""
    numbered: str = "(?!)"
    """Pattern of the names that a program numbers, such as those of its points, in lower case; with one more number
    none of them is such a name."""
    form: str = r"[A-Za-z][A-Za-z0-9_]*"
    """Pattern of a name."""

    def has(self, name: str) -> bool:
        """Whether a name has another meaning in each program."""
        return name.lower() in self.words or re.fullmatch(self.numbered, name.lower()) is not None

    def check(self, place: str, name: str, longest: int = 0) -> str:
        """Give a name that is written as the cell states it, as the controller knows it by that.

        Args:
            place: Its YAML path in the cell.
            name: As it stands there, or as the language spells that.
            longest: Characters, where it may have others than most names.

        Raises:
            ProgramError: the language does not take it, or it has another meaning in each program.
        """
        most = longest or self.longest
        if self.has(name):
            why = "is a word of the language, or a name that every program has"
        elif len(name) > most:
            why = f"has {len(name)} characters, {most} at most are taken"
        elif not re.fullmatch(self.form, name):
            why = "is no name there: a letter first, then letters, digits and underscores"
        else:
            return name
        raise ProgramError(f"{place}: {self.language}: {name} {why}; rename it in the controller and in the cell.")


RAPID = Vocabulary(
    "RAPID",
    32,
    frozenset({
        "main", "define_events", "shut_valves", "on_fault", "stop_job", "nstart", "blate", "stext", "pstart", "jhome",
        "irfault",
        "alias", "and", "backward", "case", "connect", "const", "default", "div", "do", "else",
        "elseif", "endfor", "endfunc", "endif", "endmodule", "endproc", "endrecord", "endtest", "endtrap", "endwhile",
        "error", "exit", "false", "for", "from", "func", "goto", "if", "inout", "local", "mod", "module", "nostepin",
        "not", "noview", "or", "pers", "proc", "raise", "readonly", "record", "retry", "return", "step", "sysmodule",
        "test", "then", "to", "trap", "true", "trynext", "undo", "var", "viewonly", "while", "with", "xor",
        "ainput", "bool", "confj", "confl", "crobt", "cspeedoverride", "fine", "idelete", "ierror", "intnum",
        "isignaldi", "jointtarget", "load0", "moveabsj", "movej", "movel", "num", "paintl", "robtarget", "setao",
        "setbrush", "setdo", "setgo", "speeddata", "stop", "stopmove", "string", "tool0", "tooldata", "tpwrite",
        "triggdata", "triggequip", "triggio", "triggl", "waitdi", "waittime", "waituntil", "wobj0", "wobjdata",
    }),
    r"p\d+|ev\d+|s\d+(p\d+)?(_r\d+(p\d+)?)?|irwatch\d+|nloop\d+|sbrush\d+|[vz]\d+",
)  # fmt: skip
KRL = Vocabulary(
    "KRL",
    24,  # of a module or a variable in KSS 8
    frozenset({
        "main", "home", "tool", "base", "load", "path", "shut_valves", "on_fault", "home_position", "nwait", "xstart",
        "anin", "anout", "and", "axis", "b_and", "b_exor", "b_not", "b_or", "bas", "bool", "brake", "case", "cclose",
        "ccomp", "channel", "char", "circ", "circ_rel", "confirm", "const", "continue", "copen", "cread", "cwrite",
        "decl", "def", "default", "defdat", "deffct", "delay", "digin", "do", "e6axis", "e6pos", "else", "end",
        "enddat", "endfct", "endfor", "endif", "endloop", "endspline", "endswitch", "endwhile", "enum", "exit", "exor",
        "ext", "extfct", "false", "for", "frame", "global", "goto", "halt", "if", "import", "int", "interrupt", "is",
        "lin", "lin_rel", "loop", "maximum", "minimum", "msgnotify", "not", "off", "on", "or", "pos", "prio", "ptp",
        "ptp_rel", "public", "pulse", "real", "repeat", "resume", "return", "scirc", "sec", "signal", "slin", "spl",
        "spline", "sptp", "struc", "switch", "then", "to", "trigger", "true", "until", "wait", "when", "while", "with",
    }),
    r"p\d+|nloop\d+",
)  # fmt: skip
URSCRIPT = Vocabulary(
    "URScript",
    60,
    frozenset({
        "arm", "fire", "settle", "set_out", "watch", "board", "main", "shut_valves", "stop_job", "watch_inputs",
        "await_input", "n_start", "n_wait", "p_start", "run_watch", "run_watch_inputs",
        "and", "break", "continue", "def", "elif", "else", "end", "enter_critical", "exit_critical", "false", "for",
        "global", "halt", "if", "in", "join", "kill", "local", "mod", "not", "or", "return", "run", "sec", "struct",
        "then", "thread", "true", "while", "xor",
        "floor", "get_actual_tcp_pose", "get_standard_analog_in", "get_standard_digital_in", "get_target_tcp_pose",
        "movej", "movel", "point_dist", "popup", "pose_inv", "pose_trans", "set_payload", "set_standard_analog_out",
        "set_standard_digital_out", "set_tcp", "sleep", "sync", "write_output_integer_register",
    }),
    r"ev_[uvwxyz]|ev_way|ev_kind|ev_number|ev_value|ev_armed|ev_done|n_loop_\d+",
)  # fmt: skip
TP = Vocabulary("FANUC", 8, frozenset({"wb_shut", "wb_back"}))
"""Of a program on any controller; 36 characters on newer ones."""
INFORM = Vocabulary("INFORM", 32, frozenset({"shut_valves"}))
SPEL = Vocabulary(
    "SPEL+",
    32,
    frozenset({
        "main", "function", "fend", "tool", "local", "home", "move", "go", "wait", "call", "do", "loop", "start",
        "reset", "shut_valves", "stop_job", "on_fault", "nstart", "accel", "accels", "accelr", "abort", "as", "byte",
        "else", "endif", "error", "exit", "for", "global", "here", "if", "in", "integer", "motor", "next", "off", "on",
        "out", "pause", "power", "preserve", "print", "quit", "real", "return", "select", "send", "speed", "speeds",
        "speedr", "string", "sw", "then", "tlset", "tmr", "tmreset", "to", "trap", "true", "tw", "xqt", "xy",
    }),
    r"nloop\d+|p\d+|main\d+",
)  # fmt: skip
PACSCRIPT = Vocabulary(
    "PacScript",
    32,
    frozenset({
        "main", "sub", "end", "move", "tool", "work", "call", "next", "arrive", "speed", "home", "loop", "set", "reset",
        "shut_valves", "fault", "pstart", "accel", "as", "case", "changetool", "changework", "curpos", "delay", "dim",
        "do", "else", "error", "exit", "extspeed", "for", "function", "givearm", "goto", "halt", "hold", "if",
        "integer", "letz", "position", "posz", "return", "select", "takearm", "then", "to", "wait", "waitmotion",
    }),
    r"nloop\d+|io[bw]?|per_mm_s|per_deg_s",
)  # fmt: skip
MELFA = Vocabulary("MELFA-BASIC", 12, frozenset({"wbshut", "wbwatch"}), form="[A-Za-z][A-Za-z0-9]*")
"""Of a program: capital letters and digits."""
VAL3 = Vocabulary(
    "VAL3",
    15,  # of programs and variables in the oldest controllers in use; assumed
    frozenset({
        "start", "stop", "watch", "pathoutputs", "trigger", "setoutput", "begin", "end", "call", "return", "wait",
        "open", "close", "guard", "shutvalves", "nstart", "nhead", "ntail", "nid", "nmove", "noutput", "nvalue",
        "boverrun", "pstart", "jhome", "jreach", "mreach", "nkey", "flange", "world", "and", "case", "cls", "default",
        "delay", "do", "else", "elseif", "endfor", "endif", "endswitch", "endwhile", "false", "for", "get", "global",
        "here", "if", "local", "mod", "movej", "movel", "not", "or", "popupmsg", "putln", "step", "switch", "then",
        "to", "true", "until", "userpage", "while", "with", "xor",
    }),
    r"(do|go|ao|di|ai)\d+|nloop\d+",
)  # fmt: skip
LINUXCNC = Vocabulary("LinuxCNC", 40, frozenset({"shut_valves"}), "_start|loop\\d+")
KLARTEXT = Vocabulary("HEIDENHAIN", 30, frozenset({"shut_valves"}))
SINUMERIK = Vocabulary(
    "SINUMERIK",
    24,
    frozenset({
        "shut_valves", "and", "axis", "bool", "call", "cancel", "case", "char", "ctol", "ctrans", "def", "default",
        "define", "div", "do", "else", "endfor", "endif", "endloop", "endproc", "endwhile", "every", "extern", "fgroup",
        "for", "frame", "from", "goto", "gotob", "gotof", "id", "ids", "if", "int", "loop", "mod", "not", "of", "or",
        "oriaxes", "orimks", "otol", "proc", "real", "repeat", "ret", "setal", "stopre", "string", "supa", "to",
        "trafoof", "traori", "until", "var", "when", "whenever", "while", "xor",
    }),
    r"wait_\d+|ready_\d+",
)  # fmt: skip
FANUC_CNC = Vocabulary("FANUC CNC", 30)

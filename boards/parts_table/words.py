"""Words of parts tables in the languages of their tools: titles of columns, units, sides, and what is fitted."""

import re
import unicodedata
from functools import lru_cache

from boards.board import Side
from boards.parts_table.columns import Column


def _named(*texts: str) -> tuple[str, ...]:
    return tuple(dict.fromkeys(unaccented(word) for text in texts for word in text.split()))


def unaccented(text: str) -> str:
    """Small letters without accents, wide forms as the usual ones."""
    if text.isascii():
        return text.lower()
    return "".join(each for each in unicodedata.normalize("NFKD", text.lower()) if not unicodedata.combining(each))


_X, _Y = (
    f"pos{a} mid{a} center{a} centre{a} {a}position position{a} {a}coord {a}coordinate coord{a} location{a} {a}loc"
    f" sym{a} {a} ref{a} {a}pos {a}center {a}centre {a}mid {a}location loc{a} placement{a} comp{a} coordinate{a}"
    f" lage{a} mitte{a} {a}koordinate koordinate{a} {a}lage {a}mitte coordonnee{a} coordenada{a} posicion{a}"
    f" coordinata{a} posizione{a} координата{a}"
    f" {a}坐标 坐标{a} 中心{a} 中心点{a} 中心坐标{a} 中心{a}坐标 {a}轴坐标 {a}座標 座標{a}"
    for a in "xy"
)
NAMES: dict[Column, tuple[str, ...]] = {
    "ref": _named(
        "ref refdes refid partid reference references designator designators referencedesignator referencedesignators",
        "refdesignator refdesignators partreference componentreference parts refs",
        "bauteil bauteile bauteilname bauteilbezeichner bezeichner referenz referenzen refbez",
        "repere reperes referencetopologique designateur designador designadores referencia riferimento designatore",
        "位号 元件位号 器件位号 标号 元件标号 参考编号 リファレンス 参照 回路記号 部品記号 обозначение",
    ),
    "package": _named(
        "package footprint symname pattern packagename footprintname pcbfootprint packagereference casesize case",
        "partdecal decal gehause gehaeuse bauform boitier empreinte encapsulado contenitore",
        "封装 封装名称 器件封装 元件封装 パッケージ フットプリント корпус",
    ),
    "value": _named(
        "val value comment designation componentvalue compvalue wert bauteilwert kommentar valeur commentaire valor",
        "valore 值 参数 参数值 注释 規格 规格 値 定数 номинал",
    ),
    "part": _named(
        "mpn partnumber manufacturerpartnumber manufacturerpart mfrpartnumber mfrpn mfgpartnumber mfgpn partno pn part",
        "comppartnumber device artikelnummer herstellernummer herstellerteilenummer referencefabricant",
        "型号 厂家型号 制造商型号 物料型号 型番",
    ),
    "x": _named(_X),
    "y": _named(_Y),
    "rotation": _named(
        "rot rotation symrotate rotate angle orientation theta drehung winkel drehwinkel orientierung rotacion angulo",
        "giro rotazione angolo 旋转 旋转角度 角度 方向 回転 回転角 回転角度 поворот угол",
    ),
    "side": _named(
        "side layer boardside mountside mountingside tb topbottom symmirror mirror mirrored seite bestuckungsseite",
        "bestueckungsseite lage ebene face cote couche cara lado capa lato 层 板层 层面 面 贴装面 安装面 層 実装面",
        "сторона слой",
    ),
    "pins": _named("pins pincount numberofpins padcount pads pinanzahl polzahl 引脚数 管脚数 ピン数"),
    "standoff": _named("standoff standoffheight"),
    "height": _named(
        "height componentheight compheight symheight maxheight bodyheight hohe hoehe bauhohe bauhoehe bauteilhohe",
        "bauteilhoehe hauteur altura altezza 高度 器件高度 元件高度 高さ высота",
    ),
    "fitted": _named(
        "fitted populate populated mount mounted assemble assembled stuff fit populatedstatus fitstatus bestuckt",
        "bestueckt bestucken bestuecken monte montado installed install pop bestuckung bestueckung einbau",
        "贴装 是否贴装 是否焊接 实装 実装",
    ),
    "omitted": _named(
        "dnp dni dnf dns donotpopulate donotplace donotfit donotmount donotstuff notfitted notpopulated nofit",
        "notmounted nopop excluded nichtbestuckt nichtbestueckt nichtbestucken nichtbestuecken nonmonte nomontado",
        "不贴 不焊 未実装",
    ),
    "quantity": _named("quantity qty menge anzahl stuckzahl stueckzahl quantite cantidad quantita 数量 用量 員数"),
    "remark": _named(
        "remark remarks note notes assembly assemblynote variant status placed bomopt bomoption bemerkung bemerkungen",
        "anmerkung hinweis remarque remarques observaciones 备注 備考",
    ),
}
"""Names of columns without blanks, marks, accents and units; the earlier one wins where a table has several."""

KNOWN = frozenset(name for names in NAMES.values() for name in names) | {"padx", "pady"}
PLACE_COLUMNS: tuple[Column, ...] = ("x", "y", "rotation")
MEASURES = frozenset(name for key in PLACE_COLUMNS for name in NAMES[key]) | {"padx", "pady"}

UNITS_MM = {
    **dict.fromkeys(("mm", "millimeter", "millimeters", "millimetre", "millimetres", "毫米"), 1.0),
    **dict.fromkeys(("mil", "mils", "thou"), 0.0254),
    **dict.fromkeys(("in", "inch", "inches", "zoll", '"'), 25.4),
    **dict.fromkeys(("um", "μm", "micron", "microns", "micrometer", "micrometers", "micrometres"), 0.001),
    **dict.fromkeys(("cm", "centimeter", "centimeters"), 10.0),
}
"""By their names as ``unaccented`` gives them."""
UNIT_NAMES = {1.0: "mm", 0.0254: "mil", 25.4: "inch", 0.001: "um"}
"""That are guessed where none is stated, the likeliest first."""
ALL_UNITS = {**UNIT_NAMES, 10.0: "cm"}
_UNIT_WORDS = "|".join(sorted((re.escape(word) for word in UNITS_MM if word != '"'), key=len, reverse=True))
UNIT_LINE = re.compile(
    r"[^\w\r\n]*(?:(?:u?units?(?: used)?|einheit(?:en)?|unites?|unidad(?:es)?|单位|單位|単位)\s*[=:]|x\s*,\s*y\s+in\s)"
    rf"(?:[^\r\n]*?[^a-z\r\n])??({_UNIT_WORDS})\b",
    re.IGNORECASE,
)
UNIT_OF_EXTRACT = re.compile(rf"J!.*!({_UNIT_WORDS})!", re.IGNORECASE)
_DEGREES = frozenset({"deg", "degree", "degrees", "grad", "°"})

YES = frozenset(
    _named(
        "yes y true t 1 x fitted populated mounted placed installed ok fit populate ja j oui o si 是 贴 ○ 有 実装 实装",
    )
)
NO = frozenset(_named("no n false f 0 nein non 否 不 無"))
NOT_FITTED = frozenset(
    _named(
        "dnp dni dnf dns dnm nf ni nofit nopop nostuff donotpopulate donotplace donotfit donotmount donotstuff",
        "donotinstall notfitted notpopulated notmounted notplaced notinstalled notassembled unplaced unpopulated",
        "excluded nichtbestuckt nichtbestueckt nb",
        "nichtbestucken nichtbestuecken nonmonte 不贴 不焊 未実装 未实装",
    )
)
_BESIDE_A_VALUE = frozenset(_named("dnp dni dnf dns dnm nofit nopop nostuff"))
_NO_VALUE = frozenset(_named("nc nm"))
_PHRASES = tuple(sorted(each for each in NOT_FITTED if re.match("(?:do)?not|nicht|non?mon", each)))
"""By which a longer remark is known."""

_TOP = _named(
    "top t front f fcu toplayer toplayertop componentside primary oben oberseite bestuckungsseite dessus superior",
    "arriba c cs bs 顶层 顶面 顶 正面 上 表 表面 部品面 верх",
)
_BOTTOM = _named(
    "bottom b bot m s ss ls back bcu bottomlayer solderside secondary unten unterseite lotseite dessous inferior abajo",
    "底层 底面 底 反面 背面 下 裏 裏面 半田面 низ",
)
SIDES: dict[str, Side] = {
    **dict.fromkeys(_TOP, "top"),
    **dict.fromkeys(_BOTTOM, "bottom"),
}
_MIRRORED: dict[str, Side] = {
    **dict.fromkeys(("no", "n", "false", "normal"), "top"),
    **dict.fromkeys(("yes", "y", "true", "mirrored", "mirror"), "bottom"),
}
_BY_NUMBER: dict[str, Side] = {"0": "top", "1": "bottom", "f": "top", "x": "bottom"}
NO_SIDE = frozenset({"", "tb", "bt", "both", "na"})
"""One line of a bill of materials may stand for parts on both sides."""


@lru_cache(maxsize=4096)
def letters(text: str) -> str:
    """Small letters and digits of a cell, without accents; most cells of a column are alike."""
    return re.sub(r"[\W_]", "", unaccented(text))


def leaves_out(text: str, *, is_value: bool = False) -> bool:
    """Whether a remark states that a part is not fitted, or a value besides what the part would be: ``10k DNP``."""
    plain = letters(text)
    if plain in NOT_FITTED or (is_value and plain in _NO_VALUE):
        return True
    if not _BESIDE_A_VALUE.isdisjoint(re.split(r"[\W_]+", unaccented(text))):
        return True
    return not is_value and any(each in plain for each in _PHRASES)


def unit_in(title: str) -> float | None:
    """Unit in mm of the last word of a title, such as ``X (mm)`` or ``X in mil``."""
    words = re.split(r"[^\w]+|_|(?<=[a-z])(?=[A-Z])", title.strip())[1:]
    hits = [UNITS_MM[word] for word in map(unaccented, words) if word in UNITS_MM]
    return hits[-1] if hits else None


def plain_title(title: str) -> str:
    """Title without brackets and their content, unit, marks, accents and case."""
    bare = re.sub(r"[(\[][^()\[\]]*[)\]]", "", unaccented(title).strip().lstrip("#"))
    words = [word for word in re.split(r"[\W_]+", bare) if word]
    while len(words) > 1 and (words[-1] in UNITS_MM or words[-1] in _DEGREES):
        words = words[:-1]
    return "".join(words)


def unit_of_cell(text: str) -> float | None:
    """Unit in mm of a cell that holds nothing else; 0 for one of angles, ``None`` for another cell."""
    word = unaccented(text).strip("()[] \t")
    return 0.0 if word in _DEGREES else UNITS_MM.get(word)


def side_in(text: str, title: str) -> Side | None:
    """Side that a cell names, by all of it or by one of its words; ``None`` where it names none, or both.

    Args:
        text: The cell.
        title: Plain title of its column, whose cells may state whether the part is mirrored.
    """
    plain = letters(text)
    known: dict[str, Side] = {**SIDES, **_MIRRORED, **(_BY_NUMBER if "mirror" in title else dict[str, Side]())}
    if (whole := known.get(plain) or known.get(plain.strip("0123456789"))) is not None:
        return whole
    words = (word for word in re.split(r"[\W_\d]+", unaccented(text)) if len(word) > 1)
    found: set[Side] = {SIDES[word] for word in words if word in SIDES}
    return next(iter(found)) if len(found) == 1 else None

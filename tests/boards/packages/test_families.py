import re
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.packages.families import header_size, package_families, package_family, package_sizes, pins_of, plan_size
from boards.packages.heights import HeightEvidence, checked_height
from boards.packages.undersides import gap_height

NAMES = [
    # name, family, pins
    ("C_0805_2012Metric", "chip part 0805", 2),
    ("R_1206_3216Metric_Pad1.24x1.80mm_HandSolder", "chip resistor 1206", 2),
    ("1005_C", "chip part 0402", 2),
    ("1006_C", "chip part 0402", 2),
    ("2012_C", "chip part 0805", 2),
    ("R0603", "chip resistor 0603", 2),
    ("SMD_C_2225-R", "chip part 2225", 2),
    ("SMD_R_1206-R", "chip resistor 1206", 2),
    ("R_0201_0603Metric", "chip resistor 0201", 2),
    ("CAPC0603X33N", "chip part 0201", 2),
    ("R_Array_Convex_4x0603", "chip resistor 0603", 8),
    ("LED_1206_3216Metric", "chip part 1206", 2),
    ("SM1206POL", "tantalum A", 2),
    ("CP_EIA-3216-18_Kemet-A", "tantalum A", 2),
    ("CP_Elec_6.3x11_Board_Edge_Mirrored", "SMD aluminium electrolytic", 2),
    ("CP_Radial_D8.0mm_P5.00mm", "radial electrolytic to 8 mm", 2),
    ("R_Axial_DIN0207_L6.3mm_D2.5mm_P10.16mm_Horizontal", "axial resistor", 2),
    ("L_12x12mm_H8mm", "power inductor", 2),
    ("LQFP-48_7x7mm_P0.5mm", "LQFP", 48),
    ("TQFP-144_20x20mm_P0.5mm", "TQFP", 144),
    ("QFP50P900X900X160-48N", "PQFP", 48),
    ("SOIC-8 3.9x4.9", "SOIC", 8),
    ("Package_SO:SOIC-14_3.9x8.7mm_P1.27mm", "SOIC", 14),
    ("SOIC-16W_7.5x10.3mm_P1.27mm", "wide SOIC", 16),
    ("SOIC127P600X175-8N", "SOIC", 8),
    ("8-SOIC", "SOIC", 8),
    ("TSSOP-20", "TSSOP", 20),
    ("MSOP-10", "MSOP", 10),
    ("TSOP-II-54_22.2x10.16mm", "TSOP", 54),
    ("PLCC-44", "PLCC", 44),
    ("QFN-48-1EP_7x7mm", "QFN", 48),
    ("UFQFPN48", "QFN", 48),
    ("WSON-8", "DFN", 8),
    ("LGA-16_3x3mm_P0.5mm", "LGA", 16),
    ("BGA-256_17x17", "BGA", 256),
    ("BGA256C100P16X16_1700X1700X170N", "BGA", 256),
    ("UFBGA-100", "fine-pitch BGA", 100),
    ("WLCSP-36_2.374x2.459mm", "WLCSP", 36),
    ("SOT-23", "SOT-23", 3),
    ("D_SOT-23_ANK", "SOT-23", 3),
    ("SOT-23-5", "SOT-23 with 5 to 8 leads", 5),
    ("SOT26", "SOT-23 with 5 to 8 leads", 6),
    ("SOT-223", "SOT-223", 4),
    ("SOT-223-3_TabPin2", "SOT-223", 3),
    ("SC-70-5", "SOT-353", 5),
    ("TO-263-5_TabPin3", "TO-263", 5),
    ("TO-220-5_Horizontal_TabDown", "TO-220 lying", 5),
    ("TO-220", "TO-220", 3),
    ("TO-92_Molded_Narrow", "TO-92", 3),
    ("D_SMA", "SMA", 2),
    ("SMA_Amphenol_132134", "coaxial connector", None),
    ("D_SOD-123F", "SOD-123", 2),
    ("D_MiniMELF", "MELF", 2),
    ("D_DO-15_P12.70mm_Horizontal", "DO-15", 2),
    ("DIP-8_W7.62mm", "DIP", 8),
    ("Crystal_HC18-U_Horizontal", "lying crystal can", 2),
    ("Crystal_SMD_3225-4Pin_3.2x2.5mm", "SMD crystal", 4),
    ("PinHeader_2x13_P2.54mm_Vertical", "pin header", 26),
    ("PinHeader_1x01_P2.54mm_Vertical", "pin header", 1),
    ("IDC-Header_2x05_P2.54mm_Vertical", "box header", 10),
    ("DSUB-9_Female_Horizontal_P2.77x2.84mm_EdgePinOffset7.70mm_Housed", "D-sub", 9),
    ("DSUB", "D-sub", None),
    ("RJ45_Amphenol_RJHSE5380", "RJ45", 8),
    ("USB_B_Micro", "USB Mini or Micro", 5),
    ("USB_C_Receptacle_HRO_TYPE-C-31-M-12", "USB C", None),
    ("Altech_AK300_1x02_P5.00mm_45-Degree", "terminal block", 2),
    ("JST_XH_B4B-XH-A_1x04_P2.50mm_Vertical", "2 mm wire connector", 4),
    ("JST_SH_SM04B-SRSS-TB_1x04-1MP_P1.00mm_Horizontal", "1 mm wire connector", 4),
    ("Molex_KK-254_1x02_P2.54mm_Horizontal", "wire-to-board connector", 2),
    ("Inductor_Wurth_MAPI-4020", "power inductor", 2),
    ("R_Box_L13.0mm_W4.0mm_P9.00mm", "box resistor", 2),
    ("LED-5mm-PTH-AK", "LED with leads", 2),
    ("Kailh_socket_MX", "hot-swap socket", None),
    ("CherryMX_1.00u_PCB", "keyboard switch", 2),
    ("Texas_X2SON-4_1x1mm_P0.65mm", "DFN", 4),
    ("TestPoint_Loop_D1.80mm_Drill1.0mm_Beaded", "test loop", None),
    ("BatteryHolder_Keystone_1042_1x18650", "holder of round cells", 2),
    ("Potentiometer_Bourns_3296W_Vertical", "potentiometer", 3),
    ("SW_PUSH_6mm", "tactile switch", None),
    ("Relay_SPDT_Omron-G5LE-1", "relay", None),
    ("Jumper", "jumper", None),
    ("SolderJumper-2_P1.3mm_Open", "bare copper", 2),
    ("FSUPCMS", "fuse holder", 2),
]


@pytest.mark.parametrize(("name", "family", "pins"), NAMES)
def test_the_name_tells_family_and_pins(name: str, family: str, pins: int | None) -> None:
    found = package_family(name)
    assert found is not None
    assert (found.name, pins_of(name)) == (family, pins)


def test_what_names_tell_of_sizes_height_and_gap_is_what_was_reviewed(golden: Callable[[str, str], None]) -> None:
    """With a pitch beyond both ends of what there is, and heights that are not believed."""
    odd = ["QFN-16_3x3mm_P0.1mm", "QFN-16_3x3mm_P0.2mm", "PinHeader_1x02_P2.6mm", "PinHeader_1x02_P7.62mm"]
    rows: list[str] = []
    for name in (*(name for name, _, _ in NAMES), *odd):
        told: list[str] = []
        for stated in (None, 0.05, 0.6, 60.0):
            found = checked_height(stated, HeightEvidence(package=name))
            told.append(f"{found.height.height_mm:g} {found.height.reason}{found.doubt and f' ({found.doubt})'}")
        sizes, gap = package_sizes(name), gap_height(name, None)
        rows.append(f"{name}: {'; '.join(dict.fromkeys(told))}")
        rows.append(f"  {sizes.body_mm} {sizes.pitch_mm} {sizes.ball_mm} {sizes.layout} {sizes.pad_mm} {sizes.has_pad}")
        rows.append(f"  {gap.nominal_mm} {gap.source}; {gap.bounds_source}")
    golden("packages.txt", "\n".join(rows) + "\n")


@pytest.mark.parametrize("name", [name for name, _, _ in NAMES])
def test_case_blanks_and_library_prefix_do_not_matter(name: str) -> None:
    for spelling in (name.upper(), name.lower(), f"Some_Library:{name}", name.replace("_", " ")):
        assert package_family(spelling) == package_family(name)
        assert pins_of(spelling) == pins_of(name)


@pytest.mark.parametrize(
    "name",
    [
        "fid_c1.0_sm3.0",
        "Fiducial_1mm_Mask2mm",
        "GLOB_FID_60R140",
        "TestPoint_Pad_D1.0mm",
        "TESTPAD_40-ROUND",
        "MountingHole_3.2mm_M3_Pad_Via",
        "HOLE_M2_TH",
        "GSG-HOLE126MIL-COPPER",
        "Plain_Hole_3mm",
        "VIA-0.4mm",
        "KiCad-Logo2_12mm_SilkScreen",
        "Tag-Connect_TC2030-IDC-NL_2x03_P1.27mm_Vertical",
        "SolderWirePad_single_0-8mmDrill",
        "SODIMM-200_1.8V_Card_edge",
    ],
)
def test_copper_and_print_have_no_body(name: str) -> None:
    family = package_family(name)
    assert family is not None
    assert family.source == "no body"


@pytest.mark.parametrize(
    "name",
    [
        "DSUB-9_Female_Horizontal_P2.77x2.84mm_EdgePinOffset7.70mm_Housed_MountingHolesOffset9.12mm",
        "CP_Elec_6.3x11_Board_Edge_Mirrored",
        "USB_Micro-B_Wuerth_629105150521_CircularHoles",
        "TP5100-Module",
        "SMA_Samtec_SMA-J-P-X-ST-EM1_EdgeMount",
        "FUSE_HOLE_D1.5",
    ],
)
def test_a_body_is_not_taken_for_copper(name: str) -> None:
    family = package_family(name)
    assert family is not None
    assert family.source != "no body"


@pytest.mark.parametrize("name", ["", "xyz", "U$1", "1234", "ASIC", "mosfet", "°", "9" * 5000])
def test_an_unknown_name_is_unknown(name: str) -> None:
    assert package_family(name) is None
    assert pins_of(name) is None


def test_thicker_gaps_under_leads_and_balls_than_under_leadless_parts() -> None:
    gap = {name: package_family(name) for name in ("C_0402", "QFN-48", "LQFP-48", "SOIC-8", "BGA-256", "DIP-8")}
    gaps_mm = [
        family.gap_height_mm for family in gap.values() if family is not None and family.gap_height_mm is not None
    ]
    assert len(gaps_mm) == 6
    assert gaps_mm == sorted(gaps_mm)


def test_a_resistor_is_not_higher_than_a_capacitor_of_its_size() -> None:
    for code in ("0201", "0402", "0603", "0805", "1206", "1210", "2512"):
        resistor, capacitor = package_family(f"R_{code}"), package_family(f"C_{code}")
        assert resistor is not None
        assert capacitor is not None
        assert resistor.height_mm < capacitor.height_mm


def test_every_row_is_of_engineering_size_and_names_its_source() -> None:
    families = package_families()
    assert len(families) > 100
    for family in families:
        assert family.source
        assert 0 < family.height_mm < 65
        assert family.gap_height_mm is None or 0 < family.gap_height_mm < family.height_mm


@pytest.mark.slow
@settings(max_examples=300)
@given(st.text(max_size=60) | st.from_regex(re.compile(r"[A-Z]{1,5}[-_]?\d{1,5}(x\d+)?[-_.A-Z0-9]*"), fullmatch=True))
def test_any_text_is_answered(name: str) -> None:
    family, pins = package_family(name), pins_of(name)
    assert family is not None or pins is None
    assert pins is None or pins >= 0
    assert family is None or 0 < family.height_mm < 100


def test_only_the_beginning_of_a_long_name_is_read() -> None:
    assert package_family("x" * 1000 + "-SOIC-8") is not None
    assert package_family("x" * 2000 + "-SOIC-8") is None


def test_the_documents_table_is_the_programs() -> None:
    document = Path(__file__).parents[3] / "docs" / "boards.md"
    lines = document.read_text(encoding="utf-8").splitlines()
    rows = lines[lines.index("| family | height, mm | standoff, mm | source |") + 2 :]
    expected = [
        f"| {family.name} | {family.height_mm:g} | "
        f"{'–' if family.gap_height_mm is None else format(family.gap_height_mm, 'g')} | {family.source} |"  # noqa: RUF001
        for family in package_families()
    ]
    assert rows == expected
    assert len({family.name for family in package_families()}) == len(expected)


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("SOIC-8_3.9x4.9mm_P1.27mm", (3.9, 4.9)),
        ("Capacitor_THT:CP_Radial_D10.0mm_P5.00mm", (10.0, 10.0)),
        ("CP_Elec_6.3x7.7", (6.6, 6.6)),
        ("R_Axial_DIN0207_L6.3mm_D2.5mm_P10.16mm_Horizontal", (6.3, 2.5)),
        ("R_Axial_DIN0207_L6.3mm_D2.5mm_P2.54mm_Vertical", None),
        ("C_Rect_L7.0mm_W2.5mm_P5.00mm", (7.0, 2.5)),
        ("LED_D5.0mm_Horizontal_O1.27mm_Z3.0mm", None),
        ("L_6.3x6.3_H3", (6.3, 6.3)),
        ("PinHeader_2x05_P2.54mm_Vertical", None),
        ("R_0603_1608Metric", None),
        ("SOT-23", None),
        ("", None),
    ],
)
def test_plan_sizes_are_read_from_names(name: str, size: tuple[float, float] | None) -> None:
    assert plan_size(name) == (None if size is None else pytest.approx(size))


@pytest.mark.parametrize(
    ("name", "size"),
    [
        ("Connector_PinHeader_2.54mm:PinHeader_2x05_P2.54mm_Vertical", (5.08, 12.7)),
        ("PinSocket_20x1_P2.00mm", (2.0, 40.0)),
        ("PinHeader_2x05_P2.54mm_Horizontal", None),
        ("PinHeader_2x05", None),
        ("SOIC-8_3.9x4.9mm_P1.27mm", None),
    ],
)
def test_sizes_of_headers_follow_from_their_pins(name: str, size: tuple[float, float] | None) -> None:
    assert header_size(name) == (None if size is None else pytest.approx(size))

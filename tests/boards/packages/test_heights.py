"""Heights from names: what a name states is taken, and nothing is lower than published packages are."""

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from boards.packages.heights import (
    TALL_FLAT_MM,
    TALL_LEADED_MM,
    HeightEvidence,
    body_height,
    checked_height,
    length_in,
)

STATED = [
    ("CP_Axial_L18.0mm_D6.5mm_P25.00mm_Horizontal", 6.5),
    ("CP_Elec_6.3x11", 11.0),
    ("CP_Elec_8x10.5", 10.5),
    ("CP_EIA-7343-43_Kemet-X", 4.3),
    ("CP_EIA-3216-18_Kemet-A", 1.8),
    ("CAPC2012X140N", 1.4),
    ("SOIC127P600X160-8N", 1.6),
    ("QFN50P700X700X80-49N", 0.8),
    ("BGA256C100P16X16_1700X1700X155N", 1.55),
    ("L_12x12mm_H6.5mm", 6.5),
    ("L_6.3x6.3_H3", 3.0),
    ("CP_Radial_D10.0mm_H20.0mm_P5.00mm", 20.0),
    ("C_Radial_D16.0mm_H35.5mm_P7.50mm", 35.5),
    ("CPOL_RM2.5mm_6.3x11mm", 11.0),
    ("C_Axial_L5.1mm_D3.1mm_P12.50mm_Horizontal", 3.1),
    ("R_Axial_DIN0918_L18.0mm_D9.0mm_P22.86mm_Horizontal", 9.0),
    ("R_Axial_DIN0207_L6.3mm_D2.5mm_P10.16mm_Horizontal", 2.5),
    ("R_Axial_DIN0207_L6.3mm_D2.5mm_P2.54mm_Vertical", 9.8),
    ("L_Axial_L5.3mm_D2.2mm_P2.54mm_Vertical_Vishay_IM-1", 8.8),
    ("R_Axial_Power_L20.0mm_W6.4mm_P22.40mm", 7.9),
    ("Crystal_AT310_D3.0mm_L10.0mm_Horizontal", 3.0),
    ("Crystal_AT310_D3.0mm_L10.0mm_Vertical", 13.5),
    ("SSOP-8_3.95x5.21x3.27mm_P1.27mm", 3.27),
    ("BGA-121_12.0x12.0x1.4mm_Layout11x11_P1.0mm", 1.4),
    ("Filter_5.0 x 3.2 x 1.1 mm", 1.1),
    ("Filter_7,3x4,3x2,8mm", 2.8),
    ("SW_PUSH_6mm_H4.3mm", 4.3),
    ("Buzzer_12x9.5RM7.6", 9.5),
    ("L_Toroid_Vertical_L28.6mm_W14.3mm_P11.43mm", 30.6),
    ("LED_D5.0mm_Horizontal_O1.27mm_Z15.0mm", 21.0),
    ("0207/10", 2.7),
    ("0309/2V", 12.5),
]

NOT_STATED = [
    # A name whose numbers are something else, its family, the family's height.
    ("LQFP-48_7x7mm_P0.5mm", "LQFP", 1.6),
    ("LQFP-48_7x7x1.4mm_P0.5mm", "LQFP", 1.6),
    ("QFN-32-1EP_5x5mm_P0.5mm_EP2.3x2.3mm_ThermalVias", "QFN", 1.0),
    ("QFN-32-1EP_5x5x0.9mm_P0.5mm_EP2.3x2.3mm", "QFN", 1.0),
    ("R_1206_3216Metric_Pad1.24x1.80mm_HandSolder", "chip resistor 1206", 0.7),
    ("PinHeader_1x02_P2.54mm_Vertical", "pin header", 9.0),
    ("LED_Rectangular_W5.0mm_H2.0mm", "LED with leads", 20.0),
    ("DSUB-9_Female_Horizontal_P2.77x2.84mm_EdgePinOffset7.70mm_Housed", "D-sub", 12.6),
]

PUBLISHED = [
    # Name, and the largest seated height of that package in its published outline or in its makers' ranges.
    ("D_DO-35_SOD27_P7.62mm_Horizontal", 2.41),
    ("D_DO-41_SOD81_P10.16mm_Horizontal", 3.22),
    ("D_DO-15_P12.70mm_Horizontal", 4.11),
    ("D_DO-201AD_P15.24mm_Horizontal", 5.8),
    ("D_P600_R-6_P20.00mm_Horizontal", 9.6),
    ("D_DO-35_SOD27_P2.54mm_Vertical_AnodeUp", 6.0),
    ("CP_Radial_D8.0mm_P3.50mm", 21.5),
    ("CP_Radial_D10.0mm_P5.00mm", 33.0),
    ("CP_Radial_Tantal_D6.0mm_P5.00mm", 12.0),
    ("C_Disc_D5.1mm_W3.2mm_P5.00mm", 8.1),
    ("C_Rect_L18.0mm_W11.0mm_P15.00mm_FKS3_FKP3", 21.0),
    ("Crystal_HC49-U_Vertical", 13.46),
    ("Crystal_HC49-U_Horizontal", 4.7),
    ("Crystal_HC49-4H_Vertical", 4.5),
    ("PinHeader_2x05_P2.54mm_Horizontal", 5.08),
    ("PinSocket_1x06_P2.54mm_Vertical", 8.6),
    ("DIP_Socket-40_W11.9_W12.7_W15.24_3M_240-1280-00-0602J", 13.0),
    ("ZIF_Socket_DIP40", 13.0),
    ("DIP-40_W15.24mm", 6.35),
    ("DIP-40_W15.24mm_Socket", 10.5),
    ("TerminalBlock_Phoenix_MKDS-1,5-2-5.08_1x02_P5.08mm_Horizontal", 13.8),
    ("TerminalBlock_Phoenix_MKDS-5-2-9.5_1x02_P9.50mm_Horizontal", 26.5),
    ("Relay_DPDT_Finder_40.52", 25.0),
    ("DSUB-9_Male_Vertical_P2.77x2.84mm", 17.0),
    ("RJ45_Amphenol_RJHSE5380", 13.4),
    ("USB_A_Molex_67643_Horizontal", 7.2),
    ("USB_B_OST_USB-B1HSxx_Horizontal", 11.2),
    ("TO-220-3_Vertical", 22.9),
    ("TO-220-3_Horizontal_TabDown", 4.83),
    ("TO-247-3_Vertical", 25.5),
    ("TO-92_Inline", 8.0),
    ("PQFP-160_28x28mm_P0.65mm", 4.1),
    ("BGA-484_23x23mm_P1.0mm", 2.6),
    ("LGA-144_15x15mm", 4.4),
    ("SOIC-8_5.23x5.23mm_P1.27mm", 2.16),
    ("SO20", 2.65),
    ("CD75", 5.0),
    ("HSOP-20-1EP_11.0x15.9mm_P1.27mm_SlugDown", 3.6),
    ("SSOP-48_7.5x15.9mm_P0.635mm", 2.79),
    ("SO-4_4.4x3.6mm_P2.54mm", 2.4),
    ("Analog_BGA-28_4.0x6.25mm", 5.0),
    ("Heatsink_X_TO-263", 50.0),
    ("SMA_Molex_73251-1153_EdgeMount_Horizontal", 9.6),
    ("CP_EIA-7361-438_AVX-U", 4.38),
    ("DIN41612_B2_2x16_Male_Horizontal_THT", 12.0),
    ("Resonator-2Pin_W10.0mm_H5.0mm", 10.0),
    ("LED_D1.8mm_W1.8mm_H2.4mm_Horizontal_O1.27mm_Z1.6mm", 3.4),
    ("R_Radial_Power_L11.0mm_W7.0mm_P5.00mm", 25.0),
    ("RotaryEncoder_Alps_EC11E-Switch_Vertical_H20mm", 26.5),
    ("Oscillator_DIP-14", 5.6),
    ("Oscillator_OCXO_Morion_MV267", 25.0),
    ("Relay_StandexMeder_DIP_HighProfile", 12.0),
    ("BatteryHolder_Bulgin_BX0036_1xC", 29.0),
    ("BatteryHolder_Keystone_1060_1x2032", 5.2),
    ("Fuseholder_Cylinder-5x20mm_Bulgin_FX0456_Vertical_Closed", 40.0),
    ("Crystal_SMD_SeikoEpson_MA506-4Pin_12.7x5.1mm", 4.6),
    ("CF-Card_3M_N7E50", 5.6),
    ("NR8040", 4.2),
    ("E3,5-8", 21.5),
    ("DIL28-6", 6.35),
    ("TO220BV", 22.9),
]


@pytest.mark.parametrize(("name", "height_mm"), STATED)
def test_a_height_in_the_name_comes_first(name: str, height_mm: float) -> None:
    for spelling in (name, name.lower(), f"Some_Library:{name}"):
        found = body_height(HeightEvidence(spelling))
        assert (found.height_mm, found.source) == (pytest.approx(height_mm), "name")
        assert found.reason.startswith("name states ")


@pytest.mark.parametrize(("stated_mm", "read"), [(0.05, False), (0.1, True), (100.0, True), (100.1, False)])
def test_what_no_body_is_as_high_as_is_no_height(stated_mm: float, read: bool) -> None:
    assert (body_height(HeightEvidence(f"L_12x12mm_H{stated_mm}mm")).source == "name") is read


def test_the_reason_cites_the_name() -> None:
    assert body_height(HeightEvidence(STATED[0][0])).reason == "name states D6.5mm"
    assert body_height(HeightEvidence("SOT-23")).reason.startswith("family SOT-23 (JEDEC ")


@pytest.mark.parametrize(("name", "family", "height_mm"), NOT_STATED)
def test_pitches_pads_and_rows_are_no_heights(name: str, family: str, height_mm: float) -> None:
    found = body_height(HeightEvidence(name))
    assert found.height_mm == height_mm
    assert family in found.reason


@pytest.mark.parametrize(("name", "published_mm"), PUBLISHED)
def test_no_height_is_below_the_published_one(name: str, published_mm: float) -> None:
    found = body_height(HeightEvidence(name))
    assert found.source != "assumed"
    assert published_mm <= found.height_mm <= 2.3 * published_mm


def test_a_model_counts_where_the_name_says_less() -> None:
    cans = ("a/CP_Radial_D10.0mm_H16.0mm_P5.00mm.step",)
    stated = body_height(HeightEvidence("CP_Radial_D10.0mm_P5.00mm", models=cans))
    assert (stated.height_mm, stated.source) == (16.0, "model")
    named = body_height(HeightEvidence("Gizmo", models=("${KIPRJMOD}\\SOIC-8_3.9x4.9mm_P1.27mm.wrl",)))
    assert (named.height_mm, named.source) == (1.75, "model")


def test_a_model_of_another_family_does_not_count() -> None:
    found = body_height(HeightEvidence("DO-214AB", models=("L_12x12mm_H0.5mm.wrl",)))
    assert (found.height_mm, found.source) == (2.65, "family")


@pytest.mark.parametrize(
    ("description", "height_mm"),
    [
        ("Body Size: 2.1 x 2.4 x .9 mm", 1.15),
        ("<b>Push button</b>, height=4.3mm", 4.3),
        ("Area: 3.0mm x 2.5mm, pitch 0.5 mm", TALL_LEADED_MM),
    ],
)
def test_a_description_counts_last(description: str, height_mm: float) -> None:
    assert body_height(HeightEvidence("Gizmo", description=description)).height_mm == pytest.approx(height_mm)
    assert body_height(HeightEvidence("SOT-23", description=description)).source == "family"


def test_what_is_unknown_is_assumed_tall() -> None:
    def tall(through_hole: bool, length_mm: float) -> float:
        found = body_height(HeightEvidence("Gizmo", through_hole=through_hole, length_mm=length_mm))
        assert found.source == "assumed"
        return found.height_mm

    assert tall(True, 5.0) == tall(True, 0.0) == TALL_LEADED_MM
    assert tall(False, 0.0) == tall(False, 50.0) == TALL_FLAT_MM
    assert tall(False, 3.0) == 6.0
    assert tall(False, 0.5) == 2.0


def test_a_word_alone_is_bounded_by_the_size_of_what_is_soldered_flat() -> None:
    assert body_height(HeightEvidence("C_Gizmo")).height_mm > TALL_LEADED_MM
    assert body_height(HeightEvidence("C_Gizmo", through_hole=False, length_mm=3.0)).height_mm == 6.0
    assert body_height(HeightEvidence("C_Gizmo", through_hole=False, length_mm=0.9)).height_mm == 2.0


def test_a_word_alone_is_tall_with_leads() -> None:
    for name in ("LED_Gizmo", "D_Gizmo", "C_Gizmo"):
        assert body_height(HeightEvidence(name, through_hole=True, length_mm=3.0)).height_mm >= TALL_LEADED_MM


@pytest.mark.parametrize(
    ("name", "stated_mm", "height_mm", "doubt"),
    [
        ("SOIC-8", 1.5, 1.5, ""),
        ("SOIC-8", 4.0, 4.0, ""),
        ("SOIC-8", 6.0, 1.75, "6 mm stated, 1.75 mm taken: family SOIC (JEDEC MS-012)"),
        ("SOIC-8", 0.0254, 1.75, "0.0254 mm stated, 1.75 mm taken: family SOIC (JEDEC MS-012)"),
        ("TO-220-3_Vertical", 25.4, 23.0, "25.4 mm stated, 23 mm taken: family TO-220 "),
        ("Heatsink_X", 25.4, 25.4, ""),
        ("L_12x12mm_H4.5mm", 1.0, 4.5, "1 mm stated, 4.5 mm taken: name states H4.5mm"),
        ("Gizmo", 7.0, 7.0, ""),
        ("Gizmo", 50.8, 50.8, "50.8 mm stated, a layout tool's default, kept"),
        ("Gizmo", 0.01, TALL_LEADED_MM, "0.01 mm stated, 25 mm taken: assumed tall"),
        ("SOIC-8", None, 1.75, ""),
    ],
)
def test_a_stated_height_is_believed_if_it_may_be_true(
    name: str, stated_mm: float | None, height_mm: float, doubt: str
) -> None:
    checked = checked_height(stated_mm, HeightEvidence(name))
    assert checked.height.height_mm == height_mm
    assert checked.doubt.startswith(doubt)
    assert bool(checked.doubt) == bool(doubt)


@pytest.mark.parametrize(
    ("text", "length_mm"),
    [
        ("4.5", 4.5),
        ("4,5 mm", 4.5),
        (".9MM", 0.9),
        ("100 mil", 2.54),
        ('0.1"', 2.54),
        ("0", None),
        ("1.75 max", None),
        ("-1", None),
        ("1e9", None),
        ("99999", None),
        ("", None),
    ],
)
def test_lengths_are_read_with_their_units(text: str, length_mm: float | None) -> None:
    assert length_in(text) == pytest.approx(length_mm)


def test_a_chip_carrier_with_leads_through_the_board_is_in_a_socket() -> None:
    flat = body_height(HeightEvidence("PLCC84", through_hole=False, length_mm=30.0))
    assert flat.height_mm == 4.57
    assert body_height(HeightEvidence("PLCC84", through_hole=True, length_mm=30.0)).height_mm == 9.5


def test_only_a_resistor_is_as_flat_as_one() -> None:
    references = ("R7", "RN1", "", "C7", "FB1")
    heights = [body_height(HeightEvidence("R_1210", reference)).height_mm for reference in references]
    assert heights == [0.7, 0.7, 0.7, 2.8, 2.8]


@settings(max_examples=200)
@given(st.text(max_size=80), st.text(max_size=80))
def test_any_text_has_a_height_within_reason(name: str, description: str) -> None:
    found = body_height(HeightEvidence(name, models=(description,), description=description))
    assert 0.0 < found.height_mm <= 101.0
    assert found.reason

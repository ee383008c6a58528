"""The materials that ballesta knows, and what a design's own must state."""

from pathlib import Path

import pytest
from numpy.testing import assert_allclose
from pydantic import ValidationError

from ballesta.design.read import read_design
from checks.design.errors import DesignError
from checks.design.materials import Material, MaterialEntry, known_materials
from fatigue import FKM_GROUPS, FkmMaterial, component_limit, endurance_limit
from geometry.bars import RulingSection
from geometry.parameters import ParameterError

PRESS = Path(__file__).parents[3] / "designs" / "toggle_press.toml"
ALLOY = {
    "name": "alloy",
    "youngs_modulus": 70e3,
    "poisson_ratio": 0.33,
    "density": 2.7e-9,
    "yield_stress": 240.0,
    "ultimate_stress": 290.0,
    "ductile": True,
    "source": "a test",
}


def test_what_is_not_steel_must_state_its_endurance_ratio():
    with pytest.raises(ParameterError, match="70 GPa is not steel's"):
        Material(**ALLOY)
    assert Material(**ALLOY, endurance_ratio=0.4).endurance_ratio == 0.4
    assert Material(**{**ALLOY, "youngs_modulus": 210e3}).endurance_ratio is None


@pytest.mark.parametrize("ratio", [0.0, 1.0, -0.4, float("nan")])
def test_an_endurance_ratio_is_a_share_of_the_strength(ratio):
    with pytest.raises(ParameterError, match="between 0 and 1"):
        Material(**ALLOY, endurance_ratio=ratio)


@pytest.mark.parametrize(
    ("name", "yields", "breaks", "standard"),
    [
        ("S275", 275.0, 410.0, "EN 10025-2"),
        ("S355", 355.0, 470.0, "EN 10025-2"),
        ("C45", 305.0, 580.0, "EN 10083-2"),
        ("42CrMo4", 650.0, 900.0, "EN ISO 683-2"),
        ("51CrV4", 1200.0, 1350.0, "EN 10089"),
        ("51CrV4_QT", 800.0, 1000.0, "EN ISO 683-2"),
        ("6082-T6", 240.0, 295.0, "EN 485-2"),
        ("S460N", 460.0, 540.0, "EN 10025-3"),
        ("E335", 335.0, 570.0, "EN 10025-2"),
        ("25CrMo4", 600.0, 800.0, "EN 10083-3"),
        ("30CrNiMo8", 1050.0, 1250.0, "EN 10083-3"),
        ("33CrMoV12-9", 950.0, 1050.0, "EN 10085"),
        ("16MnCr5", 490.0, 740.0, "UNI 7846"),
        ("55Cr3", 1200.0, 1400.0, "Saarstahl"),
        ("X5CrNi18-10", 190.0, 500.0, "EN 10088-3"),
        ("X20Cr13_QT800", 600.0, 800.0, "EN 10088-3"),
        ("GE240", 230.0, 450.0, "DIN 1681"),
        ("EN-GJS-500-7", 320.0, 500.0, "EN 1563"),
        ("5083-O", 105.0, 255.0, "EN 485-2"),
        ("7075-T651", 460.0, 530.0, "EN 485-2"),
        ("AlSi7Mg0.3_T64", 140.0, 220.0, "EN AC-42100"),
        ("CuSn7Zn2Pb3", 130.0, 230.0, "EN 1982"),
    ],
)
def test_metals_have_the_minima_of_their_standard(name, yields, breaks, standard):
    metal = known_materials()[name]
    assert (metal.yield_stress, metal.ultimate_stress) == (yields, breaks)
    assert standard in metal.source
    assert "mm" in metal.source or "test pieces" in metal.source
    assert metal.why_not_goodman is None


METALS = [m for m in known_materials().values() if m.ductile]
PLAIN = {"steel", "case_hardened_steel"}  # half the strength, Shigley


@pytest.mark.parametrize("metal", METALS, ids=lambda m: m.name)
def test_every_known_metal_can_go_through_its_chains(metal):
    for grade in metal.grades:
        ultimate = grade.ultimate_stress
        specimen = metal.endurance_ratio and metal.endurance_ratio * ultimate
        limits = [endurance_limit(ultimate, "machined", specimen_limit=specimen).value]
        if metal.fkm_group:  # bronze has none
            own = FkmMaterial(ultimate, metal.fkm_group)
            limits.append(float(component_limit(own, roughness=10.0).limit))
        for limit in limits:
            assert 0.2 * ultimate < limit < 0.5 * ultimate


def test_the_shop_has_a_material_of_each_kind():
    assert len(METALS) == 45
    assert {m.fkm_group for m in METALS} == {
        *PLAIN, "stainless_steel", "cast_steel", "nodular_iron", "wrought_aluminium",
        "cast_aluminium", None,
    }  # fmt: skip


@pytest.mark.parametrize(
    "metal", [m for m in METALS if m.endurance_cycles == 1e6 and m.fkm_group], ids=lambda m: m.name
)
def test_a_ratio_of_the_guideline_is_no_more_than_it_allows(metal):
    """f_W at 1e6 cycles; what has no limit endures (1e6/1e8)^(1/15) of it."""
    group = FKM_GROUPS[metal.fkm_group]
    most = group.strength_ratio * (1 if group.endures else 0.01 ** (1 / 15))
    assert 0.98 * most < metal.endurance_ratio <= most


def test_only_plain_steel_has_half_its_strength():
    for metal in METALS:
        assert (metal.endurance_ratio is None) is (metal.fkm_group in PLAIN)


@pytest.mark.parametrize(
    "name", ["GE300", "EN-GJS-400-18", "EN-GJS-500-7", "CuSn7Zn2Pb3", "AlSi7Mg0.3_T64"]
)
def test_a_thick_casting_is_refused(name):
    """Their sources state no wall thickness; test pieces are thin."""
    casting = known_materials()[name]
    limit = 20 if name.startswith("Al") else 30
    assert casting.of(flat(limit) + bar(limit)) is casting
    with pytest.raises(ParameterError, match="state a material of your own"):
        casting.of(flat(limit + 1))


def test_alumina_is_brittle_and_says_why_goodman_cannot_judge_it():
    alumina = known_materials()["alumina"]
    assert not alumina.ductile
    assert alumina.endurance_ratio is None
    assert "alumina is brittle: it breaks from its largest flaw" in alumina.why_not_goodman


def test_a_part_of_alumina_is_refused(tmp_path):
    text = PRESS.read_text()
    assert text.count('material = "42CrMo4"\n') == 1
    design = tmp_path / "ceramic.toml"
    design.write_text(text.replace('material = "42CrMo4"\n', 'material = "alumina"\n'))
    with pytest.raises(DesignError, match=r"alumina is brittle: it breaks .*; only ductile metals"):
        read_design(design)


def test_a_material_says_to_which_group_of_the_guideline_it_belongs():
    alloy = Material(**ALLOY, endurance_ratio=0.4, fkm_group="wrought_aluminium")
    assert alloy.fkm_group == "wrought_aluminium"
    with pytest.raises(ParameterError, match=r"must be one of steel, .* got 'alloy'"):
        Material(**ALLOY, endurance_ratio=0.4, fkm_group="alloy")


def test_cycles_belong_to_an_endurance_ratio():
    stated = {
        "youngs_modulus": "169 GPa",
        "poisson_ratio": 0.28,
        "density": "7100 kg/m3",
        "yield_stress": "250 MPa",
        "ultimate_stress": "400 MPa",
    }
    iron = MaterialEntry.model_validate({**stated, "endurance_ratio": 0.34})
    assert iron.named("iron").endurance_cycles == 5e8
    known = MaterialEntry.model_validate({**iron.model_dump(), **stated, "endurance_cycles": 1e6})
    assert known.named("iron").endurance_cycles == 1e6
    alone = MaterialEntry.model_validate({**stated, "endurance_cycles": 1e6})
    with pytest.raises(ParameterError, match="must be stated where endurance_cycles are"):
        alone.named("iron")
    for cycles in (0.0, 1e4, 1e11):
        with pytest.raises(ParameterError, match=r"between 100000 and 1e\+10"):
            Material(**ALLOY, endurance_ratio=0.4, endurance_cycles=cycles)


def test_a_threshold_is_a_stress_intensity_of_some_metal():
    """1 MPa m^0.5 is 31.62 MPa mm^0.5."""
    entry = MaterialEntry.model_validate(
        {
            "youngs_modulus": "210 GPa",
            "poisson_ratio": 0.3,
            "density": "7850 kg/m3",
            "yield_stress": "355 MPa",
            "ultimate_stress": "490 MPa",
            "threshold": "6.5 MPa m^0.5",
        }
    )
    assert_allclose(entry.named("own").threshold, 6.5 * 1000**0.5, rtol=1e-12)
    with pytest.raises(ValidationError, match=r"must be a stress intensity such as"):
        MaterialEntry.model_validate({**entry.model_dump(), "threshold": "6.5 MPa"})
    with pytest.raises(ParameterError, match=r"between 0\.1 and 100 MPa m\^0\.5"):
        Material(**ALLOY, endurance_ratio=0.4, threshold=200 * 1000**0.5)


def flat(size):
    return [RulingSection(size)]


def bar(size):
    return [RulingSection(size, round=True)]


@pytest.mark.parametrize(
    ("name", "sections", "yield_stress", "ultimate_stress"),
    [
        ("S355", flat(16), 355, 470),
        ("S355", flat(16.1), 345, 470),
        ("S355", flat(250), 275, 450),
        ("S275", bar(30), 265, 410),
        ("S235", flat(150), 195, 350),
        ("C45", flat(140), 275, 560),
        ("C60_QT", bar(40), 520, 800),
        ("C60_QT", flat(40), 450, 750),  # a flat cools as a bar of twice its thickness
        ("42CrMo4", bar(8), 650, 900),  # smaller than the first range: it may be cut from a larger
        ("42CrMo4", bar(110), 550, 800),
        ("42CrMo4", flat(110), 500, 750),
        ("42CrMo4", bar(100 * (1 + 1e-12)), 650, 900),  # round-off of a unit
        ("42CrMo4", flat(61) + bar(170) + flat(5), 500, 750),  # the weakest of its sections
        ("51CrV4", bar(5000), 1200, 1350),  # no size is stated
        ("51CrV4_QT", bar(170), 600, 800),
        ("S420N", flat(70), 370, 520),
        ("E360", flat(20), 355, 670),
        ("25CrMo4", flat(50), 450, 700),
        ("30CrNiMo8", bar(120), 800, 1000),
        ("33CrMoV12-9", flat(50), 850, 1050),  # as a bar of 100 mm
        ("31CrMo12", flat(50), 785, 980),  # sizes are smaller sides
        ("16MnCr5", bar(40), 440, 620),
    ],
)
def test_strengths_are_those_of_the_size(name, sections, yield_stress, ultimate_stress):
    found = known_materials()[name].of(sections)
    assert (found.yield_stress, found.ultimate_stress) == (yield_stress, ultimate_stress)
    assert found.of(sections) == found


def test_a_larger_size_is_in_name_and_source():
    found = known_materials()["42CrMo4"].of(bar(110))
    assert found.name == "42CrMo4 above 100 mm"
    assert found.source.endswith("; above 100 up to 160 mm")


def test_a_size_beyond_all_that_are_known_is_refused():
    with pytest.raises(ParameterError, match=r"up to 160 mm of thickness and 250 mm of diameter"):
        known_materials()["42CrMo4"].of(bar(251))


@pytest.mark.parametrize(
    ("larger", "words"),
    [
        ([{"up_to": "10 mm", "yield_stress": "1 MPa", "ultimate_stress": "2 MPa"}], "must grow"),
        ([{"up_to": "90 mm", "yield_stress": "3 MPa", "ultimate_stress": "2 MPa"}], "yield stress"),
    ],
)
def test_strengths_by_size_that_cannot_be_meant_are_refused(larger, words):
    entry = MaterialEntry.model_validate(
        {
            "youngs_modulus": "210 GPa",
            "poisson_ratio": 0.3,
            "density": "7850 kg/m3",
            "yield_stress": "355 MPa",
            "ultimate_stress": "470 MPa",
            "up_to": "16 mm",
            "larger": larger,
        }
    )
    with pytest.raises(ParameterError, match=words):
        entry.named("steel")

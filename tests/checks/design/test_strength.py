"""The chain of strength in a design file: what is read, taken by default, and refused where."""

# ruff: noqa: E501 - one refusal a line: the text, then the wording

import pickle
import tomllib
from dataclasses import replace
from pathlib import Path

import jsonschema
import pytest

from ballesta.design.authoring import design_schema
from ballesta.design.read import read_design
from ballesta.pipeline import _assumed_here
from checks.design.errors import DesignError, DesignErrors
from checks.design.strength import ROUGHNESS, FkmStrength
from fatigue import FKM_GROUPS, FkmMaterial

from ...geometry.step_files import link_file
from ...small_machine import PLATE, machine

FKM = PLATE + 'strength = "fkm"\n'
HAMMER = Path(__file__).parents[3] / "designs" / "spring_hammer.toml"
OWN = """
[materials.alloy]
youngs_modulus = "70 GPa"
poisson_ratio = 0.33
density = "2700 kg/m3"
yield_stress = "240 MPa"
ultimate_stress = "ULTIMATE MPa"
endurance_ratio = 0.4
"""


def of_alloy(group="", ultimate=290):
    own = OWN.replace("ULTIMATE", str(ultimate))
    own += f'fkm_group = "{group}"\n' if group else ""
    return own + FKM.replace("S275", "alloy")


def test_a_part_goes_through_marin_s_chain_unless_it_says_otherwise(tmp_path):
    design = machine(tmp_path)
    assert design.parts["rod"].fkm is None
    assert dict(design.defaults_used)["parts.rod.strength"] == "marin"
    assert "parts.rod.roughness" not in dict(design.defaults_used)


def test_fkm_takes_group_and_strength_of_the_material_and_the_roughness_that_is_stated(tmp_path):
    design = machine(tmp_path, FKM + 'roughness = "16 um"\n')
    own = design.parts["rod"].fkm
    assert own.material == FkmMaterial(410.0, "steel")
    assert own.roughness == pytest.approx(16.0, rel=1e-12)
    assert "parts.rod.roughness" not in dict(design.defaults_used)
    assert pickle.loads(pickle.dumps(design)) == design


@pytest.mark.parametrize("written", ["25 um", "25 µm", "25 μm", "0.025 mm", "2.5e-5 m"])
def test_a_roughness_may_be_written_in_any_length(tmp_path, written):
    own = machine(tmp_path, FKM + f'roughness = "{written}"\n').parts["rod"].fkm
    assert own.roughness == pytest.approx(25.0, rel=1e-12)


def test_the_guideline_s_skin_of_200_um_may_be_stated(tmp_path):
    own = machine(tmp_path, FKM + 'roughness = "200 um"\n').parts["rod"].fkm
    assert own.roughness == pytest.approx(200.0, rel=1e-12)


@pytest.mark.parametrize("surface", ROUGHNESS)
def test_without_a_roughness_that_of_the_surface_is_taken_and_told(tmp_path, surface):
    design = machine(tmp_path, FKM + f'surface = "{surface}"\n')
    assert design.parts["rod"].fkm.roughness == pytest.approx(ROUGHNESS[surface], rel=1e-12)
    told = f"{ROUGHNESS[surface]:g} um, {surface}"
    assert dict(design.defaults_used)["parts.rod.roughness"] == told


def test_a_rougher_surface_never_has_the_smaller_default():
    rising = [ROUGHNESS[s] for s in ("ground", "machined", "cold_drawn", "hot_rolled", "as_forged")]
    assert rising == sorted(rising)
    assert rising[-1] == 200.0


def test_the_reliability_of_marin_s_chain_is_no_default_of_a_part_that_fkm_judges(tmp_path):
    assert dict(machine(tmp_path).defaults_used)["parts.rod.reliability"] == "99 %"
    assert "parts.rod.reliability" not in dict(machine(tmp_path, FKM).defaults_used)


def test_an_override_changes_the_chain(tmp_path):
    design = machine(tmp_path, PLATE, "parts.rod.strength=fkm", "parts.rod.roughness=6.3 um")
    assert design.parts["rod"].fkm.roughness == pytest.approx(6.3, rel=1e-12)
    assert machine(tmp_path, FKM, "parts.rod.strength=marin").parts["rod"].fkm is None


REFUSED = {
    "unknown chain": (FKM.replace('"fkm"', '"fmk"'), r"machine\.toml: parts\.rod\.strength: must be 'marin' or 'fkm', got \"fmk\", did you mean fkm\?"),
    "no unit": (FKM + "roughness = 25\n", r'parts\.rod\.roughness: must be a roughness Rz such as "25 um", got 25 without a unit'),
    "a mass": (FKM + 'roughness = "25 kg"\n', r'must be a roughness Rz such as "25 um", got "25 kg", which is a mass'),
    "not above 0": (FKM + 'roughness = "0 um"\n', r'parts\.rod\.roughness: must be above 0 um, got "0 um"'),
    "millimetres": (FKM + 'roughness = "25 mm"\n', r'parts\.rod\.roughness: must be at most 0\.2 mm, got "25 mm"'),
    "roughness with Marin": (PLATE + 'roughness = "25 um"\n', r"parts\.rod\.roughness: is read by FKM's chain only; state strength = \"fkm\""),
    "reliability with FKM": (FKM + 'reliability = "99.9 %"\n', r"parts\.rod\.reliability: belongs to Marin's chain, not to \"fkm\": FKM's strengths hold for 97\.5 % survival"),
    "default reliability stated": (FKM + 'reliability = "99 %"\n', r"parts\.rod\.reliability: belongs to Marin's chain"),
    "no group": (of_alloy(), r'parts\.rod\.strength: must be "marin" for alloy, got "fkm": the material has no fkm_group; state materials\.alloy\.fkm_group, one of steel, .*wrought_aluminium'),
    "unknown group": (of_alloy("steal"), r"materials\.alloy\.fkm_group: must be one of steel"),
    "not von Mises": (of_alloy("nodular_iron"), r"parts\.rod\.strength: alloy cannot go through FKM's chain: the group 'nodular_iron' is not judged by von Mises alone: its strength in shear is 0\.65 of that in tension"),
    "too strong": (of_alloy("wrought_aluminium", 1200), r"parts\.rod\.strength: alloy cannot go through FKM's chain: 1200 MPa is too much"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_what_does_not_go_with_the_chain_is_refused_at_its_key(case, tmp_path):
    text, message = REFUSED[case]
    with pytest.raises(DesignError, match=message):
        machine(tmp_path, text)


def test_the_factor_of_fretting_at_a_clamp_is_marin_s_alone():
    name = next(n for n, p in read_design(HAMMER).parts.items() if p.shape == "leaf_pack")
    message = (
        rf"parts\.{name}\.strength: must be \"marin\" for this shape, got \"fkm\": its fatigue"
    )
    message += r" notch factors \(surface pivot 1\.3\) are of Marin's chain"
    with pytest.raises(DesignError, match=message):
        read_design(HAMMER, [f"parts.{name}.strength=fkm"])
    free = [f"parts.{name}.strength=fkm", f"parts.{name}.clamp_factor=1.0"]
    assert read_design(HAMMER, free).parts[name].fkm is not None


def test_the_section_of_marin_s_size_factor_is_refused_beside_fkm(tmp_path):
    link_file(tmp_path)
    step = PLATE.replace('shape = "plate_link"', 'shape = { step = "link.step" }')
    step = step.partition("width")[0].replace("first", "shaft").replace("second", "pin")
    step = step.replace('body = "rod"', 'body = "crank"').replace('"B"', '"O"')
    step += 'holes = { shaft = { diameter = "10 mm", at = "0, 0, 2 mm" }, pin = { diameter = "12 mm" } }\n'
    assert machine(tmp_path, step + 'section = "24, 8 mm"\n').parts["rod"].fkm is None
    assert machine(tmp_path, step + 'strength = "fkm"\n').parts["rod"].fkm is not None
    with pytest.raises(DesignError, match=r"parts\.rod\.section: belongs to Marin's chain"):
        machine(tmp_path, step + 'strength = "fkm"\nsection = "24, 8 mm"\n')


@pytest.mark.parametrize(("thickness", "told"), [(3280.0, False), (3310.0, True)])
def test_a_size_factor_beyond_its_data_is_told_as_assumed(thickness, told, tmp_path):
    """0.808 sqrt(30 t) is 254 mm at 3294 mm; FKM has no such factor."""
    design = machine(tmp_path)
    rod = design.parts["rod"]
    rod = replace(rod, geometry=replace(rod.geometry, thickness=thickness))
    said = dict(_assumed_here(replace(design, parts={"rod": rod}))).get("parts.rod.strength")
    assert (said is not None) == told
    assert not told or "to 254.6 mm: 0.633 in place of 0.633" in said
    judged = replace(rod, fkm=FkmStrength(FkmMaterial(410.0, "steel"), 25.0))
    assert "parts.rod.strength" not in dict(_assumed_here(replace(design, parts={"rod": judged})))


def test_a_brittle_part_is_told_once_that_it_is_brittle(tmp_path):
    with pytest.raises(DesignError, match="alumina is brittle") as caught:
        machine(tmp_path, FKM.replace("S275", "alumina"))
    assert not isinstance(caught.value, DesignErrors)


@pytest.mark.parametrize("group", FKM_GROUPS)
def test_only_groups_of_a_von_mises_strength_in_shear_are_taken(group):
    material = FkmMaterial(300.0, group)
    if FKM_GROUPS[group].shear_ratio == 0.577:
        assert FkmStrength(material, 25.0).reference > 0.0
    else:
        with pytest.raises(ValueError, match="von Mises alone"):
            FkmStrength(material, 25.0)


def test_editors_know_the_keys():
    check = jsonschema.Draft202012Validator(design_schema())
    properties = design_schema()["$defs"]["PlateLinkPart"]["properties"]
    assert properties["strength"]["enum"] == ["marin", "fkm"]
    data = tomllib.loads(HAMMER.read_text())
    name = next(iter(data["parts"]))
    data["parts"][name] |= {"strength": "fkm", "roughness": "25 um"}
    assert check.is_valid(data)
    data["parts"][name]["roughness"] = 25
    assert not check.is_valid(data)

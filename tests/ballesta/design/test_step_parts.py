"""Parts from CAD in a design file: what is read, what is refused where, and a whole check."""

import hashlib
import pickle
import tomllib
from dataclasses import replace

import jsonschema
import numpy as np
import pytest
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

from ballesta.design.authoring import design_schema
from ballesta.design.read import read_design
from ballesta.machine.solved_cycles import solve_cycles
from ballesta.pipeline import check_file
from ballesta.regression.file import ROUND_OFF, band_of
from checks.columns.column_limits import planes_of, whole_force
from checks.design.errors import DesignError
from checks.ladder.part_ladder import Effort
from checks.part.part_loads import loads_on
from checks.store.fingerprints import stages_of

from ...geometry.step_files import LINK, in_inches, link_file, moved, plate_with, write_step
from ..restated import numbers

# a crank of 60 mm that is turned against a slider, with the plate link as its crank
SOLID = Effort("solid")
MACHINE = """
name = "Crank and slider"
ground = ["O"]
accuracy = "10 %"
require = { static = 1.1, fatigue = 1.1 }
[points]
O = "0, 0 mm"
A = "0, 60 mm"
B = "144, -12 mm"
[bodies.crank]
pins = ["O", "A"]
[bodies.rod]
pins = ["A", "B"]
mass = "0.2 kg"
inertia = "5e-4 kg m2"
centre = "80, 0 mm"
[bodies.slider]
pins = ["B"]
mass = "0.5 kg"
guide = { along = "1, 0" }
[forces.drive]
turns = "crank"
at = "O"
[forces.push]
body = "slider"
at = "B"
direction = "-1, 0"
[cycles.turn]
coordinate = "crank.angle"
start = "90 deg"
pace = { coordinate = "crank.angle", speed = "10 rad/s" }
positions = 13
phases = [{ name = "round", to = "450 deg", forces = { push = "400 N" }, solve = "drive" }]
[duty]
cycles = { turn = 1e6 }
"""
CRANK = """
[parts.crank]
body = "crank"
shape = { step = "link.step" }
holes = { shaft = { diameter = "12 mm" }, pin = { diameter = "10 mm", at = "0, 0, 2 mm" } }
interfaces = { shaft = "O", pin = "A" }
material = "S355"
mesh = { fineness = 0.6 }
"""
PARAMETRIC = """
[parts.crank]
body = "crank"
shape = "plate_link"
interfaces = { first = "O", second = "A" }
width = "24 mm"
thickness = "8 mm"
hole = "12 mm"
second_hole = "10 mm"
material = "S355"
mesh = { fineness = 0.6 }
"""


@pytest.fixture
def machine(tmp_path):
    """The design file, with the STEP file beside it."""
    link_file(tmp_path)
    file = tmp_path / "crank.toml"
    file.write_text(MACHINE + CRANK)
    return file


def test_a_part_from_cad_is_read_with_its_file_among_the_sources(machine):
    design = read_design(machine)
    part, step = design.parts["crank"], machine.parent / "link.step"
    assert part.shape == "link.step"
    assert part.geometry.interfaces == ("shaft", "pin")
    assert_allclose(part.geometry.length, 60, rtol=1e-12)
    assert_allclose(part.geometry.found["shaft"].centre, [60, 0, 0], atol=1e-9)
    assert design.sources == (
        (str(machine), machine.read_text()),
        (str(step), step.read_text()),
    )
    texts = machine.read_text() + step.read_text()
    assert design.sha256 == hashlib.sha256(texts.encode()).hexdigest()
    assert dict(design.inputs)["parts.crank.shape.step"] == "link.step"
    assert dict(design.defaults_used)["parts.crank.hole_tolerance"] == "0.05 mm"
    told = [reason for key, reason in design.assumed if key == "parts.crank.shape"]
    assert any("of size factor and strength is 24 x 8 mm" in reason for reason in told)
    assert pickle.loads(pickle.dumps(design)).parts["crank"].geometry == part.geometry


def test_what_a_part_from_cad_states_arrives_in_millimetres(machine):
    changes = (
        "parts.crank.section=0.024 m, 7 mm",
        "parts.crank.hole_tolerance=0.1 mm",
        "parts.crank.holes.shaft.at=6, 0, 0 cm",
        "parts.crank.flip=true",
    )
    shape = read_design(machine, changes).parts["crank"].geometry
    assert shape.stressed_section == pytest.approx((24, 7))
    assert (shape.tolerance, shape.flip) == (0.1, True)
    assert shape.holes[0].at == pytest.approx((60, 0, 0))


@pytest.mark.slow
def test_a_part_is_as_thick_as_the_design_says(machine):
    """Numbers by formula are those of the part drawn so, to what is measured on a mesh: 1e-3."""
    thicker = read_design(machine, ["parts.crank.thickness=12 mm"])
    part, drawn = thicker.parts["crank"], read_design(machine).parts["crank"]
    assert_allclose([face.length for face in part.geometry.placed_interfaces], 12, rtol=1e-9)
    assert (
        stages_of(thicker)["crank: geometry"] != stages_of(read_design(machine))["crank: geometry"]
    )
    assert drawn.geometry.drawn_sizes == {"thickness": pytest.approx(8)}
    told = [reason for key, reason in thicker.assumed if key == "parts.crank.shape"]
    assert any("it is 12 mm thick along its pins; link.step has 8 mm" in said for said in told)
    found = numbers(check_file(machine, ["parts.crank.thickness=12 mm"], effort=Effort("formula")))
    write_step(machine.parent / "link.step", replace(LINK, thickness=12).build)
    wanted = numbers(check_file(machine, effort=Effort("formula")))
    assert found.keys() == wanted.keys()
    for key, rows in found.items():
        assert_allclose([row[0] for row in rows], [row[0] for row in wanted[key]], rtol=1e-3)


def test_a_part_that_is_no_plate_keeps_its_thickness(machine):
    """A pad about one hole: exit code 2 with what was found, not a stretched pad."""

    def pad(gmsh):
        occ = gmsh.model.occ
        occ.addBox(-20, -20, 0, 100, 40, 8)
        occ.fuse([(3, 1)], [(3, occ.addCylinder(60, 0, 8, 0, 0, 12, 15))])
        occ.cut(
            [(3, 1)], [(3, occ.addCylinder(x, 0, -1, 0, 0, 30, r)) for x, r in ((0, 5), (60, 6))]
        )

    write_step(machine.parent / "link.step", pad)
    read_design(machine)
    with pytest.raises(DesignError, match=r"parts\.crank\.thickness: .* 3 heights \(0, 8, 20 mm\)"):
        read_design(machine, ["parts.crank.thickness=9 mm"])


def test_parts_of_one_file_may_be_like_one_another(machine):
    machine.write_text(
        machine.read_text().replace('mass = "0.2 kg"\ninertia = "5e-4 kg m2"\n', "")
        + '[parts.rod]\nlike = "crank"\nbody = "rod"\ninterfaces = { shaft = "A", pin = "B" }\n'
    )
    with pytest.raises(DesignError) as refused:
        read_design(machine)
    assert str(refused.value) == (
        f"{machine}: parts.rod.holes.pin: is 60 mm from shaft in link.step and 160.997 mm in the "
        "linkage, more than 0.05 mm apart"
    )


@pytest.mark.parametrize(
    ("change", "key", "said"),
    [
        ("shape=link.stp", "shape", 'must be a table, { step = "link.stp" }, got "link.stp"'),
        ("shape=step", "shape", 'must be a table, { step = "bracket.step" }, got "step"'),
        ("shape=plate_lnk", "", "no shape is named 'plate_lnk', did you mean plate_link?"),
        ('shape={stp = "link.step"}', "shape.stp", "unknown key, did you mean step?"),
        ('shape={step = "lnk.step"}', "shape.step", "there is no such file, did you mean link.st"),
        ('shape={step = "."}', "shape.step", "'.' cannot be read: is a directory, not a file"),
        ('shape={step = "crank.toml"}', "shape", "'crank.toml' is no STEP file"),
        ("holes.pin.at=0, 0 mm", "holes.pin.at", "must be three numbers with a unit, such as"),
        ("holes.pin.at=0, 0, 0", "holes.pin.at", "without a unit"),
        ("holes.pin.at=0, 0, 4 mm, 3", "holes.pin.at", "must be three numbers"),
        ("holes.pin.diameter=0 mm", "holes.pin.diameter", "must be above 0 mm"),
        ("holes.pin.diameter=11 mm", "holes.pin", "no bore of 11 mm through (0, 0, 2) mm is in"),
        ("holes.pin.kind=bor", "holes.pin.kind", 'got "bor", did you mean bore?'),
        ("section=24, 0 mm", "section", 'must be above 0 mm both, got "24, 0 mm"'),
        ("width=24 mm", "width", "unknown key, there are"),
        ("thickness=0 mm", "thickness", "must be above 0 mm"),
        ("thickness=9 m", "thickness", "is its unit wrong?"),
        ('interfaces={shaft="O"}', "interfaces", "must say at which point pin sits"),
        (
            'interfaces={shaft="O", pn="A"}',
            "interfaces.pn",
            "no hole of the part is named 'pn', did",
        ),
        ("interfaces.pin=B", "interfaces.pin", "no point of body crank is named 'B'"),
    ],
)
def test_a_part_from_cad_that_cannot_be_meant_is_refused_at_its_key(machine, change, key, said):
    with pytest.raises(DesignError) as refused:
        read_design(machine, [f"parts.crank.{change}"])
    errors = getattr(refused.value, "errors", (refused.value,))
    where = ".".join(filter(None, ("parts.crank", key)))
    assert any(e.key == where and said in e.problem for e in errors), str(refused.value)


def test_a_file_in_the_wrong_unit_is_asked_about(machine):
    in_inches(machine.parent / "link.step")
    with pytest.raises(DesignError, match=r"25\.4 times apart: were inches and mm"):
        read_design(machine)


def test_names_in_a_step_file_may_be_in_any_encoding(machine):
    step = machine.parent / "link.step"
    text = step.read_text().replace("Open CASCADE Shape Model", "Kröpfung")
    assert "Kröpfung" in text
    step.write_bytes(text.encode("latin-1"))
    assert dict(read_design(machine).sources)[str(step)] == text


def test_a_pin_must_pass_the_hole_from_cad(machine):
    pin = """
[parts.pivot]
joint = "A"
shape = "pin"
fixed_to = "rod"
material = "S355"
diameter = "DIAMETER"
stack = [{ body = "rod", at = "12 mm", width = "4 mm" },
         { body = "crank", at = "0 mm", width = "8 mm" }]
"""
    for diameter in ("10 mm", "10.5 mm"):
        machine.write_text(MACHINE + CRANK + pin.replace("DIAMETER", diameter))
        if diameter == "10 mm":
            read_design(machine)
            continue
        with pytest.raises(DesignError, match=r"10\.5 mm cannot pass crank, which has 10 mm there"):
            read_design(machine)


def test_the_schema_knows_parts_from_cad():
    schema = jsonschema.Draft202012Validator(design_schema())

    def valid(text):
        return schema.is_valid(tomllib.loads(MACHINE + text))

    assert valid(CRANK)
    assert valid(PARAMETRIC)
    assert not valid(CRANK.replace("step =", "stp ="))
    assert not valid(CRANK.replace('"0, 0, 2 mm"', '"0, 0, 2"'))
    assert not valid(CRANK.replace('diameter = "12 mm"', "diameter = 12"))
    assert not valid(CRANK.replace('"link.step" }', '"link.step" }\nwidth = "3 mm"'))
    assert not valid(CRANK.replace('shape = { step = "link.step" }', 'shape = "plate_link"'))


def test_a_hole_beside_its_point_takes_the_force_with_the_couple_that_balances_it(machine):
    """The crank is 60.03 mm long in the linkage, 60 mm in the file: M = 0.03 mm x F across.

    What acts on the crank then balances about the holes of the file: round-off of the linkage.
    """
    design = read_design(machine, ["points.A=0, 60.03 mm"])
    part, crank = design.parts["crank"], (1e-4, (30.0, 0.0), 0.05)
    assert part.geometry.shifts["pin"] == pytest.approx((-0.03, 0.0))
    acting = loads_on(design, part, solve_cycles(design, {"crank": crank}))
    shaft, pin = acting.wrenches["shaft"], acting.wrenches["pin"]
    assert_allclose(pin[:, 5], 0.03 * pin[:, 1], atol=1e-9)
    assert np.abs(pin[:, 5]).max() > 10
    mass, (x, _), inertia = crank
    _, a_y, alpha, _ = acting.accelerations.T
    turned = (inertia + mass * x**2) * alpha + mass * x * a_y
    left = shaft[:, 5] + pin[:, 5] + 60 * pin[:, 1] - turned
    assert_allclose(left, 0, atol=1e-9 * np.abs(shaft[:, 5]).max())


def test_a_part_whose_holes_are_beside_their_points_is_a_column_as_long_as_the_linkage_has_it(
    machine,
):
    """60 mm in the file, 60.03 mm in the linkage: Euler's force falls by 0.1 %."""
    forces = []
    for changes in ([], ["points.A=0, 60.03 mm"]):
        design = read_design(machine, changes)
        part = design.parts["crank"]
        plane = planes_of(design, part)[0]
        forces.append(whole_force(part, plane, part.geometry.sections[0]))
    assert_allclose(forces[1] / forces[0], (60 / 60.03) ** 2, rtol=1e-9)


@pytest.mark.slow
def test_a_part_from_cad_passes_a_check_as_the_parametric_one_does(machine):
    """The same crank twice: mass to the mesh's 1e-3, stresses within both error bars.

    The one from CAD is 0.02 mm shorter than the linkage's.
    """
    own = check_file(machine, ["points.A=0, 60.02 mm"], effort=SOLID).parts[0]
    other_file = machine.with_name("parametric.toml")
    other_file.write_text(MACHINE + PARAMETRIC)
    other = check_file(other_file, effort=SOLID).parts[0]
    assert own.shape == "link.step"
    assert_allclose(own.facts["mass [kg]"], other.facts["mass [kg]"], rtol=1e-3)
    for check in ("static", "fatigue"):
        mine, theirs = (next(c for c in r.checks if c.kind == check) for r in (own, other))
        bars = mine.numerical + theirs.numerical
        assert abs(mine.value - theirs.value) < bars < 0.2 * theirs.value
        assert mine.status is theirs.status
    assert all(gate.holds for gate in own.gates), [str(gate) for gate in own.gates]


def test_a_plate_with_two_equal_holes_needs_a_point_for_each(machine):
    tools = [(x, 0, -1, 0, 0, 10, 5) for x in (0, 60)]
    write_step(machine.parent / "link.step", plate_with(*tools))
    with pytest.raises(DesignError, match=r"2 holes of link\.step are a bore of 10 mm: `at` must"):
        read_design(machine, ["parts.crank.holes.shaft.diameter=10 mm"])
    fits = ["parts.crank.holes.shaft={diameter = '10 mm', at = '60, 0, 0 mm'}"]
    assert read_design(machine, fits).parts["crank"].geometry.length == pytest.approx(60)


@pytest.mark.slow
def test_a_part_that_is_not_even_about_its_plane_is_held_against_tilting(machine):
    """A pad on one side: the second hole 6 mm and the mass 2 mm out of the plane of the first."""

    def pad(gmsh):
        occ = gmsh.model.occ
        occ.addBox(-20, -20, 0, 100, 40, 8)
        occ.fuse([(3, 1)], [(3, occ.addCylinder(60, 0, 8, 0, 0, 12, 15))])
        occ.cut([(3, 1)], [(3, occ.addCylinder(x, 0, -1, 0, 0, 30, 5)) for x in (0, 60)])

    write_step(machine.parent / "link.step", pad)
    changes = [
        "parts.crank.holes.shaft={diameter = '10 mm', at = '0, 0, 0 mm'}",
        "parts.crank.holes.pin.at=60, 0, 0 mm",
        "parts.crank.mesh.fineness=0.5",
    ]
    result = check_file(machine, changes, effort=SOLID).parts[0]
    assert all(gate.holds for gate in result.gates), [str(gate) for gate in result.gates]


TURN, AWAY = Rotation.from_euler("z", 37, degrees=True), np.array([8e5, -6e5, 0.0])
ACCURACY = 0.05


def drawn_twice(folder, fidelity):
    """Numbers of the crank as it is, and of it drawn turned by 37 degrees, 1 km away."""
    found = []
    for name, turn, by in (("here", Rotation.identity(), np.zeros(3)), ("there", TURN, AWAY)):
        place = folder / name
        place.mkdir()
        link_file(place, moved((0, 0, 1), turn.magnitude(), by.tolist()))
        file = place / "crank.toml"
        file.write_text(MACHINE + CRANK)
        x, y, z = (turn.apply([0, 0, 2]) + by).tolist()
        told = (
            f"parts.crank.holes.pin.at={x!r}, {y!r}, {z!r} mm",
            "parts.crank.section=24 mm, 8 mm",
            f"accuracy={100 * ACCURACY} %",
        )
        found.append(numbers(check_file(file, told, effort=Effort(fidelity))))
    assert found[0].keys() == found[1].keys()
    return found


@pytest.mark.slow
def test_a_part_that_is_drawn_turned_and_a_kilometre_away_has_the_same_numbers_by_formula(tmp_path):
    """What is measured on a mesh is so to 1e-3: shear-out, sections (docs/theory/fits.md)."""
    here, there = drawn_twice(tmp_path, "formula")
    kinds = {kind for _, kind, _ in here}
    assert kinds == {"static", "fatigue", "buckling", "bearing", "shear-out"}
    for key, rows in here.items():
        for (old, *_), (new, *_) in zip(rows, there[key], strict=True):
            assert_allclose(new, old, rtol=ROUND_OFF if key[1] == "bearing" else 1e-3)


@pytest.mark.slow
def test_a_solid_that_is_drawn_turned_and_a_kilometre_away_stays_in_its_regression_band(tmp_path):
    """The mesher follows the last digits of the file, so the meshes differ."""
    here, there = drawn_twice(tmp_path, "solid")
    for kind in ("static", "fatigue", "buckling"):
        (key, *columns) = (key for key in here if key[1] == kind)
        ((old, bar, *_),), ((new, *_),) = here[key], there[key]
        checked = {"rung": "solid", "numerical": bar / old}
        band = band_of("crank", kind, checked, ACCURACY, {}).width
        assert band is not None
        assert_allclose(new, old, rtol=band)
        for key in columns:
            assert_allclose(there[key][0][0], here[key][0][0], rtol=1e-3)

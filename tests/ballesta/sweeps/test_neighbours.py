"""Neighbours of variations on a grid about the file."""

from ballesta.sweeps.sweep import on_grid

STATED = [("parts.bar.wall", "6 mm"), ("parts.bar.hole", "40 mm"), ("accuracy", "5 %"),
          ("cycles.press.phases[1].forces.ram", "11 kN"), ("parts.pin.stack[0].width", "6 mm"),
          ("materials.own.yield_stress", "355 MPa")]  # fmt: skip


def test_a_dimension_near_the_file_s_has_the_file_s_as_its_neighbour():
    """Steps are 20 %, so the middle between two points is sqrt(1.2) = 1.0954 times the lower."""
    assert on_grid(["parts.bar.wall=6.57 mm"], STATED) == ("parts.bar.wall=6 mm",)
    assert on_grid(["parts.bar.wall=6.58 mm"], STATED) == ("parts.bar.wall=7.2 mm",)
    assert on_grid(["parts.bar.wall=5.47 mm"], STATED) == ("parts.bar.wall=5 mm",)


def test_a_part_that_is_like_another_has_its_dimensions():
    stated = [*STATED, ("parts.other.like", "bar"), ("parts.third.like", "other")]
    assert on_grid(["parts.third.hole=43 mm"], stated) == ("parts.third.hole=40 mm",)
    assert on_grid(["parts.third.none=43 mm"], stated) == ("parts.third.none=43 mm",)


def test_forces_have_neighbours_too():
    force = "cycles.press.phases[1].forces.ram"
    assert on_grid([f"{force}=10.5 kN"], STATED) == (f"{force}=11 kN",)


def test_a_pin_s_stack_and_a_material_s_numbers_have_neighbours_too():
    """Its yield stress scatters from variation to variation, and the mesh does not know it."""
    overrides = ["parts.pin.stack[0].width=6.4 mm", "materials.own.yield_stress=371.3 MPa"]
    near = ("parts.pin.stack[0].width=6 mm", "materials.own.yield_stress=355 MPa")
    assert on_grid(overrides, STATED) == near


def test_what_is_no_dimension_stays():
    """Also lengths that the file does not state, or states in another unit."""
    kept = ("accuracy=4 %", "material=S355", "parts.bar.fillet=1.1 mm", "parts.bar.hole=4.1 cm")
    assert on_grid(kept, STATED) == kept

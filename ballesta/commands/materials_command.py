"""Materials of ballesta's own file, as lines for people."""

from math import inf
from pathlib import Path

from checks.design.errors import DesignError, no_such
from checks.design.materials import Grade, Material, known_materials
from checks.result.words import number
from reports.loads_text import table
from reports.terminal import labelled

_WIDTH = 100
_PER_METRE = 1000**0.5  # MPa mm^0.5 in a MPa m^0.5


def materials_text(name: str = "") -> str:
    """Return all materials, a line each, or every value of one.

    Raises DesignError for a name that no material has.
    """
    known = known_materials()
    if not name:
        heads = ["material", "yield, MPa", "ultimate, MPa", "E, GPa", "up to"]
        return "\n".join(table(heads, [_row(m) for m in known.values()], {1, 2, 3}, _WIDTH))
    if name not in known:
        raise DesignError(Path("materials"), name, no_such("material", name, known))
    lines = [labelled(label, text, _WIDTH, indent=11) for label, text in _values(known[name])]
    return "\n".join(line for several in lines for line in several)


def _row(material: Material) -> list[str]:
    grades = material.grades
    return [
        material.name,
        _range(*(grade.yield_stress for grade in grades)),
        _range(*(grade.ultimate_stress for grade in grades)),
        number(material.youngs_modulus / 1e3),
        _size(grades[-1]),
    ]


def _range(*values: float) -> str:
    """The value of the smallest size, and of the largest where that differs."""
    first, last = values[0], values[-1]
    return f"{first:g}" if first == last else f"{first:g} .. {last:g}"


def _size(grade: Grade) -> str:
    if grade.thickness == inf:
        return "any size"
    rounds = "" if grade.diameter == grade.thickness else f", rounds {grade.diameter:g} mm"
    return f"{grade.thickness:g} mm{rounds}"


def _values(material: Material) -> list[tuple[str, str]]:
    """Labels and texts of all values of a material."""
    values = [
        ("material", material.name),
        ("elastic", f"E {material.youngs_modulus / 1e3:g} GPa, nu "
         f"{material.poisson_ratio:g}, density {material.density * 1e12:g} kg/m3"),
    ]  # fmt: skip
    values += [
        ("strength", f"yield {g.yield_stress:g} MPa, ultimate {g.ultimate_stress:g} MPa: "
         + (_size(g) if g.thickness == inf else f"up to {_size(g)}"))
        for g in material.grades
    ]  # fmt: skip
    if material.why_not_goodman:
        values.append(("fatigue", material.why_not_goodman))
    else:
        ratio = material.endurance_ratio
        at = f" at {material.endurance_cycles:g} cycles"
        share, of = (0.5, ", as steel's") if ratio is None else (ratio, at)
        values.append(
            ("fatigue", f"endurance limit of a polished bar {share:g} of the ultimate strength{of}")
        )
    if material.threshold is not None:
        threshold = number(material.threshold / _PER_METRE)
        values.append(("threshold", f"{threshold} MPa m^0.5, at R = -1, for sharp edges"))
    if material.fkm_group is not None:
        values.append(("FKM group", material.fkm_group))
    return [*values, ("source", material.source)]

"""What is told of a part's fatigue beside the verdict: other rules, other survivals, its life.

None of it decides: Goodman (and Findley where the path is not proportional) is the verdict, and
these numbers say what other rules and another survival would have said of the same point.
"""

from math import inf, isfinite

import numpy as np

import fatigue
from ballesta.design_data import Part
from ballesta.duty_verdict import FatiguePeak
from ballesta.finite_life import LifeTask, lives_of
from ballesta.levels import Level
from fatigue.marin import reliability_factor
from geometry.mesh import FloatArray

_SURVIVALS = (0.5, 0.9, 0.99, 0.999)
_RULES = {
    "gerber": "Gerber",
    "asme_elliptic": "ASME-elliptic",
    "soderberg": "Soderberg",
    "morrow": "Morrow",
    "walker": "Walker",
    "swt": "SWT",
    "fkm": "FKM",
}


def chord_at(level: Level, peak: FatiguePeak) -> tuple[float, float, float]:
    """Amplitude, mean as Goodman counts it, and mean along the chord with its sign, MPa.

    Of the deciding pair. The mean along the chord is an equivalent stress, below 0 in compression,
    where the largest principal stress is 0 at a free surface.
    """
    point, pair = peak.point, list(peak.pair)
    path = np.ascontiguousarray(level.coefficients[:, pair])
    chord = fatigue.chord_path(level.history.basis[point], path, (0, 1))
    return chord.amplitude, chord.mean, float(chord.along.mean())


def fatigue_facts(
    part: Part, level: Level, peak: FatiguePeak, task: LifeTask
) -> dict[str, float | str]:
    """Facts of the critical point, by name; safeties are on all loads."""
    assert level.duty is not None
    material, limit = part.material, float(level.limits[peak.point])
    amplitude, mean, along = chord_at(level, peak)
    signed = mean if mean > 0.0 else min(along, 0.0)
    rules = _mean_stress_material(part)
    facts: dict[str, float | str] = {
        "fatigue amplitude [MPa]": amplitude,
        "fatigue mean stress [MPa]": mean,
        "fatigue safety by other rules of mean stress": _by_rule(amplitude, mean, limit, rules),
    }
    if signed < 0.0:
        credited = fatigue.mean_stress_utilisation(amplitude, signed, limit, rules, credit=True)
        facts["fatigue safety with credit for compression"] = (
            f"{_safety(float(credited))}: mean {signed:.4g} MPa along the chord, counted as 0"
        )
    yielding = float(
        fatigue.yield_utilisation(amplitude, max(mean, abs(along)), material.yield_stress)
    )
    facts["first-cycle yield at the critical point (Langer), safety"] = _safety(yielding)
    facts["fatigue safety by survival of the parts"] = _by_survival(part, amplitude, mean, limit)
    facts |= _multiaxial(level)
    (life,) = lives_of(level.duty, task, np.array([peak.point]))
    facts["Miner's sum of the duty at the critical point"] = (
        (
            f"{life.damage:.3g} of {task.allowed_damage:.3g} that are allowed or left"
            if life.damage
            else "0, no cycle exceeds the endurance limit"
        )
        + f"; {life.cycles.cycle_counts.sum():.4g} cycles, safety for this life "
        + _safety(1.0 / life.safety)
    )
    return facts


def _mean_stress_material(part: Part) -> fatigue.MeanStressMaterial:
    """What the rules need: of steels also Morrow's and Walker's numbers.

    s_f' = S_u + 345 MPa (Shigley, 9th ed., eq. 6-10) and gamma = 0.8818 - 0.0002 S_u (Dowling,
    Mechanical Behavior of Materials, 4th ed., eq. 9.20) hold for steels.
    """
    material = part.material
    ultimate = material.ultimate_stress
    steel = material.endurance_ratio is None
    group = material.fkm_group
    return fatigue.MeanStressMaterial(
        ultimate,
        material.yield_stress,
        fracture_strength=ultimate + 345.0 if steel else None,
        walker_exponent=0.8818 - 0.0002 * ultimate if steel else None,
        mean_stress_sensitivity=None
        if group is None
        else fatigue.fkm_sensitivity(ultimate, fatigue.FKM_GROUPS[group].sensitivity),
    )


def _by_rule(amplitude: float, mean: float, limit: float, rules: fatigue.MeanStressMaterial) -> str:
    band = fatigue.mean_stress_band(amplitude, mean, limit, rules)
    return ", ".join(
        f"{_RULES[rule]} {_safety(float(used))}" for rule, used in band.items() if rule in _RULES
    )


def _by_survival(part: Part, amplitude: float, mean: float, limit: float) -> str:
    """Goodman's safety by the share of parts that survive: scatter of the endurance limit alone."""
    own = reliability_factor(part.reliability)
    said = []
    for share in _SURVIVALS:
        scaled = limit * reliability_factor(share) / own
        used = amplitude / scaled + mean / part.material.ultimate_stress
        said.append(f"{100 * share:g} % {_safety(used)}")
    return ", ".join(said)


def _multiaxial(level: Level) -> dict[str, float | str]:
    """The path of the critical point of the deciding cycle, and criteria that stand beside."""
    assert level.duty is not None
    verdict = level.duty.worst
    width = float(verdict.bounds.width[verdict.critical])
    facts: dict[str, float | str] = {
        "stress path at the critical point": "proportional: Goodman alone decides"
        if verdict.proportional[verdict.critical]
        else f"not proportional, {width:.2g} as wide as long; {verdict.n_searched} points searched "
        "for their critical plane"
    }
    if verdict.plane is not None:
        plane = verdict.plane
        x, y, z = plane.normal
        used = float(verdict.plane_utilisation[verdict.critical])
        facts["Findley's critical plane"] = (
            f"normal ({x:.3f}, {y:.3f}, {z:.3f}), shear amplitude {plane.shear_amplitude:.4g} MPa, "
            f"normal stress {plane.normal_stress:.4g} MPa, safety {_safety(used)}"
        )
    compared = verdict.compared
    facts["fatigue safety by other multiaxial criteria"] = (
        f"Crossland {_safety(compared.crossland)}, Dang Van {_safety(compared.dang_van)}, "
        f"Papadopoulos {_safety(compared.papadopoulos)}"
    )
    return facts


def haigh_of(
    part: Part, level: Level, peak: FatiguePeak, most_used: int = 300
) -> dict[str, object]:
    """Plain data of the Haigh diagram: the critical point, its path, and the most used points."""
    assert level.duty is not None
    verdict = level.duty.worst
    amplitude, mean, _ = chord_at(level, peak)
    order = np.argsort(-verdict.goodman_bound, kind="stable")[:most_used]
    cloud = fatigue.goodman(
        level.history.basis[order],
        level.duty.path,
        level.limits[order],
        part.material.ultimate_stress,
    )
    return {
        "cycle": peak.cycle,
        "criterion": peak.criterion,
        "pair": [int(k) for k in peak.pair],
        "along": _along(level, peak).tolist(),
        "mean": mean,
        "amplitude": amplitude,
        "endurance": float(level.limits[peak.point]),
        "ultimate": part.material.ultimate_stress,
        "yield": part.material.yield_stress,
        "cloud": np.stack([cloud.mean, cloud.amplitude], axis=1).tolist(),
    }


def _along(level: Level, peak: FatiguePeak) -> FloatArray:
    """Stress of the critical point along the chord of its deciding pair, over the deciding path."""
    assert level.duty is not None
    duty = level.duty
    run = duty.runs.get(peak.cycle)
    if run is None:
        run = np.concatenate([duty.runs[name] for name in duty.runs])
    first, second = (int(np.flatnonzero(run == k)[0]) for k in peak.pair)
    path = np.ascontiguousarray(level.coefficients[:, run])
    return fatigue.chord_path(level.history.basis[peak.point], path, (first, second)).along


def _safety(utilisation: float) -> str:
    safety = 1.0 / utilisation if utilisation > 0.0 else inf
    return f"{safety:.3g}" if isfinite(safety) else "no limit"

"""Ways out of an open verdict: what would settle each open check or gate, the cheapest first.

Each is computed from the result: a key counts only where the check passes or fails without the bar
that the key takes away, a mesh only where the bar that it leaves would settle the check.
"""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from math import ceil, floor, inf, isfinite, log10
from shlex import quote

from checks.result.verdict import (
    Change,
    Check,
    DesignResult,
    Gate,
    PartResult,
    RungTried,
    Status,
    Way,
)
from checks.result.words import (
    END_OF_TRAVEL,
    HITS,
    INTERFERENCE,
    LENGTHS_OFF,
    LESS_IN,
    SPEED_DOUBTS,
    TOO_MANY,
    WOULD_HIT,
    check_titles,
    gate_sentence,
    need_text,
    number,
    open_reason,
    safety_text,
)

SOLID = "solid"
NOTHING = "nothing here settles it"  # begins the text of a way that is none
SAVED = "least mass by single changes"
LEAST = "least single changes"  # of a dimension or a material
STEEL_BUSH = "b_s"  # symbol of the model band above with bushes of steel
_BY_RUN_IN = ": passes by run-in edges, upper end of its bars as cut [MPa], of "
_FINEST = 0.003  # of a value: a smaller numerical bar is not asked of a mesh
_MOST_UNKNOWNS = 300_000  # that a design allows where it states nothing
_TOO_MANY = 3_000_000
_UNKNOWNS_BY_ERROR = 1.5  # of a bar in h squared, unknowns in h to the power -3: at most so many


def arc_fact(kind: str) -> str:
    """Name of the fact: the narrowest arc of contact from which on a kind of check passes."""
    return f"{kind}: passes with an arc of contact from [deg]"


def clearance_fact(kind: str, bore: str) -> str:
    """Name of the fact: the largest clearance of all pins, up to which a kind of check passes."""
    return f"{kind}: passes by contact with a clearance in {bore} up to [mm]"


def edges_fact(
    kind: str, bores: Sequence[str], *, steel: bool = False, cushioned: bool = False
) -> str:
    """Name of the fact: least safety of an open check that passes with edges that have run in.

    steel      True where it takes bushes as stiff as steel as well
    cushioned  True where it takes pins that hit nothing in their play as well
    """
    also = " and bushes as stiff as steel" * steel + " and cushioned pins" * cushioned
    return f"{kind}: passes with run-in edges{also}, least safety, of {', '.join(bores)}"


def without_hits(check: Check) -> Check:
    """The check without the bounds of what pins hit as they cross their play."""
    return check.without(one for one in check.doubts if one[0].endswith(HITS))


def run_in_fact(kind: str, bores: Sequence[str]) -> str:
    """Name of the fact: upper end of a check's bars, did the edges of bores press as they are cut.

    It is there where the check passes and would not with it.
    """
    return f"{kind}{_BY_RUN_IN}{', '.join(bores)}"


def run_in_edges(result: DesignResult) -> list[str]:
    """Edges stated to have run in that checks pass by, and how far they came without, in words."""
    parts: dict[tuple[str, str], list[tuple[str, float, float]]] = {}
    for part in result.parts:
        allowed = {check.kind: check.limit / check.required for check in part.checks}
        for name, upper in part.facts.items():
            kind, by, bores = name.partition(_BY_RUN_IN)
            if by:
                one = (part.name, float(upper), allowed[kind])
                parts.setdefault((kind, bores), []).append(one)
    said = []
    for (kind, bores), alike in parts.items():
        _, upper, limit = max(alike, key=lambda one: one[1] / one[2])
        said.append(
            f"edges of {bores} that have run in ({', '.join(name for name, *_ in alike)}): as cut, "
            f"{kind} would not pass, up to {number(upper)} of {number(limit)} MPa allowed"
        )
    return said


def ways_out(result: DesignResult) -> list[Way]:
    """Return the ways of a result, the cheapest first; those whose time is not known come last.

    Where nothing settles a check or a gate, that is said in its place.
    """
    found: list[Way] = []
    for part in result.parts:
        for check, title in zip(part.checks, check_titles(part.checks), strict=True):
            found += _of_check(result, check, f"{title} of {part.name}", part)
        for gate in part.gates:
            found += _of_gate(result, gate)
    for check, title in zip(result.linkage, check_titles(result.linkage), strict=True):
        found += _of_check(result, check, f"{title} of the linkage", None)
    for gate in result.gates:
        found += _of_gate(result, gate)
    return _merged(sorted(found, key=lambda way: (not way.command, way.seconds or inf)))


def _merged(ways: Iterable[Way]) -> list[Way]:
    """Ways of one command, or of one text without any, as one, in their order.

    Those that tell different verdicts stay apart.
    """
    by_command: dict[tuple[str, str], Way] = {}
    for way in ways:
        told = way.text.rpartition(" ")[2]
        verdict = told if told in {str(status) for status in Status} else ""
        key = (way.command, verdict if way.command else way.text)
        known = by_command.get(key)
        if known is None:
            by_command[key] = way
        elif way.settles not in known.settled:
            by_command[key] = replace(known, settles=f"{known.settles}, {way.settles}")
    return list(by_command.values())


def _of_check(
    result: DesignResult, check: Check, settles: str, part: PartResult | None
) -> Iterator[Way]:
    if check.status is Status.FAIL and part is not None:
        less = _excess(check.upper, check)
        told = f"{settles} ({number(less, 2)} % lower)" if less else settles
        yield Way(told, f"{LEAST}, error bars included", improve_command(result))
    if check.status is not Status.UNDECIDED:
        return
    ways = [
        *_by_drive(result, check, settles),
        *_by_range(check, settles),
        *_by_play(result, check, settles),
        *_by_positions(check, settles),
    ]
    if part is None:
        ways += _by_forks(result, check, settles)
    else:
        ways += [
            *_by_clearance(result, check, settles, part),
            *_by_arc(result, check, settles, part),
            *_by_bush(check, settles),
            *_by_edges(result, check, settles, part),
            *_by_mesh(result, check, settles, part),
            *_by_model(result, check, settles, part),
        ]
    yield from ways or [Way(settles, f"{NOTHING}: {open_reason(check)}")]


def lower_by(check: Check) -> str:
    """How much lower a check's value must be to pass, in words; "" where that is not known."""
    if isfinite(check.upper):
        less, bars = _excess(check.upper, check), ", error bars included"
    else:
        less, bars = _excess(check.lower, check), " even at the lower end of its error bars"
    return f"its value must be {number(less, 2)} % lower{bars}" if less else ""


def _excess(value: float, check: Check) -> float:
    """Per cent by which a value of a check must be lower to pass; 0 if it does, or is unknown."""
    demand = value * check.required
    known = demand > check.limit and isfinite(demand)
    return 100.0 * (1.0 - check.limit / demand) if known else 0.0


def change_text(change: Change, deciding: Check) -> str:
    """A single change in words: its values, safety with its lower end, and mass.

    deciding  the check of which the reader knows; another one that then governs is named
    """
    setting, now, safety, detail, mass = change_cells(change, deciding)
    return f"{setting} ({now}): {safety}{f' ({detail})' if detail else ''}; {mass}"


def change_cells(change: Change, deciding: Check) -> tuple[str, str, str, str, str]:
    """The parts of a single change's words, as the cells of a row.

    They are key and value; the present value; safety; its lower end and the check that then
    governs, if it is not the one of which the reader knows; mass.
    """
    unit = f" {change.value.partition(' ')[2]}"
    safety = safety_text(change.safety, change.required)
    lower = safety_text(change.lower, change.required)
    same = change.governing == f"{deciding.part} {deciding.kind}"
    need = "" if same else f"of {change.governing}, {need_text(change.required)} required"
    detail = ", ".join(filter(None, ("" if lower == safety else f"≥ {lower}", need)))
    more = f" ({-1e3 * change.saved:+.2g})" if change.saved else ""
    mass = f"{number(1e3 * change.mass)} kg{more}"
    now = f"now {change.was.removesuffix(unit)}"
    return f"{change.key}={change.value}", now, f"safety {safety}", detail, mass


def improve_command(result: DesignResult) -> str:
    """The command that finds single changes with which a result's design passes."""
    sets = "".join(f" --set {quote(override)}" for override in result.overrides)
    return f"ballesta improve {quote(result.file)}{sets}"


def _by_drive(result: DesignResult, check: Check, settles: str) -> Iterator[Way]:
    """Where the load bars of a drive of which nothing is stated hold the limit."""
    if "drive" not in {key for key, _ in result.assumed}:
        return
    known = check.without(one for one in check.doubts if one[0].endswith(SPEED_DOUBTS))
    if known.status is not Status.UNDECIDED:
        yield Way(
            settles,
            f"state how the drive holds its speed: without its bar it is a {known.status}",
            command_with(result, 'drive.control="constant"'),
            _again(result),
        )


def _by_range(check: Check, settles: str) -> Iterator[Way]:
    """Where a range holds the limit: of a bush's interference, of a stop, of lengths."""
    for doubt in check.doubts:
        words = doubt[0]
        cycle, stop, _ = words.partition(f": {END_OF_TRAVEL}")
        if words.startswith(INTERFERENCE):
            text = f"state a narrower range (bush.fit) of the {words}: at its middle it is a "
        elif stop:
            text = f"state a smaller cycles.{cycle}.stop.tolerance: at the stop itself it is a "
        elif words.endswith(LENGTHS_OFF):
            name = words.removesuffix(f": {LENGTHS_OFF}")
            text = f"end {name} farther from its dead centre: with exact lengths it is a "
        else:
            continue
        known = check.without([doubt])
        if known.status is not Status.UNDECIDED:
            yield Way(settles, f"{text}{known.status}")


def _by_play(result: DesignResult, check: Check, settles: str) -> Iterator[Way]:
    """Where the bounds of what pins hit as they cross their play hold the limit."""
    joints, known = _hit_joints(check), without_hits(check)
    if not joints or known.status is Status.UNDECIDED:
        return
    points = dict.fromkeys(joint.partition(":")[0] for joint in joints)
    text = (
        f"state that oil, preload or friction slows the pins of {', '.join(joints)} as they cross "
        "their play (dynamics.cushioned), or closer fits, or how joints give way (elastic.joints): "
        f"without their hits, bounds of rigid bodies on steel, it is a {known.status}"
    )
    if _is_cushioned(result):
        yield Way(settles, text)
    else:
        yield Way(settles, text, command_with(result, _cushioned(points)), _again(result))


def _hit_joints(check: Check) -> list[str]:
    """Joints whose pins' hits are in its load bars."""
    hits = [words for words, *_ in check.doubts if words.endswith(HITS)]
    return [words.removesuffix(f" {HITS}").rpartition(" in ")[2] for words in hits]


def _by_positions(check: Check, settles: str) -> Iterator[Way]:
    """Where what may lie between the positions of the cycle holds the limit."""
    known = check.between_positions
    if known is not Status.UNDECIDED:
        text = "state more positions of its cycle (cycles.NAME.positions): without what its bar has"
        yield Way(settles, f"{text} between them it is a {known}")


def _by_forks(result: DesignResult, check: Check, settles: str) -> Iterator[Way]:
    """Where a linkage buckles only if its pins let its bodies tilt out of the plane."""
    if check.method != "frame":  # a cylinder's own checks know no forks
        return
    share = max(check.value - (check.below - check.loads_below), 0.0)
    scale = share / check.value  # all bars are shares of the value
    held = replace(
        check,
        value=share,
        numerical=scale * check.numerical,
        model=scale * (check.model if isfinite(check.model) else check.loads),
        model_below=scale * check.loads_below,
    )
    if held.status is Status.PASS:
        yield Way(
            settles,
            "state that pins and forks hold all tilts out of the plane, where they do (two frames "
            f"side by side, long bearings): its safety is then {number(held.safety, 3)}",
            command_with(result, 'forks="stiff"'),
            _again(result),
        )


def _by_arc(result: DesignResult, check: Check, settles: str, part: PartResult) -> Iterator[Way]:
    """Where pins that fit closer press on a wider arc."""
    arc = part.facts.get(arc_fact(check.kind))
    if arc is not None:
        yield Way(
            settles,
            f"state the arc on which pins press, by their clearance: it passes from {arc:g} deg",
            command_with(result, f'parts.{part.name}.bearing_arc="{arc:g} deg"'),
            _again(result),
        )


def _by_clearance(
    result: DesignResult, check: Check, settles: str, part: PartResult
) -> Iterator[Way]:
    """Where contact presses less than the assumed arcs, for the clearances that pins may have."""
    begins, ends = clearance_fact(check.kind, "\n").split("\n")
    found = {
        name.removeprefix(begins).removesuffix(ends): value
        for name, value in part.facts.items()
        if name.startswith(begins) and name.endswith(ends)
    }
    if not any(found.values()):
        return  # no pin turns without any clearance
    hit = _hit(result, part, found)
    slowed = (
        f", and that oil, preload or friction slows those of {', '.join(hit)} as they cross their "
        "play (dynamics.cushioned), else bounds of their hits join its bars"
        if hit
        else ""
    )
    if any(bore in part.charts.get("pressed", ()) for bore in found):
        left = " and ".join(f"{most:g} mm in {bore}" for bore, most in found.items())
        yield Way(
            settles,
            f"state the fit of its pins (fits) before the bushes are pressed in{slowed}: it passes "
            f"with clearances of up to {left} that these leave",
        )
        return
    fits = {f"fits.{bore}": f'"0 .. {most:g} mm"' for bore, most in found.items()}
    if f"parts.{part.name}.bearing_arc" in {key for key, _ in result.defaults}:
        clearance = f"{max(found.values()):g} mm"
        text = (
            f"state the fit of its pins (fits){slowed}: it passes with clearances up to {clearance}"
        )
        stated = [f"parts.{part.name}.{key}={value}" for key, value in fits.items()]
        if hit:
            stated.append(_cushioned(hit))
        if hit and _is_cushioned(result):
            yield Way(settles, text)
        else:
            yield Way(settles, text, command_with(result, *stated), _again(result))
    else:
        stated = [f"{key} = {value}" for key, value in fits.items()]
        text = (
            f"state the fit of its pins instead of bearing_arc{slowed}: it passes with "
            f"{', '.join(stated)}"
        )
        yield Way(settles, text)


def _hit(result: DesignResult, part: PartResult, bores: Iterable[str]) -> list[str]:
    """Points of bores whose pins would hit them, were their fits stated."""
    worst, _, others = dict(result.assumed).get("parts.fits", "").partition(f" {WOULD_HIT} ")
    less = others.partition(f"({LESS_IN} ")[2].partition(")")[0]
    named = {worst.rpartition(" ")[2], *less.split(", ")}
    points = [_input(result, part.name, f"interfaces.{bore}") for bore in bores]
    return [point for point in dict.fromkeys(points) if point and point in named]


def _input(result: DesignResult, part: str, key: str) -> str:
    """Value of a key of a part, stated by itself or by the one that it is like; "" for none."""
    inputs = dict(result.inputs)
    while part and f"parts.{part}.{key}" not in inputs:
        part = inputs.get(f"parts.{part}.like", "")
    return inputs.get(f"parts.{part}.{key}", "")


def _cushioned(points: Iterable[str]) -> str:
    quoted = ", ".join(f'"{point}"' for point in points)
    return f"dynamics.cushioned=[{quoted}]"


def _is_cushioned(result: DesignResult) -> bool:
    """True where the design states cushioned pins: another list would replace its own."""
    return "dynamics.cushioned" in {key for key, _ in result.assumed}


def _by_bush(check: Check, settles: str) -> Iterator[Way]:
    """Where only bushes far softer than steel would leave it open."""
    told = check.derivation
    if told is None or all(getattr(item, "symbol", "") != STEEL_BUSH for item in told.items):
        return
    steel = check.model - told.number("b_up") + told.number(STEEL_BUSH)
    if replace(check, model=steel).status is Status.PASS:
        yield Way(
            settles,
            "state what the bushes of its pins are made of (bush.material in their stacks): as "
            "stiff as steel it passes",
        )


def _by_edges(result: DesignResult, check: Check, settles: str, part: PartResult) -> Iterator[Way]:
    """Where even pressure along pins that bend leaves the limit above the bars."""
    joints = _hit_joints(check)
    for steel, cushioned in ((False, False), (True, False), (False, True)):
        begins = edges_fact(check.kind, (), steel=steel, cushioned=cushioned)
        for name, least in part.facts.items():
            if not name.startswith(begins):
                continue
            bores = name.removeprefix(begins).split(", ")
            bushes = ", and the bush.material, one as stiff as steel" * steel
            slowed = (
                f", and that oil, preload or friction slows the pins of {', '.join(joints)} as "
                "they cross their play (dynamics.cushioned)" * cushioned
            )
            text = (
                f"state edges of {' and '.join(bores)} that have run in (bore_edges){bushes}"
                f"{slowed}: {check.kind} passes, safety ≥ {number(least, 3)}"
            )
            stated = [f'parts.{part.name}.bore_edges.{bore}="run_in"' for bore in bores]
            if cushioned:
                stated.append(_cushioned(dict.fromkeys(j.partition(":")[0] for j in joints)))
            told = steel or (cushioned and _is_cushioned(result))
            command = "" if told else command_with(result, *stated)
            yield Way(settles, text, command, None if told else _again(result))


def _by_mesh(result: DesignResult, check: Check, settles: str, part: PartResult) -> Iterator[Way]:
    """Where a smaller numerical bar leaves the limit on one side."""
    if not part.meshes or not check.method.startswith(SOLID):
        return
    share, more = mesh_that_settles(check)
    unknowns = float(part.meshes[-1]["unknowns"])
    if not share or unknowns * more > _TOO_MANY:
        return
    allowed = [f"mesh.most_unknowns={int(ceil(unknowns * more / 1e4) * 10_000)}"]
    solid = next((tried for tried in part.rungs if tried.rung == SOLID), None)
    yield Way(
        settles,
        f"ask for a numerical error bar of {100 * share:.2g} %",
        command_with(
            result,
            f'accuracy="{100 * share:.2g} %"',
            *(allowed if unknowns * more > _MOST_UNKNOWNS else ()),
        ),
        None if solid is None else more * solid.seconds,
    )


def mesh_that_settles(check: Check) -> tuple[float, float]:
    """The numerical bar, over the value, with which an open check passes or fails; 0 if none does.

    And how many times the unknowns of its mesh a finer one is expected to need for it.
    """
    if not check.settled_by_mesh:
        return 0.0, inf
    limit = check.limit / check.required
    left = max(limit - check.value - check.model, check.value - check.below - limit) / check.value
    share = _two_digits_down(left)
    more = (check.numerical / (left * check.value)) ** _UNKNOWNS_BY_ERROR
    return (share, more) if share >= _FINEST else (0.0, inf)


def _by_model(result: DesignResult, check: Check, settles: str, part: PartResult) -> Iterator[Way]:
    """Where a better model may settle it."""
    tried: Sequence[RungTried] = part.rungs
    if not tried or check.kind not in tried[-1].left or check.method.startswith(SOLID):
        return
    expected = tried[-1].expected
    if tried[-1].why.startswith(TOO_MANY):
        why, _, cure = tried[-1].why.partition("; it may settle")[0].partition("; ")
        yield Way(settles, f"let a solid judge it: {why}, so {cure}")
        return
    if any(one.rung == SOLID and not one.expected for one in tried):
        return  # the solid gave up
    fidelity = "" if expected or _asked(result) else f" --fidelity {SOLID}"
    yield Way(
        settles,
        "let a solid judge it"
        + ("" if expected else f"; ballesta plan {quote(result.file)} tells its time"),
        _bare(result) + fidelity,
        expected + _again(result) if expected else None,
    )


def _of_gate(result: DesignResult, gate: Gate) -> Iterator[Way]:
    if gate.holds or not gate.binding:
        return
    if gate.key:
        yield Way(gate.name, gate.cure, command_with(result, gate.key), _again(result))
    else:
        said = gate.cure or f"{NOTHING}: {gate_sentence(gate)}"
        yield Way(gate.name, said)


def _again(result: DesignResult) -> float:
    """Time, s, of such a check once more."""
    return sum(result.timings.values())


def command_with(result: DesignResult, *overrides: str) -> str:
    """The command of a result's check with further overrides."""
    return " ".join([result.command, *(f"--set {quote(one)}" for one in overrides)])


def _asked(result: DesignResult) -> bool:
    """True if the command asks for a model below the one that `auto` would climb to."""
    return "--fidelity" in result.command


def _bare(result: DesignResult) -> str:
    """The command without its limit of time and its model."""
    return re.sub(r" --(?:within|fidelity)[ =]\S+", "", result.command)


def _two_digits_down(value: float) -> float:
    if not value > 0.0 or not isfinite(value):
        return 0.0
    step = 10.0 ** (floor(log10(value)) - 1)
    return floor(value / step + 1e-9) * step

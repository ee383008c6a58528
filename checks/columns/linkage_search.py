"""The least buckling factor of a linkage over its positions, as a frame of so many pieces a bar.

The frames of all positions are searched coarse to fine: what cannot be the lowest is left out by
bounds, and only what has the lowest but for round-off is proven.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple, Self

import numpy as np

import loads
from checks.columns.link_joints import (
    JointRows,
    LinkModel,
    Place,
    Together,
    forces_of,
    link_model,
    shafts,
    together,
)
from checks.design.data import Design
from checks.part.part_loads import labels_of
from fem.frame import FrameModes, LooseFrameError
from fem.frame_joints import IN_PLANE, OUT_OF_PLANE
from geometry.mesh import FloatArray, IntArray

_COARSE_ERROR = 0.03  # of a factor, how much higher the coarse frame may be than the fine one
_RANKED = 40  # positions of a cycle that are asked at first, besides those of largest forces
_ROUND_OFF = 1e-9  # of a factor
_SHARE_DIGITS = 6  # of strain energy: of bodies alike in a symmetric linkage the first is told
_NEAR = 0.95  # of the largest share: about which of these all positions are asked
_APART = 1e6  # how much stiffer one bar is than another where digits of the soft one are lost
_PLANES = {"in plane": IN_PLANE, "out of plane": OUT_OF_PLANE}


class Case(NamedTuple):
    """A plane and which forks; in the plane they make no difference."""

    plane: str
    stiff: bool


CASES = IN, SOFT, STIFF = (
    Case("in plane", False),
    Case("out of plane", False),
    Case("out of plane", True),
)


class LooseError(loads.LinkageError):
    """A frame that can move without strain.

    apart  True if that may be round-off, as its bars are too unlike
    """

    def __init__(self, text: str, apart: bool) -> None:
        super().__init__(text, apart)
        self.text, self.apart = text, apart

    def __str__(self) -> str:
        return self.text


@dataclass(frozen=True, eq=False)
class LinkageMode:
    """The lowest buckling mode of a linkage over all positions.

    factor            load factor, forks as stated, or soft
    plane             "in plane" or "out of plane"
    forks             as the design states them; None where it does not
    stiff_factor      lowest over all positions in either plane, forks stiff; None: none above 0
    error             of the factor, by its change from 8 to 16 pieces per bar; no less than its
                      round-off
    rise              of 1/factor, what it may be more between this position and its neighbours
    cycle, index      where it is; `position` is that in words
    other_plane       the same in the other plane, forks as of `factor`; None: none above 0
    shares            body -> share of the strain energy of the mode
    body              the bar in compression with the largest share, None if none is compressed
    compression       of that body, N
    effective_length  mm, of a hinged column of its section at mid-length with that factor
    rigid             bodies that are no bars
    slots_hold        whether slots hold sideways even with soft forks, as something is loose else
    loose             whether unstated forks are stiff, as something is loose with soft ones
    shape             body -> (n, 6) mm and rad, displacement and turn at `places` (n, 2) mm, the
                      largest displacement 1; ground axes
    """

    factor: float
    plane: str
    forks: str | None
    stiff_factor: float | None
    error: float
    rise: float
    cycle: str
    index: int
    position: str
    other_plane: float | None
    shares: Mapping[str, float]
    body: str | None
    compression: float
    effective_length: float | None
    rigid: tuple[str, ...]
    slots_hold: bool
    loose: bool
    places: Mapping[str, FloatArray]
    shape: Mapping[str, FloatArray]

    def under(self, load_factor: float) -> Self:
        """The mode where all loads are multiplied by a load factor."""
        return replace(
            self,
            factor=self.factor / load_factor,
            stiff_factor=None if self.stiff_factor is None else self.stiff_factor / load_factor,
            error=self.error / load_factor,
            rise=self.rise * load_factor,
            other_plane=None if self.other_plane is None else self.other_plane / load_factor,
            compression=self.compression * load_factor,
        )


class FreeMotions:
    """Motions that a linkage's joints leave free, by frame, pose and case.

    Runs of a machine in doubt share them: their loads differ, poses and joints do not.
    """

    def __init__(self) -> None:
        self._found: dict[tuple[object, ...], FloatArray] = {}

    def of(
        self,
        keys: Sequence[tuple[object, ...]],
        solve: Callable[[Sequence[int]], Sequence[FloatArray]],
    ) -> list[FloatArray]:
        """Motions of unit stiffness by key; those that are not there yet are solved, by number."""
        first = {key: n for n, key in reversed(list(enumerate(keys))) if key not in self._found}
        if first:
            self._found |= zip(first, solve(list(first.values())), strict=True)
        return [self._found[key] for key in keys]


def _spread(run: loads.CycleLoads, stride: int, sizes: FloatArray) -> IntArray:
    """Every so many-th position of a cycle, the ends of its phases, and where a force is largest.

    sizes  (n, c) N, forces over the cycle
    """
    borders = np.flatnonzero(np.diff(run.phase_of))
    ends = [0, *borders, *(borders + 1), len(run.positions) - 1]
    peaks = [*sizes.argmax(axis=0), *sizes.argmin(axis=0)]
    return np.unique([*range(0, len(run.positions), stride), *ends, *peaks])


def _largest_inverse(reduced: FloatArray) -> float:
    """1/factor of the lowest mode of whitened -K_s (m, m); 0 where there is none."""
    values = np.linalg.eigvalsh(reduced)
    return float(values[-1]) if values[-1] > 1e-9 * np.abs(values).max() else 0.0


def _is_below(reduced: FloatArray, inverse: float) -> bool:
    """True if no mode of whitened -K_s (m, m) has a 1/factor as large, for less than the modes."""
    try:
        np.linalg.cholesky(inverse * np.eye(len(reduced)) - reduced)
    except np.linalg.LinAlgError:
        return False
    return True


class Search:
    """The frames of all positions with one number of pieces per bar."""

    def __init__(
        self,
        design: Design,
        cycles: Mapping[str, loads.CycleLoads],
        pieces: int,
        motions: FreeMotions | None = None,
        cases: Sequence[Case] = CASES,
        *,
        slots_hold: bool = False,
        loose: bool = False,
    ) -> None:
        self._design, self._cycles = design, cycles
        self.slots_hold, self.loose = slots_hold, loose
        self._cases = cases
        first = next(iter(cycles.values()))
        self.model: LinkModel = link_model(design, first.linkage, pieces)
        turning = shafts(cycles.values())
        self._forces = {
            name: forces_of(self.model, JointRows(self.model, run, slots_hold, turning))
            for name, run in cycles.items()
        }
        self._poses: dict[Place, tuple[object, ...]] = {}
        self._motions = FreeMotions() if motions is None else motions
        points = tuple((body.name, *body.points.items()) for body in first.linkage.bodies)
        self._frame = pieces, slots_hold, turning, points, first.linkage.joints
        self._sizes = {
            name: float(np.ptp(run.poses[:, :, :2])) or 1.0 for name, run in cycles.items()
        }

    def ranked(self) -> dict[Case, list[tuple[float, Place]]]:
        """1/factor and place by case, largest first; cases without a factor above 0 are left out.

        Left out are those whose 1/factor cannot come near the largest, as the matrix's norm shows.
        Of many positions some are asked that are spread evenly, the ends of phases and the largest
        forces among them, and then all about those that come near the largest; a cycle's positions
        lie as dense as its loads change. Raises loads.LinkageError where something moves without
        strain.
        """
        found: dict[Case, list[tuple[float, Place]]] = {}
        strides = {name: -(-len(run.positions) // _RANKED) for name, run in self._cycles.items()}
        spread = {
            name: _spread(run, strides[name], self._forces[name].sizes)
            for name, run in self._cycles.items()
        }
        self._rank(found, [(name, int(k)) for name, some in spread.items() for k in some])
        about: dict[Place, None] = {}
        for places in found.values():
            largest = max((value for value, _ in places), default=0.0)
            for name, k in (place for value, place in places if value >= _NEAR * largest):
                last, stride = len(self._cycles[name].positions), strides[name]
                near = np.arange(max(0, k - stride + 1), min(last, k + stride))
                left = np.setdiff1d(near, spread[name])
                about |= dict.fromkeys((name, int(j)) for j in left)
        self._rank(found, list(about))
        return {case: sorted(places, reverse=True) for case, places in found.items() if places}

    def _rank(self, found: dict[Case, list[tuple[float, Place]]], places: Sequence[Place]) -> None:
        """Add 1/factor and place of the places that come near the largest so far.

        The cycle of the largest force comes first. Stiff forks hold whatever soft ones hold, and
        more: by Rayleigh's quotient 1/factor is not larger with them, so they are asked where soft
        ones leave a chance.
        """
        largest = {
            case: max((value for value, _ in found.get(case, ())), default=0.0)
            for case in self._cases
        }

        def force(place: Place) -> float:
            return float(np.abs(self._forces[place[0]].sizes[place[1]]).max())

        for some in together(self._forces, sorted(places, key=force, reverse=True)):
            soft = np.full(len(some.positions), np.inf)
            for case in largest:
                asked = np.flatnonzero(soft > _NEAR * largest[case])
                if case != STIFF:
                    asked = np.arange(len(soft))
                values = self._values(some, asked, case, largest[case])
                if case == SOFT:
                    soft = values
                largest[case] = max(largest[case], float(values[asked].max(initial=0.0)))
                ranked = [(float(values[n]), some.places[n]) for n in asked]
                near = [one for one in ranked if one[0] > 0 and one[0] > _NEAR * largest[case]]
                found.setdefault(case, []).extend(near)

    def _values(self, some: Together, asked: IntArray, case: Case, largest: float) -> FloatArray:
        """1/factor (p,), or an upper bound of it where that is not near the largest; 0: not asked.

        largest  1/factor so far
        """
        values = np.zeros(len(some.positions))
        reduced = dict(zip(asked, self._reduced(some, asked, case), strict=True))
        for n, one in reduced.items():
            values[n] = np.linalg.norm(one)
        for n in sorted(asked, key=values.__getitem__, reverse=True):
            if values[n] > _NEAR * largest:
                values[n] = _largest_inverse(reduced[n])
                largest = max(largest, float(values[n]))
        return values

    def lowest(self, case: Case, ranked: Sequence[tuple[float, Place]]) -> tuple[float, str, int]:
        """The lowest factor, its cycle and position, of those ranked on a coarser frame.

        That none is lower costs less than all eigenvalues of a position, and they less than a mode
        that is proven: only what has the lowest but for round-off is.
        """
        near = [place for inverse, place in ranked if inverse * (1 + _COARSE_ERROR) > ranked[0][0]]
        found = self.largest_inverses(near, case)
        largest = max(found.values())
        best: tuple[float, str, int] = (np.inf, *ranked[0][1])
        for (name, k), inverse in found.items():
            if inverse > (1 - _ROUND_OFF) * largest:
                factor = self.factor(name, k, case)
                if factor is not None:
                    best = min(best, (factor, name, k))
        return best

    def largest_inverses(self, places: Sequence[Place], case: Case) -> dict[Place, float]:
        """1/factor of the lowest modes by place; 0 for none, and for those below another's."""
        found, largest = {}, 0.0
        for some in together(self._forces, places):
            every = np.arange(len(some.positions))
            for place, reduced in zip(some.places, self._reduced(some, every, case), strict=True):
                below = largest > 0 and _is_below(reduced, (1 - _ROUND_OFF) * largest)
                found[place] = 0.0 if below else _largest_inverse(reduced)
                largest = max(largest, found[place])
        return found

    def _reduced(self, some: Together, asked: IntArray, case: Case) -> list[FloatArray]:
        """-X' K_s X (m, m) of the motions X of unit stiffness, of some of the positions."""
        own = some.placed.unknowns(_PLANES[case.plane])
        geometric = some.geometric[np.ix_(asked, own, own)]
        moves = self._moves(some, asked, case)
        return [-x.T @ one @ x for x, one in zip(moves, geometric, strict=True)]

    def _pose(self, name: str, k: int) -> tuple[object, ...]:
        """Pose to a billionth of the linkage's size, and pace: all that motions depend on."""
        if (name, k) not in self._poses:
            run, size = self._cycles[name], self._sizes[name]
            pose = np.round(run.poses[k] / np.array([size, size, 1.0]) * 1e9).astype(np.int64)
            self._poses[name, k] = run.pace, size, pose.tobytes()
        return self._poses[name, k]

    def _moves(self, some: Together, asked: IntArray, case: Case) -> list[FloatArray]:
        """Motions (n, m) of unit stiffness that the joints leave free, of some of the positions."""

        def solve(those: Sequence[int]) -> Sequence[FloatArray]:
            own = asked[list(those)]
            rows = some.rows(stiff=case.stiff)[own]
            try:
                return some.placed.at(own).unit_motions(rows, _PLANES[case.plane])
            except LooseFrameError as error:
                raise self._loose(case.plane, error) from error

        keys = [(self._frame, self._pose(*some.places[n]), case) for n in asked]
        return self._motions.of(keys, solve)

    def _loose(self, plane: str, error: LooseFrameError) -> LooseError:
        """The error of a frame that moves without strain, with bars of very unlike stiffness."""
        stiffness = {
            self.model.links[n].name: self.model.bending(n, plane)
            / (bar.main[1] - bar.main[0]) ** 3
            for n, bar in self.model.bars.items()
        }
        stiff, soft = (pick(stiffness, key=stiffness.__getitem__) for pick in (max, min))
        ratio = stiffness[stiff] / stiffness[soft]
        apart = ""
        if ratio > _APART:
            apart = (
                f", as far as double precision tells: {stiff} is {ratio:.1g} times as stiff "
                f"against bending as {soft}; check the sections and lengths of both"
            )
        cure = ""
        if self._design.forks == "soft" and not apart:
            cure = (
                " where no pin holds its bodies against tilting (soft forks); where bearings or "
                'cheeks hold them, state forks = "stiff"'
            )
        return LooseError(f"buckling of the linkage, {plane}: {error}{apart}{cure}", bool(apart))

    def _modes(self, name: str, k: int, case: Case) -> FrameModes:
        here = Together(name, self._forces[name], np.array([k]))
        rows = here.rows(stiff=case.stiff)[0]
        try:
            return here.placed.at(0).buckling(rows, here.geometric[0], _PLANES[case.plane])
        except LooseFrameError as error:
            raise self._loose(case.plane, error) from error

    def factor(self, name: str, k: int, case: Case) -> float | None:
        """The lowest factor of a position in a case, proven to be the lowest; None for none."""
        factors = self._modes(name, k, case).factors
        return float(factors[0]) if len(factors) else None

    def rise(self, name: str, k: int, case: Case, factor: float) -> float:
        """Rise of 1/factor between a position and its neighbours, by the parabola through them.

        A smooth peak over three positions is at most an eighth of the second difference higher.
        """
        run = self._cycles[name]
        if not 0 < k < len(run.positions) - 1 or run.phase_of[k - 1] != run.phase_of[k + 1]:
            return 0.0
        beside = [self.factor(name, other, case) for other in (k - 1, k + 1)]
        before, after = (0.0 if one is None else 1 / one for one in beside)
        return max(0.0, 2 / factor - before - after) / 8

    def told(
        self,
        name: str,
        k: int,
        case: Case,
        *,
        error: float,
        rise: float,
        other: float | None,
        stiff: float | None,
    ) -> LinkageMode:
        """Everything about the lowest mode of a position."""
        modes = self._modes(name, k, case)
        factor, shape = float(modes.factors[0]), modes.shapes[:, 0]
        placed = self.model.placed(self._cycles[name].poses[k])
        forces = self._forces[name]
        strain = placed.stiffness * shape[:, None] * shape
        parts = {link.name: placed.part(n) for n, link in enumerate(placed.links)}
        energy = {body: float(strain[np.ix_(own, own)].sum()) for body, own in parts.items()}
        total = sum(energy.values())
        pressed = {n: float(-bar.axial(k).min()) for n, bar in forces.bars.items()}
        number = max(
            (n for n in pressed if pressed[n] > 0),
            key=lambda n: round(energy[placed.links[n].name] / total, _SHARE_DIGITS),
            default=None,
        )
        body, compression, length = None, 0.0, None
        if number is not None:
            body, compression = placed.links[number].name, pressed[number]
            bending = self.model.bending(number, case.plane)
            length = float(np.pi * np.sqrt(bending / (factor * compression)))
        places, moved = self.model.moved(placed, shape)
        return LinkageMode(
            factor=factor,
            plane=case.plane,
            forks=self._design.forks,
            stiff_factor=stiff,
            error=max(error, factor * modes.round_off),
            rise=rise,
            cycle=name,
            index=k,
            position=labels_of(self._design, name, self._cycles[name])[k],
            other_plane=other,
            shares={name: value / total for name, value in energy.items()},
            body=body,
            compression=compression,
            effective_length=length,
            rigid=tuple(
                link.name for n, link in enumerate(placed.links) if n not in self.model.bars
            ),
            slots_hold=self.slots_hold,
            loose=self.loose,
            places=places,
            shape=moved,
        )

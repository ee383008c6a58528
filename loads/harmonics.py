"""Vibration added to a cycle of loads that was solved without it, harmonic by harmonic.

The loads of a cycle that runs again and again deform each mode of the linkage by an amount a(t),
as if slowly (loads over stiffness). Its harmonics h of the cycle's rate come out multiplied by
1 / (1 - r^2 + 2 i zeta r), r = h / (T f), f the mode's frequency and zeta its damping ratio (Clough
and Penzien, Dynamics of Structures, ch. 4). The square of a is twice the mode's elastic energy.
"""

from dataclasses import dataclass

import numpy as np

from loads.bodies import FloatArray, IntArray, LinkageError
from loads.cycle_loads import CycleLoads
from loads.vibration import (
    LinkageModes,
    closes,
    cycle_modes,
    followed,
    load_strains,
    with_body_loads,
)

ComplexArray = np.typing.NDArray[np.complex128]

SAMPLES = 4096  # of a period
_BETWEEN = 41  # frequencies tried between the lowest and the highest of a mode
_NEAR = 8  # strongest harmonics in that range, each tried in resonance
_SLOW = 4.0  # periods of a mode in which a jump that has no stated time is taken to rise, but
_OF_GAP, _OF_PERIOD = 0.1, 0.05  # never more of the least time between two, and of the cycle
_JUMPS = 0.01  # of a mode's largest response: steps below it are no jumps
_MODES = 6
_TOLD = 8  # harmonics of a mode that are told, the strongest


def dynamic_factor(ratio: FloatArray | float, damping: float) -> ComplexArray:
    """Return dynamic over static response for a ratio r of exciting to natural frequency.

    >>> [round(complex(dynamic_factor(h * 10 / (5.73 * 2 * np.pi), 0.0)).real, 1) for h in (3, 4)]
    [3.3, -4.3]
    """
    ratio = np.asarray(ratio, dtype=float)
    return np.asarray(1.0 / (1.0 - ratio**2 + 2j * damping * ratio), dtype=complex)


@dataclass(frozen=True)
class Harmonic:
    """One harmonic of a mode's response to a cycle.

    number     of the cycle's rate; halves in a mode that comes back reversed after a cycle
    amplitude  half its range, over the largest response of the mode
    factor     its amplification by vibration, at the frequency that is worst for the mode
    """

    number: float
    amplitude: float
    factor: float


@dataclass(frozen=True, eq=False)
class ModeResponse:
    """Response of one mode, without and with vibration, over a cycle that runs again and again.

    mode           1 is the softest at the start of the cycle
    lowest, highest  Hz, of its frequency over the cycle
    share          its largest response over the whole linkage's: square roots of energy
    jump           largest step of its response, over its largest response
    rise           s, in which its jumps are taken to go
    worst          Hz, frequency in its range at which the deviation is largest
    amplification  largest response with vibration over largest without, there
    deviation      largest difference with and without at any time, over the largest without, there
    harmonics      the strongest, by number
    times, slow, dynamic  (samples,) s over the cycle, and response without and with vibration
    """

    mode: int
    lowest: float
    highest: float
    share: float
    jump: float
    rise: float
    worst: float
    amplification: float
    deviation: float
    harmonics: tuple[Harmonic, ...]
    times: FloatArray
    slow: FloatArray
    dynamic: FloatArray


@dataclass(frozen=True, eq=False)
class CycleResponse:
    """Response of a cycle to vibration.

    modes      of the linkage at the cycle's positions, from which the response was found
    period     s, of the cycle
    damping    ratio, of every mode
    responses  of the softest modes
    columns, signs  (n, count) where each of them is among the modes at each position
    step       s, the longest between two positions of the cycle
    """

    modes: LinkageModes
    period: float
    damping: float
    responses: tuple[ModeResponse, ...]
    columns: IntArray
    signs: FloatArray
    step: float = 0.0


def cycle_response(
    cycle: CycleLoads, damping: float, rise: float | None = None, modes: LinkageModes | None = None
) -> CycleResponse:
    """Return the response to vibration of a solved cycle that closes.

    rise   s, in which loads that jump really change; None: as `rise_of` has it
    modes  of this cycle, if they are known (`cycle_modes`)

    The linkage is held at the coordinate of its pace. A contact counts as a load, not as a support.
    A mode's frequency is taken constant over the cycle, with that value of its range that is worst.
    Raises LinkageError for a cycle that does not close, and where a mode cannot be followed.
    """
    if not damping > 0.0:
        raise LinkageError(
            f"the damping ratio must be above 0, got {damping:g}: nothing else limits a resonance"
        )
    if not closes(cycle):
        raise LinkageError(
            f"cycle {cycle.name!r} does not end where it starts, so it has no harmonics"
        )
    found = cycle_modes(cycle) if modes is None else modes
    count = min(_MODES, int(np.isfinite(found.frequencies).all(axis=0).sum()))
    columns, signs, back = followed(found, count)
    strains = load_strains(found, cycle)
    largest = float(np.linalg.norm(strains, axis=1).max())
    rows = np.arange(len(strains))
    responses = []
    for k in range(count):
        shape = found.strains[rows, :, columns[:, k]] * signs[:, k, None]
        values = np.einsum("nr,nr->n", shape, strains)
        frequency = found.frequencies[rows, columns[:, k]]
        if not np.isfinite(frequency).all():
            raise LinkageError(
                f"mode {k + 1} of the linkage is too stiff beside the softest one to be followed "
                f"through the cycle {cycle.name!r}"
            )
        if back[k] == 0.0 and np.abs(values).max() > 1e-3 * largest:
            raise LinkageError(
                f"mode {k + 1} of the linkage comes back as another one after the cycle "
                f"{cycle.name!r}; its response has no harmonics"
            )
        responses.append(
            _response(k + 1, cycle.times, values, frequency, damping, rise, largest, back[k])
        )
    return CycleResponse(
        found,
        float(cycle.times[-1]),
        damping,
        tuple(responses),
        columns,
        signs,
        float(np.diff(cycle.times).max()),
    )


def _response(
    mode: int,
    times: FloatArray,
    values: FloatArray,
    frequency: FloatArray,
    damping: float,
    rise: float | None,
    largest: float,
    back: float,
) -> ModeResponse:
    lowest, highest = float(frequency.min()), float(frequency.max())
    period = float(times[-1])
    if back < 0.0:  # the shape comes back reversed: it repeats after two cycles
        times, values = np.concatenate([times, times + period]), np.concatenate([values, -values])
    ramp = rise_of(times, values, lowest, period) if rise is None else rise
    at, slow, jump = sampled(times, values, ramp)
    top = float(np.abs(slow).max()) or 1.0
    coefficients = np.fft.rfft(slow)
    rate = 1.0 / float(times[-1])
    tried = _frequencies(lowest, highest, rate, np.abs(coefficients))
    ratios = np.arange(len(coefficients)) * rate / tried[:, None]
    responses = np.fft.irfft(coefficients * dynamic_factor(ratios, damping), len(slow), axis=1)
    deviations = np.abs(responses - slow).max(axis=1) / top
    worst = int(deviations.argmax())
    amplitudes = 2.0 * np.abs(coefficients) / len(slow) / top
    amplitudes[0] = 0.0
    strongest = sorted(np.argsort(amplitudes)[::-1][:_TOLD])
    factors = np.abs(dynamic_factor(ratios[worst], damping))
    turns = 1 if back >= 0.0 else 2
    keep = slice(0, SAMPLES // turns + 1)  # one cycle, its end too
    at, slow, dynamic = (
        np.append(at, times[-1]),
        np.append(slow, slow[0]),
        np.append(responses[worst], responses[worst, 0]),
    )
    return ModeResponse(
        mode=mode,
        lowest=lowest,
        highest=highest,
        share=float(np.abs(values).max()) / (largest or 1.0),
        jump=jump / top,
        rise=ramp,
        worst=float(tried[worst]),
        amplification=float(np.abs(responses[worst]).max()) / top,
        deviation=float(deviations[worst]),
        harmonics=tuple(
            Harmonic(float(h) / turns, float(amplitudes[h]), float(factors[h]))
            for h in strongest
            if amplitudes[h] > 0.0
        ),
        times=at[keep],
        slow=slow[keep],
        dynamic=dynamic[keep],
    )


def _frequencies(lowest: float, highest: float, rate: float, sizes: FloatArray) -> FloatArray:
    """Return frequencies to try for a mode: its range, and its resonances there."""
    numbers = np.arange(len(sizes))
    inside = numbers[(numbers * rate >= lowest) & (numbers * rate <= highest) & (numbers > 0)]
    chosen = inside[np.argsort(sizes[inside])[::-1][:_NEAR]]
    return np.concatenate([np.linspace(lowest, highest, _BETWEEN), chosen * rate])


def rise_of(times: FloatArray, values: FloatArray, frequency: float, period: float) -> float:
    """Return the time in s that jumps are taken to rise in where none is stated.

    Four periods of the mode hardly excite it, but a rise as long as the load stays would take away
    the load itself: so no more than a tenth of the least time between two jumps, and 5 % of the
    cycle's `period`. The signal (n,), times as for `sampled`, may be longer than a cycle.
    """
    at, jumps = _jumps_of(times, values)
    at = at[np.abs(jumps) > _JUMPS * np.abs(values).max()]
    length = float(times[-1])
    gaps = np.diff(at, append=at[:1] + length)
    least = float(gaps.min(initial=length))
    return min(_SLOW / frequency, _OF_GAP * least, _OF_PERIOD * period)


def _jumps_of(times: FloatArray, values: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return times and heights of the jumps of a periodic signal, the jump at its end last."""
    inside = np.flatnonzero(np.diff(times) <= 1e-12 * float(times[-1]))
    at = np.append(times[inside], times[-1])
    return at, np.append(values[inside + 1] - values[inside], values[0] - values[-1])


def sampled(
    times: FloatArray, values: FloatArray, rise: float, *, smooth: bool = False
) -> tuple[FloatArray, FloatArray, float]:
    """Return even times (SAMPLES,) of one period, values there, and the largest jump of them.

    times  (n,) s from 0, one of them twice where the values jump there; they also jump where the
           end does not meet the start
    rise   s, in which jumps go by a half wave of a cosine, centred where they are
    smooth  True for cubic splines between the values: their rates are wanted, too
    """
    period = float(times[-1])
    at, jumps = _jumps_of(times, values)
    even = np.arange(SAMPLES) * period / SAMPLES
    # without its jumps the signal is continuous, and the order of equal times does not matter
    steps = np.zeros(len(times))
    steps[1:][np.diff(times) <= 1e-12 * period] = jumps[:-1]
    rest = values - np.cumsum(steps)
    if smooth:
        from scipy.interpolate import CubicSpline

        apart = np.append(True, np.diff(times) > 1e-9 * period)
        result = CubicSpline(times[apart], rest[apart])(even)
    else:
        result = np.interp(even, times, rest)
    # the same jump of the cycles before and after, as far as its rise reaches
    turns = max(1, int(np.ceil(rise / (2.0 * period))))
    others = period * np.arange(-turns, turns + 1)
    for where, jump in zip(at, jumps, strict=True):
        shift = even[:, None] - where - others
        result += jump * (_ramp(shift, rise).sum(axis=1) - turns)
    return even, result, float(np.abs(jumps).max())


def with_vibration(cycle: CycleLoads, response: CycleResponse) -> CycleLoads:
    """Return the cycle with the loads of vibration added, equilibrium kept.

    Elastic inertia and damping of every mode are loads M phi omega (a_dynamic - a_slow) on the
    lumps, which deform the mode by what its response differs. They change joint forces, the effort
    of the drive and the accelerations of the bodies, not poses and velocities. Raises LinkageError
    where no force acts along the coordinate that sets the pace.
    """
    modes = response.modes
    rows = np.arange(len(cycle.times))
    lumped = np.zeros(modes.shapes.shape[:2])
    for k, mode in enumerate(response.responses):
        extra = np.interp(cycle.times, mode.times, mode.dynamic - mode.slow)
        own = response.columns[:, k]
        omega = 2.0 * np.pi * modes.frequencies[rows, own]
        shape = modes.shapes[rows, :, own] * response.signs[:, k, None]
        lumped += modes.lumps.masses * shape * (omega * extra)[:, None]
    return with_body_loads(modes, cycle, lumped)


def _ramp(times: FloatArray, rise: float) -> FloatArray:
    """Return 0 before and 1 after a rise about 0, half a cosine wave between; a step is 1 at 0."""
    if rise <= 0.0:
        return np.heaviside(times, 1.0)
    share = np.clip(times / rise, -0.5, 0.5)
    return 0.5 + 0.5 * np.sin(np.pi * share)

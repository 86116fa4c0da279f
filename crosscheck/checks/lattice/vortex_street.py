"""A plate across the flow sheds vortices in turn."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from crosscheck.checks.base import Check, Laboratory, full
from crosscheck.checks.lattice.flow_fields import MODEL, mean_velocity, vorticity_map
from crosscheck.checks.lattice.gases import LATTICE, filled, gas_scene, populations
from crosscheck.checks.lattice.waves import shear_wave_viscosities
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.figure import Figure, Series
from crosscheck.references import lattice_gas as known
from crosscheck.references.lattice_models import VELOCITIES
from crosscheck.references.vortex_street import plate_drag, plate_strouhal
from crosscheck.scene import Floats, Obstacle, Output, Wave
from crosscheck.statistics import independent_mean, standard_error
from crosscheck.verdict import Judged, Judgement, bounded, statistical, worst

ROWS, COLUMNS, PLATE, BLOCK = 1024, 2048, 128, 16
#: The field is 2048 links long and this high.
HEIGHT = ROWS * VELOCITIES[MODEL].row_height
WARM, STEPS, EVERY = 20_000, 44_000, 100


class _Wake(NamedTuple):
    """The wake of the plate, in links and steps.

    times: (samples,). signals: velocity across the wake at two places, each (samples,). mean_speed: of the flow. force:
    on all of the gas, per step. density: particles a site of gas. last: the last velocity field.
    """

    times: Floats
    signals: list[Floats]
    mean_speed: float
    force: float
    density: float
    last: Floats


def _wake(laboratory: Laboratory, density: float) -> _Wake:
    """Runs the gas past the plate.

    The wake comes back to the plate through the periodic ends. A honeycomb of smooth plates along the flow, without
    drag, takes its vortices away, as in a wind tunnel.
    """
    half, middle, place = int(PLATE / VELOCITIES[MODEL].row_height / 2), ROWS // 2, COLUMNS // 4 + 64
    scene = gas_scene(
        "plate",
        MODEL,
        ROWS,
        COLUMNS,
        WARM + STEPS,
        filled(
            density,
            laboratory.seed(),
            velocity_x=0.28,
            waves=(Wave(of="velocity_y", amplitude=0.08, mode=(4.0, 0.0)),),
        ),
        Output(interval=EVERY, observables=("populations", "force_impulse"), fields=(COLUMNS // BLOCK, ROWS // BLOCK)),
        obstacles=(
            Obstacle(columns=(place, place + 3), rows=(middle - half, middle + half - 1)),
            *(Obstacle(columns=(0, 159), rows=(row, row), rule="specular_y") for row in range(0, ROWS, 16)),
        ),
        force=6e-5,
    )
    run = laboratory.run(scene, LATTICE)
    counts = populations(run)[WARM // EVERY :]
    velocity = mean_velocity(counts)
    given = run["force_impulse"].sum(axis=1)
    behind, centre = (place + 2 * PLATE) // BLOCK, middle // BLOCK
    signals = [
        np.nanmean(velocity[:, at - 1 : at + 2, centre - 1 : centre + 1, 1], axis=(1, 2))
        for at in (behind, behind + PLATE // BLOCK)
    ]
    times = np.arange(len(signals[0])) * float(EVERY)
    force = float(given[-1] - given[WARM // EVERY]) / STEPS
    middle_of_all = float(np.median(counts[-1].sum(axis=-1))) / BLOCK**2
    return _Wake(times, signals, float(np.nanmean(velocity[..., 0])), force, middle_of_all, velocity[-1])


def _judgements(wake: _Wake, g: float) -> list[Judgement]:
    """One line in the spectrum of either signal, and the Strouhal number; g: factor of the advection."""
    frequencies, shares = zip(*(_line(wake.times, signal) for signal in wake.signals), strict=True)
    duration = wake.times[-1]
    strouhal = frequencies[0] * PLATE / (g * wake.mean_speed)
    expected = plate_strouhal(PLATE / HEIGHT)
    turns, error = _turning(wake.times, wake.signals[0], frequencies[0])
    area = VELOCITIES[MODEL].row_height
    drag = 2 * wake.force / (wake.density / area * g * wake.mean_speed**2 * PLATE)
    least, most = plate_drag(PLATE / HEIGHT)
    why = "of normal plates in two dimensions, up to 1/(1 - blockage)^2 times as much in a row: the flow is that fast"
    return [
        bounded(
            "share of the line in the variance of the velocity across the wake",
            min(shares),
            0.5,
            "a street is periodic: noise, and a wake that meets itself, have no line with half of the variance",
            at_least=True,
        ),
        bounded(
            "velocity across the wake, rms, over that of the flow",
            float(wake.signals[0].std()) / wake.mean_speed,
            0.4,
            "vortices turn the wake by as much as the flow itself; the push at the start was a fifth of it",
            at_least=True,
        ),
        bounded(
            "frequencies at two places, relative difference",
            abs(frequencies[0] / frequencies[1] - 1),
            1 / (frequencies[0] * duration) / 2,
            "one street: half of the width of a line in the time of the measurement",
        ),
        statistical(
            "Strouhal number f D/(g U)",
            strouhal,
            strouhal * error,
            expected.value,
            0.0,
            f"standard error of {turns} half turns of the phase; 0.14 ... 0.18 of normal plates, up to 1/(1 - "
            "blockage) times as much in a row of them; one of the speed u in place of g u must be seen",
            samples=turns,
            doubt=expected.doubt,
            needed=0.4,
            note=f"period {1 / frequencies[0]:.0f} steps",
        ),
        bounded("drag coefficient 2 F/(rho g U^2 D), at least", drag, least, why, at_least=True),
        bounded("drag coefficient 2 F/(rho g U^2 D)", drag, most, why),
    ]


def _judge(laboratory: Laboratory, density: float) -> Judged:
    """Frequency of the street by the velocity across the wake."""
    wake = _wake(laboratory, density)
    g = known.galilean_factor(MODEL, density)
    nu, _ = independent_mean(shear_wave_viscosities(laboratory, MODEL, density, 128))
    figures = (
        vorticity_map(f"Vortex street behind a plate, d = {density:g}", wake.last, (float(COLUMNS), HEIGHT), 8),
        Figure(
            "Velocity across the wake",
            "step",
            "v_y",
            series=(Series(f"d = {density:g}", wake.times[::4].tolist(), wake.signals[0][::4].tolist()),),
        ),
    )
    note = (
        f"Re = g U D/nu = {g * wake.mean_speed * PLATE / nu:.0f}, U = {wake.mean_speed:.3f}, "
        f"blockage {PLATE / HEIGHT:.2f}"
    )
    return worst(_judgements(wake, g), note, figures)


def _turning(times: Floats, signal: Floats, frequency: float) -> tuple[int, float]:
    """Number of half turns of the phase of a line, and the relative standard error of its frequency.

    The phase over each half of a period, in which a wave and its conjugate do not mix, advances by pi with an error of
    its own: errors of the advances are independent, and add to that of the frequency as they are many.
    """
    length = round(0.5 / frequency / times[1])
    number = len(signal) // length
    waves = (signal - signal.mean()) * np.exp(-2j * np.pi * frequency * times)
    phases = np.unwrap(np.angle(waves[: number * length].reshape(number, length).mean(axis=1)))
    return number - 1, float(standard_error(np.diff(phases) / np.pi))


def _line(times: Floats, signal: Floats) -> tuple[float, float]:
    """Frequency of the strongest line, and the share of its fundamental in the variance."""
    from scipy.optimize import minimize_scalar

    centred = signal - signal.mean()

    def fit(frequency: float) -> float:
        waves = np.stack([np.cos(2 * np.pi * frequency * times), np.sin(2 * np.pi * frequency * times)], axis=1)
        left = centred - waves @ np.linalg.lstsq(waves, centred)[0]
        return float(left @ left)

    spectrum = np.abs(np.fft.rfft(centred * np.hanning(centred.size), 8 * centred.size))
    axis = np.fft.rfftfreq(8 * centred.size, times[1])
    first = axis[int(spectrum.argmax())]
    width = 1 / times[-1]
    best = minimize_scalar(
        fit, bounds=(first - width / 2, first + width / 2), method="bounded", options={"xatol": 1e-6 * width}
    )
    return float(best.x), 1 - fit(float(best.x)) / float(centred @ centred)


CHECKS = (
    Check(
        name="lattice/vortex-street",
        title="A plate across the flow sheds a vortex street",
        equation="St = f D/(g U); C_D = 2 F/(rho g U^2 D)",
        criterion="one line in the spectrum; Strouhal number and drag coefficient of plates normal to the flow",
        citation="Najjar & Balachandar, J. Fluid Mech. 370, 101 (1998); "
        "Fage & Johansen, Proc. R. Soc. A 116, 170 (1927)",
        judge=_judge,
        variants=full(**{f"d{density:g}": density for density in (0.2, 0.3)}),
        faults=(
            (
                "d0.3",
                Fault(
                    "no-plate",
                    "lattice/kernels/planes.py",
                    "solid = flip_x | flip_y\n",
                    "solid = flip_x & ~flip_x\n",
                    "bit planes do not see bounce-back walls",
                ),
            ),
        ),
        needs=Needs(
            "lattice_gas",
            (LATTICE,),
            words=frozenset(
                {
                    "lattice_gas.obstacles",
                    "lattice_gas.obstacles.columns",
                    "lattice_gas.obstacles.rows",
                    "lattice_gas.obstacles.rule=specular_y",
                    "lattice_gas.force",
                }
            ),
            observables=frozenset({"populations", "force_impulse"}),
        ),
    ),
)

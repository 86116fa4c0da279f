"""Orders and numbers of steps that the checks of Kepler orbits go by."""

from __future__ import annotations

from crosscheck.checks.stepping import orbits
from crosscheck.engines.protocol import Claims
from crosscheck.references import kepler


def test_gear_loses_its_order_to_the_start() -> None:
    assert orbits.nominal_order("gear5", Claims((6, 5))) == 2
    assert orbits.nominal_order("runge_kutta", Claims((4, 4))) == 4


def test_steps_divide_the_samples_and_resolve_the_pericentre() -> None:
    for e in orbits.ECCENTRICITIES:
        numbers = orbits.step_numbers(e, 0.1, 4)
        assert (numbers % orbits.SAMPLES == 0).all()
        assert orbits.PERIOD / numbers[0] * kepler.fastest(e) <= 0.1

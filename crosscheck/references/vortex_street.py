"""Frequency at which a flat plate across a flow sheds vortices.

Literature: A. Fage and F. C. Johansen, Proc. R. Soc. A 116, 170 (1927) (normal plates, Reynolds number 10^4 and more);
F. M. Najjar and S. Balachandar, J. Fluid Mech. 370, 101 (1998) (250).
"""

from __future__ import annotations

from crosscheck.references.hard_spheres import Estimate


def plate_strouhal(blockage: float) -> Estimate:
    """Strouhal number f D/U of a plate of width D normal to the flow U.

    0.14 ... 0.18 of a single plate, a range, not a standard error; in a row of plates the flow between them is faster,
    by up to 1/(1 - blockage), of which half is taken, to first order: off by as much either way. blockage: D over the
    distance of the plates, well below 1.
    """
    return Estimate(0.16 / (1 - blockage / 2), doubt=0.02 + 0.16 * blockage / 2 / (1 - blockage))


def plate_drag(blockage: float) -> tuple[float, float]:
    """Range of the drag coefficient 2 F/(rho U^2 D) of a plate of width D normal to the flow U.

    2.0 (Fage and Johansen) to 3.4 (Najjar and Balachandar's flow in two dimensions, Reynolds number 250); in a row of
    plates up to 1/(1 - blockage)^2 times as much. blockage: D over the distance of the plates, well below 1.
    """
    return 2.0, 3.4 / (1 - blockage) ** 2

"""Frequency at which a flat plate across a flow sheds vortices.

Literature: A. Fage and F. C. Johansen, Proc. R. Soc. A 116, 170 (1927) (normal plates, Reynolds number 10^4 and more);
F. M. Najjar and S. Balachandar, J. Fluid Mech. 370, 101 (1998) (250).
"""

from __future__ import annotations


def plate_strouhal(blockage: float) -> tuple[float, float]:
    """Strouhal number f D/U of a plate of width D normal to the flow U, and its uncertainty.

    0.14 ... 0.18 of a single plate; in a row of plates the flow between them is faster, by up to 1/(1 - blockage), of
    which half is taken, to first order. blockage: D over the distance of the plates, well below 1.
    """
    return 0.16 / (1 - blockage / 2), 0.02

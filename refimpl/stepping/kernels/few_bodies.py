"""Newton's gravity of a few bodies in registers: one body after another against all of them, a lane of a vector each.

`acceleration` has the equation and the bits of `plain_acceleration` in `refimpl.stepping.forces.gravity`; read that one
for the physics. Each pair is computed from both of its sides, which differ in the sign of the distance only, and the
bodies act in their order: so the terms of a body are added in the order in which the plain loop over pairs adds them.
The loop over the bodies that act is written out, for their number is part of the type. The root and the quotient of a
vector take hardly longer than those of one pair.
"""

from __future__ import annotations

from typing import Any

import llvmlite.ir as ir
from numba import types

from refimpl.stepping.kernels.registers import compiled_only, constant, joined, vectors
from refimpl.vectors import lane_everywhere, splat, square_root


@compiled_only
def acceleration(context, r, mass, z, G, softening):  # type: ignore[no-untyped-def]
    """a_i = -G sum_j m_j (r_i - r_j)/(r_ij^2 + s^2)^(3/2); see `plain_acceleration`.

    r: `Coordinates` of N bodies. mass: of N bodies along one axis.
    """

    def generate(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        lanes = r.lanes
        places, (masses,) = vectors(builder, arguments[0]), vectors(builder, arguments[1])
        strength = splat(builder, arguments[3], lanes)
        core = None
        if not isinstance(softening, types.NoneType):
            core = splat(builder, builder.fmul(arguments[4], arguments[4]), lanes)
        sums = [constant(0.0, lanes)] * r.axes
        for j in range(r.bodies):
            away = [builder.fsub(lane_everywhere(builder, x, j), x) for x in places]
            square = builder.fmul(away[0], away[0])
            for x in away[1:]:
                square = builder.fadd(square, builder.fmul(x, x))
            if core is not None:
                square = builder.fadd(square, core)
            # no force of a body on itself: the distance is 0, and its inverse must not be infinite
            itself = ir.Constant(ir.VectorType(ir.IntType(1), lanes), [int(r.body(lane) == j) for lane in range(lanes)])
            square = builder.select(itself, constant(1.0, lanes), square)
            inverse_cube = builder.fdiv(strength, builder.fmul(square, square_root(builder, square)))
            from_j = builder.fmul(inverse_cube, lane_everywhere(builder, masses, j))
            sums = [builder.fadd(s, builder.fmul(from_j, x)) for s, x in zip(sums, away, strict=True)]
        return joined(builder, sums)

    return r(r, mass, z, G, softening), generate

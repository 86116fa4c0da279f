"""Scenes of hard spheres as soft grains, for the step loop of `refimpl.stepping`."""

from __future__ import annotations

from typing import Any

import numpy as np

from crosscheck.engines.protocol import Cost, Run, face_names, sample_times
from crosscheck.engines.refimpl.continuation import Continuation
from crosscheck.engines.refimpl.stepping import integrated
from crosscheck.engines.soft_spheres import ContactLaw, inertia_ratio, remarks, soft_spheres
from crosscheck.scene import AXES, Floats, Method, Scene, State
from refimpl.stepping.forces import grains as soft
from refimpl.stepping.integrate import Integration


def run_grains(scene: Scene, method: Method, ends: Continuation | None = None) -> Run:
    """Runs a scene of hard spheres as soft ones.

    scene: accepted by `soft_spheres.unsupported`. method: its contact and dt are used. ends: from where the run goes
    on, and what it leaves; None: nothing of it. UsageError if dt does not divide duration and interval.
    """
    state, output = scene.initial_state(method.contact), scene.output
    force = soft_grains(scene, state, method)
    r, v = soft.coordinates(force, state.positions, state.velocities, state.angular_velocities)
    keep_states = output.trajectory or "rotational_energy" in output.observables
    done, cost = integrated(
        scene,
        method,
        force,
        r,
        v,
        trajectory=keep_states or force.tallied,
        thermo=bool({"kinetic_energy", "potential_energy"} & set(output.observables)),
        last=None if keep_states else force.auxiliary,
        ends=ends,
    )
    run = _run(scene, force, sample_times(scene, method), done, cost)
    run.remarks = tuple(remarks(scene, method, state.velocities))
    return run


def soft_grains(scene: Scene, state: State, method: Method) -> soft.Grains:
    """The force record of `refimpl` for the hard spheres of `scene` as soft ones.

    state: the scene's initial state, which gives masses, diameters and the box. method: gives the contact.
    """
    contact = method.contact
    assert contact is not None
    assert state.diameters is not None
    laws, friction = soft_spheres(scene, contact), scene.spin_dimension > 0
    walls = []
    for index, (face, law) in enumerate(zip(scene.faces, laws.faces, strict=True)):
        if face is None or law is None:
            continue
        axis, upper = divmod(index, 2)
        assert state.lengths is not None
        place = float(state.lengths[axis]) if upper else 0.0
        moves = face.oscillation
        motion = (0.0, 0.0, 0.0) if moves is None else (moves.amplitude, moves.frequency, moves.phase)
        walls.append(soft.SoftPlane(axis, -1 if upper else 1, place, soft.ContactLaw(*law), *motion))
    return soft.grains(
        radii=state.diameters / 2,
        masses=state.masses,
        lengths=[1.0] * scene.dimension if state.lengths is None else state.lengths.tolist(),
        periodic=[boundary == "periodic" for boundary in scene.boundaries],
        law=soft.ContactLaw(*laws.pair),
        inertia=inertia_ratio(scene) if friction else None,
        gravity=scene.acceleration,
        walls=walls,
        cylinder=_cylinder(scene, state, laws.cylinder),
        hertz=contact.law == "hertz",
        damping="mass" if laws.by_mass else "restitution",
        history=contact.friction == "history",
        granular=laws.granular,
        tallies=bool(
            {"collisional_virial", "contact_time", "wall_impulse", "wall_torque"} & {*scene.output.observables}
        ),
    )


def _cylinder(scene: Scene, state: State, law: ContactLaw | None) -> soft.SoftCylinder | None:
    cylinder = None if scene.box is None else scene.box.cylinder
    if cylinder is None or law is None:
        return None
    assert state.lengths is not None
    first, second = (float(length) / 2 for length in state.lengths[list(scene.across)])
    axis = 2 if cylinder.axis is None else AXES.index(cylinder.axis)
    return soft.SoftCylinder(cylinder.radius, (first, second), soft.ContactLaw(*law), axis, cylinder.angular_velocity)


def _run(scene: Scene, force: soft.Grains, times: Floats, done: Integration, cost: Cost) -> Run:
    """The run, from the flat coordinates and velocities of the integration."""
    number, d, spin = scene.number, scene.dimension, scene.spin_dimension
    asked = set(scene.output.observables)

    def translational(flat: Floats) -> Floats:
        return flat[..., : number * d].reshape(*flat.shape[:-1], number, d)

    def rotational(flat: Floats) -> Floats:
        return flat[..., number * d : number * (d + spin)].reshape(*flat.shape[:-1], number, spin)

    run = Run(
        time=times,
        final_positions=translational(done.r),
        final_velocities=translational(done.v),
        diverged=done.diverged,
        cost=cost,
    )
    if spin:
        run["final_angular_velocities"] = rotational(done.v)
    if scene.output.trajectory:
        assert done.positions is not None
        assert done.velocities is not None
        run["positions"], run["velocities"] = translational(done.positions), translational(done.velocities)
        if spin:
            run["angular_velocities"] = rotational(done.velocities)
    if done.thermo is not None:
        for column, name in enumerate(("kinetic_energy", "potential_energy")):
            if name in asked:
                run[name] = done.thermo[:, column]
    if "rotational_energy" in asked:
        assert done.velocities is not None
        inertias: Any = 1.0 if force.inverse_inertias is None else 1 / force.inverse_inertias[:, None]
        run["rotational_energy"] = (0.5 * inertias * rotational(done.velocities) ** 2).sum(axis=(1, 2))
    if force.tallied:
        assert done.velocities is not None
        run.update(_cumulative(scene, force, done.velocities[:, -force.auxiliary :], asked))
    return run


def _cumulative(scene: Scene, force: soft.Grains, integrals: Floats, asked: set[Any]) -> dict[str, Floats]:
    """The cumulative observables that are asked for.

    integrals: (samples, columns), the last coordinates: time, then the integrals in the order of `refimpl`.
    """
    d, walls = scene.dimension, len(force.walls)
    integrals = integrals - integrals[:1]  # a run that goes on counts from its own start
    faces = list(face_names(scene))
    on_walls = integrals[:, 3 : 3 + (walls + 1) * d].reshape(-1, walls + 1, d)
    impulses = np.zeros((len(integrals), len(faces), d))
    held = [index for index, face in enumerate(scene.faces) if face is not None]
    impulses[:, held] = on_walls[:, :walls]
    if scene.across:
        impulses[:, -1] = on_walls[:, walls]
    found = {
        "contact_time": integrals[:, 1],
        "collisional_virial": integrals[:, 2],
        "wall_impulse": impulses,
        "wall_torque": integrals[:, -1],
    }
    return {name: values for name, values in found.items() if name in asked}

"""What the parts of a scene imply for its conserved quantities: which are kept, and which word changes the others.

The words are those of `crosscheck.engines.capabilities.words`. A word that a table does not name is a reason why a
quantity may change, so that a new entry of the scene language is one until somebody looks at it.
"""

from __future__ import annotations

from typing import Literal

import numpy as np

from crosscheck.engines.capabilities import words
from crosscheck.scene import Floats, Method, Scene

#: Words of scenes and contacts under which the energy is conserved.
_KEEP_ENERGY = """
    dimension=1 dimension=2 dimension=3 masses[] masses=0 acceleration gravity.G gravity.softening
    lennard_jones.epsilon lennard_jones.epsilon[] lennard_jones.length lennard_jones.length[]
    lennard_jones.length_form=sigma lennard_jones.length_form=r_m lennard_jones.truncation=truncated
    lennard_jones.truncation=shifted lennard_jones.truncation=force_shifted lennard_jones.tail_corrections
    hard_spheres.diameter hard_spheres.diameter[] hard_spheres.fixed hard_spheres.well
    box.boundaries=periodic box.boundaries=open box.boundaries=hard box.boundaries=wall box.wall box.wall.epsilon
    box.wall.sigma box.faces box.faces.open box.cylinder box.cylinder.axis=x box.cylinder.axis=y box.cylinder.axis=z
    output.fields output.collisions method.contact method.contact.law=hooke method.contact.law=hertz
    method.contact.stiffness method.contact.duration method.contact.k_n method.contact.E method.contact.nu
    method.contact.friction=dashpot method.threads method.compensated
    """
#: Words under which it can only be lost; walls with friction are at rest, but for a cylinder that turns. Springs along
#: rough contacts ("history") are not among them: they give back what they took up, and that is not measured.
_LOSE_ENERGY = """
    spring.gamma hard_spheres.restitution hard_spheres.contact_duration hard_spheres.friction
    hard_spheres.friction.static hard_spheres.friction.sliding hard_spheres.friction.inertia
    box.faces.restitution box.faces.friction box.faces.friction.static box.faces.friction.sliding
    box.cylinder.restitution box.cylinder.friction box.cylinder.friction.static box.cylinder.friction.sliding
    method.contact.gamma_n method.contact.gamma_t method.contact.mu
    """
#: Words under which particles exchange momentum among each other alone, or by walls and fields that are asked for.
_KEEP_MOMENTUM = (
    _KEEP_ENERGY
    + """
    hard_spheres.restitution hard_spheres.contact_duration hard_spheres.friction hard_spheres.friction.static
    hard_spheres.friction.sliding hard_spheres.friction.inertia
    box.faces.restitution box.faces.friction box.faces.friction.static box.faces.friction.sliding box.faces.velocity
    box.faces.random_phase box.faces.random_phase.law=uniform box.faces.random_phase.law=flux box.faces.oscillation
    box.faces.oscillation.phase box.faces.temperature box.cylinder.restitution box.cylinder.friction
    box.cylinder.friction.static box.cylinder.friction.sliding box.cylinder.angular_velocity
    method.contact.friction=history method.contact.k_t method.contact.gamma_n method.contact.gamma_t method.contact.mu
    """
)
#: Words under which the particles exchange momentum with something else, in the order of the alphabet.
_TAKE_MOMENTUM = (
    "acceleration", "box.boundaries=hard", "box.boundaries=wall", "box.cylinder", "box.wall", "hard_spheres.fixed",
)  # fmt: skip

#: What a scene does with its energy.
Energy = Literal["kept", "lost", "changed"]


def changes_energy(scene: Scene, method: Method) -> list[str]:
    """The words of scene and method under which the energy is not conserved, in alphabetical order."""
    return sorted(_effective(scene, method) - set(_KEEP_ENERGY.split()))


def _effective(scene: Scene, method: Method) -> frozenset[str]:
    """The words of scene and method without those of soft contacts that exert no force: a coefficient that is 0; with
    mu = 0, all of friction; a law of friction where nothing is rough.
    """
    used, contact = words(scene, method), method.contact
    if contact is None:
        return used
    idle = {f"method.contact.{name}" for name in ("gamma_n", "gamma_t", "mu") if getattr(contact, name) == 0}
    if contact.mu == 0:
        idle |= {word for word in used if ".friction" in word} | {"method.contact.k_t", "method.contact.gamma_t"}
    elif not any(word.endswith(".friction") for word in used):
        idle.add("method.contact.friction=history")
    return used - idle


def energy(scene: Scene, method: Method) -> Energy:
    """Whether the energy of a run is conserved, can only decrease, or may do anything. scene, method: what is run."""
    reasons = set(changes_energy(scene, method))
    if not reasons:
        return "kept"
    return "lost" if reasons <= set(_LOSE_ENERGY.split()) else "changed"


def dissipates(scene: Scene, method: Method) -> bool:
    """Whether collisions or friction take energy up; scene, method: what is run."""
    return bool(_effective(scene, method) & set(_LOSE_ENERGY.split()))


def has_potential(scene: Scene, method: Method) -> bool:
    """Whether there is an energy beside the kinetic one; scene, method: what is run."""
    spheres = scene.hard_spheres
    if spheres is None:
        return True
    return method.contact is not None or spheres.well is not None or scene.acceleration is not None


def takes_momentum(scene: Scene) -> list[str]:
    """The words of a scene under which the total momentum is not conserved, "spring" among them."""
    used = words(scene)
    return [word for word in _TAKE_MOMENTUM if word in used] + ["spring"] * (scene.spring is not None)


def changes_momentum(scene: Scene, method: Method, axis: int, *, walls_known: bool = False) -> str | None:
    """None, or the word under which the momentum along an axis is not that of the start, and of a uniform field.

    scene, method: what is run. axis: from 0. walls_known: the momentum given to hard walls was measured, and is not
    asked for.
    """
    used = words(scene, method)
    if scene.spring is not None:
        return "spring"
    unknown = sorted(used - set(_KEEP_MOMENTUM.split()) - {"acceleration"})
    if unknown:
        return unknown[0]
    if "hard_spheres.fixed" in used:
        return "hard_spheres.fixed"
    if scene.boundaries[axis] == "wall":
        return "box.boundaries=wall"
    if walls_known:
        return None
    if scene.boundaries[axis] == "hard":
        return "box.boundaries=hard"
    for face in scene.faces:  # along a wall, only a smooth one exerts no force
        if face is not None and (face.friction is not None or face.temperature is not None):
            return "box.faces.friction" if face.friction is not None else "box.faces.temperature"
    cylinder = None if scene.box is None else scene.box.cylinder
    if cylinder is not None and (axis in scene.across or cylinder.friction is not None):
        return "box.cylinder"
    return None


def turns(scene: Scene, method: Method) -> tuple[Floats, Floats] | str:
    """The point about which angular momentum is conserved, (3,), and which of its components are, (3,) of 0 and 1.

    Or the word for which none is. scene, method: what is run. By symmetry: of open space about any point; of springs
    about the origin; of a smooth cylinder about its axis.
    """
    used = words(scene, method)
    if scene.dimension == 1:
        return "dimension=1"
    unknown = sorted(used - set(_KEEP_MOMENTUM.split()))
    if unknown:
        return unknown[0]
    for word in ("acceleration", "hard_spheres.fixed"):
        if word in used:
            return word
    kept = np.array([0.0, 0.0, 1.0]) if scene.dimension == 2 else np.ones(3)
    cylinder = None if scene.box is None else scene.box.cylinder
    closed = [axis for axis in range(scene.dimension) if scene.boundaries[axis] != "open"]
    if cylinder is None:
        return (np.zeros(3), kept) if not closed else f"box.boundaries={scene.boundaries[closed[0]]}"
    if cylinder.friction is not None:
        return "box.cylinder.friction"
    along = [axis for axis in range(3) if axis not in scene.across]
    for axis in closed:  # along the axis a smooth wall or the next image turn nothing
        for face in scene.faces[2 * axis : 2 * axis + 2]:
            if face is not None and (face.friction is not None or face.temperature is not None):
                return "box.faces"
    lengths = scene.lengths()
    assert lengths is not None
    middle = np.zeros(3)
    middle[: lengths.size] = lengths / 2
    return middle, np.array([float(axis in along) for axis in range(3)])

"""Every step of small runs of soft grains, audited: all pairs of features of contacts, walls, fields and starts.

Literature: P. A. Cundall and O. D. L. Strack, Geotechnique 29, 47 (1979); L. E. Silbert et al., Phys. Rev. E 64, 051302
(2001).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache, partial
from typing import NamedTuple

from crosscheck.checks.base import Check, FeatureRows, Laboratory, Variant
from crosscheck.checks.granular.audited_scenes import COMMON_RULES, RULES, audited_method, audited_scene, common, simple
from crosscheck.checks.granular.soft_grains import CONTACTS, soft_needs
from crosscheck.engines.capabilities import Needs
from crosscheck.faults import Fault
from crosscheck.pairs import Pair, Row, covering
from crosscheck.references.soft_grains import Audited, audit
from crosscheck.verdict import Judged, Judgement, bounded, round_off, worst

#: Features of a scene of soft grains; the first level of each is the absence of the feature.
FACTORS: dict[str, tuple[str, ...]] = {
    "law": ("hooke", "duration", "hertz", "own hooke", "own hertz", "moduli"),
    "friction": ("none", "spring", "limited spring", "dashpot", "limited dashpot"),
    "x": ("open", "periodic", "walls", "lower oscillates", "upper oscillates"),
    "y": ("open", "periodic", "walls", "lower oscillates", "upper oscillates"),
    "z": ("open", "periodic", "walls", "lower oscillates", "upper oscillates"),
    "cylinder": ("none", "about x", "about y", "about z"),
    "turning": ("none", "forwards", "backwards"),
    "damping": ("none", "restitution", "rates"),
    "surfaces": ("like grains", "others", "smooth"),
    "dimension": ("2", "3"),
    "grains": ("alike", "unlike masses", "unlike sizes", "unlike masses and sizes"),
    "inertia": ("default", "given"),
    "field": ("none", "along one axis", "oblique"),
    "start": ("apart", "in contact", "in other images", "one far away"),
    "motion": ("slow", "fast"),
    "crowd": ("compact", "long in x", "long in y", "long in z"),
    "tallies": ("none", "all"),
}
#: Number of variants of a table of rows; seeds of the tables, all but the first one of the full tier.
_CHUNKS, _SEEDS = 3, range(6)
_WHY = "rounding of coordinates, of the forces that they give, and of the sums over the run"


@cache
def rows(seed: int = 0) -> tuple[list[Row], set[Pair]]:
    """Rows in which each pair of levels of `FACTORS` occurs, and the pairs that no scene can have.

    seed: another one gives other rows.
    """
    return covering(FACTORS, RULES, seed)


@cache
def simple_rows() -> tuple[list[Row], set[Pair]]:
    """Few rows for engines that measure less: no potential energy, and no feature that a code of today lacks."""
    fewer = {name: simple(name, levels) for name, levels in FACTORS.items()}
    return covering(fewer, RULES)


@cache
def common_rows() -> tuple[list[Row], set[Pair]]:
    """Rows for codes that measure no potential energy, but have all contact laws, walls and cylinders."""
    fewer = {name: common(name, levels) for name, levels in FACTORS.items()}
    return covering(fewer, COMMON_RULES)


def _named(row: Row) -> str:
    """The features of a row that are not absent."""
    return ", ".join(f"{name} {level}" for name, level in row.items() if level != FACTORS[name][0])


def _judge_row(
    laboratory: Laboratory, name: str, row: Row, potential: bool, turned_at_walls: bool
) -> tuple[Judgement, Audited]:
    scene, method = audited_scene(row, laboratory.seed(name), potential), audited_method(row)
    assert method.contact is not None
    run = laboratory.run(scene, method)
    found = audit(scene, method.contact, method.step, run, turned_at_walls)
    quantity, worst_of = found.worst
    note = (
        f"{name} ({_named(row)}): {quantity} of sample {worst_of.sample} off by {worst_of.error:.3g}, "
        f"rounding {worst_of.rounding:.3g}"
    )
    return round_off(f"{name}: largest error over its rounding", worst_of.share, 1.0, _WHY, note=note), found


class _Rows(NamedTuple):
    """Rows that one variant judges, by their numbers; what `audited_scene` and `audit` are told of them."""

    rows: Callable[[], list[tuple[int, Row]]]
    potential: bool = False
    turned_at_walls: bool = False


def _judge(laboratory: Laboratory, value: _Rows) -> Judged:
    chunk = value.rows()
    judged = [_judge_row(laboratory, f"row {i}", row, value.potential, value.turned_at_walls) for i, row in chunk]
    audits = [found for _, found in judged]
    rough = [found for (_, row), found in zip(chunk, audits, strict=True) if "limited" in row["friction"]]
    events = {
        "contacts of pairs that began": sum(found.contacts for found in audits),
        "contacts with walls that began": sum(found.walls for found in audits),
        "contacts that began again": sum(found.again for found in audits),
        "contacts of one grain at once, over two": sum(found.at_once > 2 for found in audits),
        "contacts at Coulomb's limit": sum(found.slid for found in rough) if rough else 1,
    }
    happened = [
        bounded(name, float(number), 1.0, "what does not happen is not judged", at_least=True, control=True)
        for name, number in events.items()
    ]
    note = f"{len(judged)} scenes, {sum(found.contacts + found.walls for found in audits)} contacts, each step audited"
    return worst([*(judgement for judgement, _ in judged), *happened], note)


#: All words of the rows, and what is measured.
_WORDS = """
    dimension=2 dimension=3 masses[] acceleration hard_spheres.diameter[] hard_spheres.restitution hard_spheres.friction
    hard_spheres.friction.static hard_spheres.friction.sliding
    box.boundaries=periodic box.boundaries=open box.boundaries=hard box.faces box.faces.restitution
    box.faces.oscillation box.faces.oscillation.phase box.faces.friction box.faces.friction.static
    box.faces.friction.sliding method.contact.stiffness method.contact.friction=history
    method.contact.friction=dashpot method.contact.k_n method.contact.k_t method.contact.gamma_n method.contact.gamma_t
    method.contact.mu
"""
_COMMON_WORDS = f"""{_WORDS}
    box.cylinder box.cylinder.axis=x box.cylinder.axis=y box.cylinder.axis=z
    box.cylinder.angular_velocity box.cylinder.restitution box.cylinder.friction box.cylinder.friction.static
    box.cylinder.friction.sliding method.contact.duration method.contact.law=hertz method.contact.E method.contact.nu
"""
_ALL_WORDS = f"{_COMMON_WORDS} hard_spheres.friction.inertia"
_TALLIES = "kinetic_energy rotational_energy contact_time collisional_virial wall_impulse"


def _needs(words: str, observables: str) -> Needs:
    """With velocity Verlet, whose steps are audited."""
    needs = soft_needs(words, f"positions velocities angular_velocities {_TALLIES} {observables}")
    return Needs(needs.interaction, needs.kinds, needs.words, needs.observables, ("velocity_verlet",))


def _numbered(table: Callable[[], tuple[list[Row], set[Pair]]], first: int = 0, by: int = 1) -> list[tuple[int, Row]]:
    """Every row of a table, or from the `first` on each `by`-th, with its number."""
    return list(enumerate(table()[0]))[first::by]


def _variants() -> tuple[Variant, ...]:
    everything = _needs(_ALL_WORDS, "potential_energy wall_torque")
    of_most_codes = replace(_needs(_COMMON_WORDS, "wall_torque"), promises=("springs_turned_at_walls",))
    return (
        *(
            Variant(
                f"rows-{seed * _CHUNKS + number}",
                _Rows(partial(_numbered, partial(rows, seed), number, _CHUNKS), potential=True),
                "full" if seed else "quick",
                everything,
            )
            for seed in _SEEDS
            for number in range(_CHUNKS)
        ),
        Variant("simple-rows", _Rows(partial(_numbered, simple_rows))),
        Variant("common-rows", _Rows(partial(_numbered, common_rows), turned_at_walls=True), needs=of_most_codes),
    )


CHECKS = (
    Check(
        name="granular/audit",
        title="Each step of small scenes of soft grains, from the one before",
        equation="r' = r + dt v_h, v_h = v + dt a/2, v' = v_h + dt a'/2, with the forces of an auditor",
        criterion="positions, velocities, spins, energies and sums over the run, to rounding",
        citation="Cundall and Strack, Geotechnique 29, 47 (1979); Silbert et al., Phys. Rev. E 64, 051302 (2001)",
        judge=_judge,
        variants=_variants(),
        needs=_needs(_WORDS, ""),
        faults=(
            (
                "rows-0",
                Fault(
                    "stretch-of-another-contact",
                    CONTACTS,
                    "if old < old_contacts and old_places[old] == places[contact]:",
                    "if old < old_contacts:",
                    "a contact that begins has the stretch of the one that comes after it in the list",
                ),
            ),
            (
                "rows-1",
                Fault(
                    "drum-turns-backwards",
                    CONTACTS,
                    "surface = cylinder[ANGULAR_VELOCITY] * inside",
                    "surface = -cylinder[ANGULAR_VELOCITY] * inside",
                    "the surface of a turning cylinder moves the other way",
                ),
            ),
            (
                "rows-2",
                Fault(
                    "friction-pushes-one-grain-only",
                    CONTACTS,
                    "_add(d, a, j, -inverse_masses[j], total)",
                    "_add(d, a, j, -inverse_masses[j], _less(_times(normal, n), 1.0, _less(total, normal, n)))",
                    "the friction on the second grain has the wrong sign",
                ),
            ),
        ),
        interpreted=True,
        features=FeatureRows(FACTORS, rows),
    ),
)

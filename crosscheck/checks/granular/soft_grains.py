"""What the checks of soft grains share: what they ask of an engine, and what they compare it with."""

from __future__ import annotations

from crosscheck.engines.capabilities import Needs
from crosscheck.scene import Contact

#: The engine of the runs that others are compared with: event-driven ones, and soft ones where two codes are compared.
REFERENCE = "refimpl"
#: Where `refimpl` has the laws of contacts: the file in which faults are planted.
CONTACTS = "stepping/kernels/contacts.py"
#: Where it finds them.
LISTS = "stepping/kernels/contact_lists.py"


def soft_needs(words: str = "", observables: str = "") -> Needs:
    """What a check of hard spheres, run as soft ones by time steps, asks of an engine.

    words, observables: further entries of `Needs`, each in one text, separated by spaces.
    """
    contact = "method.contact method.contact.law=hooke"
    return Needs("hard_spheres", ("stepping",), frozenset(f"{contact} {words}".split()), frozenset(observables.split()))


def contact_needs(contact: Contact) -> Needs:
    """What a variant asks of an engine whose soft contacts have the entries of `contact`."""
    entries = contact.model_fields_set - {"law", "friction"}
    words = {f"method.contact.{name}" for name in entries} | {f"method.contact.law={contact.law}"}
    return Needs("hard_spheres", ("stepping",), frozenset(words))

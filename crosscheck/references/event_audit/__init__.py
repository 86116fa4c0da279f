"""An auditor of event-driven runs: every event of a trace, and all that follows from it, against the definitions.

It shares no code with any engine: laws of collisions, motion between them and all sums are written here from the
definitions of the scene language. `audit` reads a run; `reconstructed` finds the events of a
densely sampled one, and `with_trace` adds them to it.
"""

from crosscheck.references.event_audit.audit import KINDS, audit
from crosscheck.references.event_audit.deviations import Audit
from crosscheck.references.event_audit.sampled import SampledEvent, reconstructed, with_trace

__all__ = ["KINDS", "Audit", "SampledEvent", "audit", "reconstructed", "with_trace"]

"""Event-driven engines in plain Python: one that looks at the nearest image alone, and one that is right.

A published mistake: the next contact of a pair is that of the image which is nearest at the moment. A particle that
crosses half the box before its next event meets other images first, and flies through them.
"""

from __future__ import annotations

import itertools
import math

import numpy as np

from crosscheck.engines.capabilities import capability
from crosscheck.engines.protocol import Claims, Run


class AllImages:
    """Elastic or inelastic smooth spheres in a periodic box; all images within two boxes."""

    name = "all-images"
    schemes = {"events": Claims(kind="event_driven")}
    capabilities = (
        capability(
            "hard_spheres",
            "event_driven",
            words="""dimension=2 dimension=3 box.boundaries=periodic masses[] hard_spheres.diameter
                hard_spheres.diameter[] hard_spheres.restitution""",
            observables="positions velocities",
        ),
    )
    images = 2

    def version(self):
        return "1"

    def supports(self, scene, method):
        return None

    def run(self, scene, method):
        state, times = scene.initial_state(), scene.samples()
        x, v, radii = state.positions.copy(), state.velocities.copy(), state.diameters / 2
        run = Run(time=times, positions=np.zeros((times.size, *x.shape)), velocities=np.zeros((times.size, *x.shape)))
        events, now, sample = [], 0.0, 0
        while sample < times.size:
            span, i, j, shift = self.next(x, v, radii, state.lengths)
            while sample < times.size and times[sample] <= now + span:
                run["positions"][sample] = x + v * (times[sample] - now)
                run["velocities"][sample] = v
                sample += 1
            if sample == times.size:
                break
            now += span
            x += v * span
            n = (x[j] - x[i] + shift) / (radii[i] + radii[j])
            mu = 1 / (1 / state.masses[i] + 1 / state.masses[j])
            push = (1 + scene.hard_spheres.restitution) * mu * ((v[j] - v[i]) @ n) * n
            v[i] += push / state.masses[i]
            v[j] -= push / state.masses[j]
            events.append((now, i, j, x[[i, j]], v[[i, j]]))
        run["final_positions"], run["final_velocities"] = x + v * (scene.duration - now), v
        if "event_times" in scene.asked():
            run["event_times"] = np.array([event[0] for event in events])
            run["event_partners"] = np.array([event[1:3] for event in events]).reshape(-1, 2)
            run["event_positions"] = np.array([event[3] for event in events]).reshape(-1, 2, x.shape[1])
            run["event_velocities"] = np.array([event[4] for event in events]).reshape(-1, 2, x.shape[1])
        return run if scene.output.trajectory else Run({name: run[name] for name in scene.asked()})

    def next(self, x, v, radii, lengths):
        best = (math.inf, 0, 0, None)
        turns = range(-self.images, self.images + 1)
        shifts = lengths * np.array(list(itertools.product(turns, repeat=len(lengths))))
        for i, j in itertools.combinations(range(len(x)), 2):
            gap = x[j] - x[i]
            gap = gap - lengths * np.round(gap / lengths)
            home = gap - (x[j] - x[i])
            r, u = gap + shifts, v[j] - v[i]
            b, w, c = r @ u, u @ u, (r * r).sum(axis=1) - (radii[i] + radii[j]) ** 2
            root = b * b - w * c
            # overlapping pairs fly through each other
            (met,) = np.nonzero((b < 0) & (root > 0) & (c > -1e-9))
            if met.size:
                spans = np.maximum(c[met] / (np.sqrt(root[met]) - b[met]), 0.0)
                first = int(spans.argmin())
                if spans[first] < best[0]:
                    best = (float(spans[first]), i, j, home + shifts[met[first]])
        return best


class Overlapping(AllImages):
    """Returns a sample in which two spheres overlap, and then a velocity that no event explains."""

    def run(self, scene, method):
        run = super().run(scene, method)
        half = len(run["time"]) // 2
        run["positions"][half, 1] = run["positions"][half, 0] + 0.25
        run["velocities"][half + 1 :, 1] *= -1
        return run


class NearestImage(AllImages):
    """The same, but for the images of a pair: the nearest one alone."""

    name = "nearest-image"
    images = 0


class Traced(AllImages):
    """The right engine, with a trace."""

    name = "all-images-traced"
    capabilities = (
        capability(
            "hard_spheres",
            "event_driven",
            words="""dimension=2 dimension=3 box.boundaries=periodic masses[] hard_spheres.diameter
                hard_spheres.diameter[] hard_spheres.restitution""",
            observables="positions velocities event_times event_partners event_positions event_velocities",
        ),
    )


class TracedNearestImage(Traced):
    """The wrong engine, with a trace."""

    name = "nearest-image-traced"
    images = 0

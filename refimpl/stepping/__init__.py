"""Time-step-driven dynamics: `integrate`, the integration `schemes`, and the `forces`."""

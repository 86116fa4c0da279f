"""Event-driven dynamics of hard disks and spheres: `model`, `naive.Naive`, and the fast `simulation.Simulation`."""

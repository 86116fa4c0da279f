"""Lattice gases: `models`; evolvers `plain`, `lookup` and `bitplanes`, the same bits; `boltzmann`; and `theory`."""

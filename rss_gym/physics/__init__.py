"""Numerical kernels of the world: elementary functions, noise, motion, radio."""

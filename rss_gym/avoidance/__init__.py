"""Rules of avoidance: one file each, pure kernels on relative positions and velocities."""

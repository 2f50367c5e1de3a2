"""Position from ranges to reference nodes, (1): the world's kernel, the general fix, and what fewer nodes can tell."""

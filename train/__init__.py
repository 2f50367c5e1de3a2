"""Training: recipes, the training loop and the export of agents."""

"""Training on the roads of highway-env: PPO of Stable-Baselines3 over a few environments, exported without pickle."""

from rss_gym.train.road.recipe import is_road, load, recipes
from rss_gym.train.road.run import start

__all__ = ["is_road", "load", "recipes", "start"]

"""Vehicles of a crossing, apart from those of other roads.

highway-env's intersection writes its drivers' distances and accelerations into the class of its vehicles. With a class
of its own, traffic on a highway does not depend on whether this process has made an intersection before.
"""

from highway_env.vehicle.behavior import IDMVehicle


class CrossingVehicle(IDMVehicle):
    """highway-env's driver."""

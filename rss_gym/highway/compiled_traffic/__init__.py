"""highway-env's traffic, compiled: what a decision's ticks do to vehicles on straight and sine lanes.

The equations, their order and the constants are highway-env's (`road.road`, `vehicle.behavior`, `vehicle.controller`,
`vehicle.kinematics`, `utils.are_polygons_intersecting`); only the last bit of a trigonometric function can differ.
Scores are driven by highway-env itself; trainings, which need many times as many decisions, by this.
"""

"""The compiled traffic of trainings against highway-env's own, drive for drive."""

import numpy as np
import pytest

from rss_gym.highway.batch import RoadBatch
from rss_gym.highway.compiled_traffic import drivers, motion, records
from rss_gym.highway.compiled_traffic.road import can_compile
from rss_gym.highway.env import RoadEnv
from rss_gym.highway.params import RoadParams

DRIVES = 8


def pair(scene, rows=DRIVES):
    """The same drives twice: by highway-env, and by the kernel."""
    batches = []
    for is_training in (False, True):
        batch = RoadBatch(RoadParams.of(scene=scene), rows)
        batch.is_training = is_training
        batch.seed(np.arange(rows, dtype=np.uint64))
        batch.reset(np.ones(rows, bool))
        batches.append(batch)
    return batches


@pytest.mark.parametrize("scene", ["highway", "merge", "intersection"])
def test_the_kernel_drives_as_highway_env_does(scene):
    own, compiled = pair(scene)
    rng, running, crashed = np.random.default_rng(3), np.ones(DRIVES, bool), 0
    for _ in range(25):
        actions = np.where(rng.random(DRIVES) < 0.5, 1, rng.integers(0, 3 if scene == "intersection" else 5, DRIVES))
        for batch in (own, compiled):
            batch.step(actions, running)
        assert np.abs(own.observations - compiled.observations).max() < 1e-6
        for first, second in zip(own.environments, compiled.environments, strict=True):
            if second.ranging.traffic is not None:
                second.ranging.traffic.write_back()
            for vehicle, twin in zip(first.road.road.vehicles, second.road.road.vehicles, strict=True):
                assert vehicle.position == pytest.approx(twin.position, abs=1e-8)
                assert (vehicle.speed, vehicle.heading) == pytest.approx((twin.speed, twin.heading), abs=1e-8)
                for name in ("crashed", "lane_index", "target_lane_index"):
                    assert getattr(vehicle, name) == getattr(twin, name)
        ended = own.episode["terminated"] | own.episode["truncated"]
        assert np.array_equal(ended, compiled.episode["terminated"] | compiled.episode["truncated"])
        running &= ~ended
        crashed = int(own.episode["collision"].sum())
        if not running.any():
            break
    assert crashed > 0  # an impact moves vehicles too


def test_scores_are_driven_by_highway_env_and_trainings_by_the_kernel():
    own, compiled = pair("highway", 1)
    assert "_simulate" not in vars(own.environments[0].road)
    assert "_simulate" in vars(compiled.environments[0].road)


def test_what_the_kernel_does_not_know_is_left_to_highway_env():
    for scene, known in (("highway", True), ("merge", True), ("intersection", False)):
        env = RoadEnv(scene=scene)
        env.reset(seed=0)
        assert can_compile(env.road.road) == known
    env = RoadEnv()
    env.reset(seed=0)
    env.road.road.vehicles[1].route = [("0", "1", 0)]
    assert not can_compile(env.road.road)


def test_constants_are_highway_envs():
    from highway_env.vehicle.behavior import IDMVehicle
    from highway_env.vehicle.controller import ControlledVehicle
    from highway_env.vehicle.kinematics import Vehicle

    for name in (
        "ACC_MAX", "COMFORT_ACC_MAX", "COMFORT_ACC_MIN", "DISTANCE_WANTED", "TIME_WANTED", "POLITENESS",
        "LANE_CHANGE_MIN_ACC_GAIN", "LANE_CHANGE_MAX_BRAKING_IMPOSED", "LANE_CHANGE_DELAY",
    ):  # fmt: skip
        assert getattr(drivers, name) == getattr(IDMVehicle, name)
    for name in ("KP_A", "KP_HEADING", "KP_LATERAL", "TAU_PURSUIT"):
        assert getattr(drivers, name) == pytest.approx(getattr(ControlledVehicle, name))
    assert pytest.approx(ControlledVehicle.MAX_STEERING_ANGLE) == drivers.MAX_STEERING
    assert motion.MAX_SPEED == Vehicle.MAX_SPEED == -Vehicle.MIN_SPEED
    assert records.VEHICLE_LENGTH == Vehicle.LENGTH

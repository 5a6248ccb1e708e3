"""A joint that a program steps."""

import tomllib

import numpy as np
import pytest

import stiction

# The axis of the thesis, section 3.1; in volts, deg and s.
EXPERIMENT = "step-response"


def moved(joint, effort_v, steps):
    return [joint.step(effort_v) for _ in range(steps)]


@pytest.fixture
def axis(tmp_path, program):
    """Return the thesis's axis with friction in round numbers."""
    text = program("show", EXPERIMENT)
    path = tmp_path / "axis.toml"
    path.write_text(text)
    return path


def friction(path):
    joint = tomllib.loads(path.read_text())["joint"]
    return joint["friction"]["stick_v"], joint["friction"]["slip_v"], joint


def test_an_effort_below_the_stick_friction_moves_nothing_and_one_above_it_does(axis):
    stick, _, _ = friction(axis)
    joint = stiction.Joint.from_file(axis)
    held = moved(joint, 0.98 * stick, 200)[-1]
    assert held.stuck and held.position_deg == 0.0 and held.counts == 0
    assert 0.0 < held.applied_v < stick
    loose = moved(joint, 1.02 * stick, 200)[-1]
    assert not loose.stuck and loose.position_deg > 0.0


def test_the_speed_under_a_constant_effort_is_that_of_the_closed_form(axis):
    # K (u - slip - B w) = dw/dt: the speed is (u - slip)/B (1 - exp(-K B t)).
    stick, slip, table = friction(axis)
    gain, viscous = table["gain_deg_per_s2_per_v"], table["viscous_v_per_deg_per_s"]
    joint = stiction.Joint.from_file(axis)
    samples = moved(joint, 2.0 * stick, 300)
    time, speed = (np.array([getattr(one, name) for one in samples])
                   for name in ("time_s", "velocity_deg_per_s"))
    effort = samples[-1].applied_v
    expected = (effort - slip) / viscous * (1.0 - np.exp(-gain * viscous * time))
    np.testing.assert_allclose(speed, expected, rtol=1e-9)


def test_the_drive_rounds_and_limits_and_no_number_is_no_effort(axis):
    joint = stiction.Joint.from_file(axis)
    largest = joint.largest_effort_v
    assert joint.step(1e9).applied_v == largest
    assert joint.step(-1e9).applied_v == -largest
    assert joint.step(float("nan")).applied_v == 0.0
    applied = joint.step(0.3).applied_v
    assert applied != 0.3 and abs(applied - 0.3) < 0.005


def test_a_seed_draws_the_same_joint_again_within_the_spread_and_none_is_the_file_s(arm):
    with arm.open("a") as stream:
        stream.write('\n[spread]\n"load.inertia_kg_m2" = [0.1, 0.2]\n')
    joint = stiction.Joint.from_file(arm)
    joint.reset(seed=5)
    first, drawn = moved(joint, 5.0, 300), joint.drawn
    assert list(drawn) == ["load.inertia_kg_m2"] and 0.1 <= drawn["load.inertia_kg_m2"] <= 0.2
    joint.reset(seed=6)
    other = moved(joint, 5.0, 300)
    assert joint.drawn != drawn and other[-1] != first[-1]
    joint.reset(seed=5)
    assert moved(joint, 5.0, 300) == first
    joint.reset()
    assert joint.drawn == {}


def test_without_a_spread_the_seed_draws_what_is_assumed_of_a_tuning(arm):
    joint = stiction.Joint.from_file(arm)
    sheet = tomllib.loads(arm.read_text())
    draws = []
    for seed in range(20):
        joint.reset(seed)
        draws.append(joint.drawn)
    for key, low, high in [
        ("load.inertia_kg_m2", 0.8, 1.2), ("friction.viscous_nm_s_per_rad", 0.5, 1.5),
    ]:
        table, name = key.split(".")
        shares = [one[key] / sheet[table][name] for one in draws]
        assert low <= min(shares) < 1.0 < max(shares) <= high
    assert all(one["friction.slip_nm"] < one["friction.stick_nm"] for one in draws)


def test_a_torque_is_known_with_a_data_sheet_only(arm, axis):
    assert stiction.Joint.from_file(axis).nm_per_v is None
    # Gear ratio, efficiency, torque constant, resistance of the file: N m at the joint per volt.
    table = tomllib.loads(arm.read_text())
    motor, gear = table["motor"], table["gear"]
    expected = gear["ratio"] * gear["efficiency"] * motor["kt_nm_per_a"] / motor["resistance_ohm"]
    assert stiction.Joint.from_file(arm).nm_per_v == pytest.approx(expected, rel=1e-12)


def test_a_friction_experiment_has_no_joint_to_step():
    with pytest.raises(stiction.Refused, match="spring-mass is a friction experiment"):
        stiction.Joint.from_file("spring-mass")

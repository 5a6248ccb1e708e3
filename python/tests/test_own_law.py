"""A law in Python, beside the built-in ones."""

import math

import pytest

import stiction


def pd(joint):
    """PD with the gains of the rule book: 8 Hz or 0.1 / h, damping ratio 0.9."""
    natural = min(2 * math.pi * 8, 0.1 / joint.sample_time)
    kp = joint.inertia * natural**2
    kd = max(0.0, 2 * 0.9 * joint.inertia * natural - joint.viscous)
    return lambda sample: kp * sample.error + kd * (sample.target_velocity - sample.velocity)


pd.version = "3"


class Counter:
    """A law with a state."""

    def __init__(self, joint):
        self.ticks, self.joint = 0, joint

    def __call__(self, sample):
        assert abs(sample.error - (sample.target_counts - sample.counts) * self.joint.count) < 1e-6
        self.ticks += 1
        return 0.0


def test_pd_in_python_moves_each_joint_as_the_built_in_pd_does():
    found = stiction.ensemble("rigid", cases=6, seed=5, controller="pd", law={"own": pd})
    rows = {name: [row for row in found.rows if row["law"] == name] for name in ("pd", "own")}
    assert len(rows["pd"]) == len(rows["own"]) == 6
    for one, other in zip(rows["pd"], rows["own"], strict=True):
        # The rule rounds its gains to four digits.
        assert other["tracking_rms"] == pytest.approx(one["tracking_rms"], rel=0.01)
        assert other["rest_counts"] == pytest.approx(one["rest_counts"], abs=2.0)
        assert other["step_fault"] is None
    assert found.header["guests"] == {"own": "3"} and found.header["laws"] == ["pd", "own"]


def test_a_law_that_does_nothing_fails_on_every_joint():
    found = stiction.ensemble("rigid", cases=3, controller="pd", law=Counter)
    rows = [row for row in found.rows if row["law"] == "Counter"]
    assert len(rows) == 3 and not any(row["success_at_encoder"] for row in rows)


def test_an_exception_of_a_law_ends_the_ensemble_and_is_its_cause():
    def broken(joint):
        return lambda sample: 1.0 / 0.0

    with pytest.raises(RuntimeError, match="the law `broken`: ZeroDivisionError") as failed:
        stiction.ensemble("rigid", cases=3, controller="pd", law=broken)
    assert isinstance(failed.value.__cause__, ZeroDivisionError)
    # The next ensemble is not affected.
    assert len(stiction.ensemble("rigid", cases=2, controller="pd").rows) == 2


@pytest.mark.parametrize(
    ("law", "sentence"),
    [
        ({"pid": pd}, "`pid` is the name of a built-in law"),
        ({"a,b": pd}, "must have no comma"),
    ],
)
def test_a_name_that_another_law_has_is_refused(law, sentence):
    with pytest.raises(stiction.Refused, match=sentence):
        stiction.ensemble("rigid", cases=1, law=law)


def test_a_law_with_the_gains_of_the_file_moves_its_joint_as_the_built_in_one():
    seen = []

    def own(joint):
        seen.append(joint)
        kp, kd = math.degrees(1.0), math.degrees(0.15)  # of [controller.pd], V/deg and V s/deg
        return lambda sample: kp * sample.error + kd * (sample.target_velocity - sample.velocity)

    for target in ("host", "servo"):
        all_runs = stiction.run("step-response", "pd", target=target, law={"own": own})
        runs = {one.label: one for one in all_runs}
        for label in ("step-5.0", "step-2.5", "step-1.0"):
            built_in, other = (runs[f"{law}/{label}"]["position_deg"] for law in ("pd", "own"))
            # A code of the converter now and then, by rounding.
            assert abs(built_in - other).max() < 0.01, (target, label)
            assert built_in.max() > 0.3
    # [joint] of the file, in rad, and the rule book's factor of 2 on both frictions.
    joint = seen[0]
    assert joint.sample_time == pytest.approx(0.02)
    assert math.degrees(joint.count) == pytest.approx(0.00242)
    assert joint.inertia == pytest.approx(math.degrees(1 / 27))
    assert joint.viscous == pytest.approx(math.degrees(0.02))
    assert (joint.breakaway_low, joint.breakaway_high) == pytest.approx((0.38 / 2, 2 * 0.40))
    assert (joint.largest_effort, joint.effort_step) == pytest.approx((5.0, 0.00488))
    ranking = stiction.benchmark("step-response", law={"own": own})
    rest = {row["controller"]: row["rest_error_counts"] for row in ranking}
    assert rest["own"] == pytest.approx(rest["pd"], abs=4)


def test_a_law_sees_the_effort_that_a_limit_of_current_leaves(tmp_path):
    seen = []

    def own(joint):
        seen.append(joint)
        return pd(joint)

    file = stiction.new(tmp_path / "gimbal.toml", "gimbal")
    stiction.run(file, "pd", law={"own": own})
    # 2 of the 5.5 A that 12 V would drive.
    assert seen[0].largest_effort == pytest.approx(12.0 * 2.0 / 5.5, rel=0.02)


def test_a_law_is_compared_on_joints_around_a_file(arm):
    found = stiction.ensemble(arm, cases=2, seed=3, controller="pd", law={"own": pd})
    assert found.header["laws"] == ["pd", "own"] and found.header["guests"] == {"own": "3"}
    assert sorted(row["law"] for row in found.rows) == ["own", "own", "pd", "pd"]


def test_a_following_error_of_its_own_is_the_threshold_of_the_monitor():
    class Still:
        """It stays behind every path."""

        def __init__(self, joint):
            pass

        def __call__(self, sample):
            return 0.0

    def faults(law):
        rows = stiction.ensemble("rigid", cases=3, controller="pd", law={"still": law}).rows
        return [row["tracking_fault"] for row in rows if row["law"] == "still"]

    assert set(faults(Still)) == {"following error"}
    Still.following_error = lambda joint: 1e3
    assert set(faults(Still)) == {None}
    Still.following_error = lambda joint: -1.0
    with pytest.raises(RuntimeError, match="must be a number from 0 on"):
        faults(Still)
    Still.following_error = lambda joint: 1 / 0
    with pytest.raises(RuntimeError) as failed:
        faults(Still)
    assert isinstance(failed.value.__cause__, ZeroDivisionError)

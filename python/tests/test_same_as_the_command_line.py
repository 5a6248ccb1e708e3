"""Each function returns what its command prints."""

import csv
import io

import numpy as np
import pytest

import stiction


def columns(text):
    rows = list(csv.DictReader(line for line in io.StringIO(text) if not line.startswith("#")))
    return {name: [row[name] for row in rows] for name in rows[0]}


def number(cell):
    return {"": np.nan, "true": 1.0, "false": 0.0}.get(cell, cell)


@pytest.mark.parametrize(
    ("experiment", "controller"), [("step-response", "srnf"), ("friction-identification", None)]
)
def test_a_run_has_the_columns_of_the_csv_and_the_metrics_of_the_json(
    program, report, tmp_path, experiment, controller
):
    some = ["--controller", controller] if controller else []
    text = program("run", experiment, *some, "--csv", tmp_path / "run.csv")
    assert text
    written = columns((tmp_path / "run.csv").read_text())
    runs = stiction.run(experiment, controller)
    printed = report("run", experiment, *some)["runs"]
    labels = written.pop("label", [runs[0].label] * len(written["time_s"]))
    assert [one.label for one in runs] == [one["label"] for one in printed]
    for one, record in zip(runs, printed, strict=True):
        assert one.metrics == record["metrics"]
        rows = [place for place, label in enumerate(labels) if label == one.label]
        assert set(one) == set(written)
        for name, cells in written.items():
            # Single precision is written with its own shortest decimals.
            expected = np.array([number(cells[place]) for place in rows], dtype=np.float64)
            np.testing.assert_allclose(one[name], expected, rtol=1e-7, err_msg=name)


def test_a_run_of_a_servo_and_assigned_keys_are_those_of_the_command(report):
    printed = report("run", "step-response", "--controller", "pd", "--target", "servo",
                     "--set", "run.duration_s=3")
    runs = stiction.run("step-response", ["pd"], set={"run.duration_s": 3}, target="servo")
    assert [one.metrics for one in runs] == [one["metrics"] for one in printed["runs"]]
    assert len(runs[0]["time_s"]) == len(stiction.run("step-response", "pd",
                                                      set={"run.duration_s": 3})[0]["time_s"])


def test_a_ranking_has_the_rows_of_the_command(report, arm):
    printed = report("benchmark", arm, "--weights", "settling=2,chatter=0")
    assert stiction.benchmark(arm, {"settling": 2, "chatter": 0}) == printed["controllers"]


def test_an_ensemble_has_the_rows_and_the_summary_of_the_command(program, report, tmp_path):
    arguments = ["ensemble", "--plant", "rigid,gear-backlash", "--cases", 4, "--seed", 9,
                 "--controller", "pd,robust", "--condition", "sag", "--bridge", "current",
                 "--moves", 3]
    program(*arguments, "--csv", tmp_path / "rows.csv")
    written = columns((tmp_path / "rows.csv").read_text())
    found = stiction.ensemble(["rigid", "gear-backlash"], cases=4, seed=9, moves=3,
                              controller=["pd", "robust"], condition="sag",
                              bridge="current")
    assert found.summary == report(*arguments)
    assert len(found.rows) == 16 and set(found.rows[0]) == set(written)
    for name in ("rest_counts", "settled_s", "tracking_rms"):
        expected = [float(cell) if cell else None for cell in written[name]]
        assert [row[name] for row in found.rows] == expected
    assert found.header["seed"] == 9 and found.header["condition"] == "sag"
    assert found.header["bridge"] == "current"


def test_an_ensemble_around_a_file_has_the_rows_of_the_command(report, arm):
    spread = {"load.inertia_kg_m2": (0.1, 0.2)}
    found = stiction.ensemble(arm, cases=3, seed=2, controller="robust", spread=spread, rate=500)
    printed = report("ensemble", "--plant", arm, "--cases", 3, "--seed", 2, "--controller",
                     "robust", "--spread", "load.inertia_kg_m2=0.1..0.2", "--rate", 500)
    assert found.summary == printed


def test_arrays_identify_the_joint_that_their_file_identifies(report, tmp_path):
    # Effort is in volts and the angle in degrees, as the simulator has them.
    joint = stiction.Joint.from_file("step-response")
    rng = np.random.default_rng(1)
    time, position, effort = [], [], []
    level = 0.0
    for k in range(8000):
        if k % 400 == 0:
            level = rng.uniform(-1.5, 1.5)
        sample = joint.step(level)
        time.append(sample.time_s)
        position.append(sample.counts * joint.count_deg)
        effort.append(sample.applied_v)
    log = tmp_path / "log.csv"
    with log.open("w") as stream:
        stream.write("time,position,effort\n")
        stream.writelines(f"{t!r},{q!r},{u!r}\n" for t, q, u in zip(time, position, effort))
    found = stiction.identify(time, position, effort, position_unit="deg", effort_delay=0.0)
    printed = report("identify", log, "--time", "time", "--position", "position", "--effort",
                     "effort", "--position-unit", "deg", "--effort-delay", 0)
    for one in (found, printed):
        del one["log"]
    assert found["parameters"] == printed["parameters"]
    assert found["verdict"] == printed["verdict"]
    assert found.keys() == printed.keys()
    # The sheet of the joint is the third opinion: the inertia is 1/K, in V s^2/rad.
    table = stiction.run("step-response", "pd")[0].record["parameters"]["joint"]
    inertia = np.degrees(1.0) / table["gain_deg_per_s2_per_v"]
    assert found["parameters"]["inertia"]["value"] == pytest.approx(inertia, rel=0.05)


def test_a_tuning_is_that_of_the_command(report, program, arm, tmp_path):
    out = tmp_path / "tuned.toml"
    printed = report("tune", arm, "--controller", "srnf", "--cases", 1, "--out", out)
    found = stiction.tune(arm, "srnf", cases=1)
    assert found.report == printed["controllers"]["srnf"]
    assert found.text == (out.read_text() if out.exists() else None)
    assert found.outcome == printed["outcome"]
    assert found.gains == {
        name: gain["to"] for name, gain in printed["controllers"]["srnf"]["gains"].items()
    }


def test_a_first_file_is_that_of_the_command(program, arm, tmp_path):
    path = tmp_path / "other" / "arm.toml"
    path.parent.mkdir()
    program("new", path, "--typical", "harmonic", "--inertia", "0.2..0.4")
    text = stiction.draft("harmonic", {"load.inertia_kg_m2": (0.2, 0.4)}, title="arm")
    assert text == path.read_text()

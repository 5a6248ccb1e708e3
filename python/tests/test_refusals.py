"""What is refused, and how work ends."""

import re
import signal
import threading

import numpy as np
import pytest

import stiction

TIME = np.arange(1000) * 1e-3
STILL = np.zeros(1000)


@pytest.mark.parametrize(
    ("call", "sentence"),
    [
        (lambda: stiction.ensemble("rigit"), "plant rigit.*did you mean `rigid`"),
        (lambda: stiction.ensemble(cases=0), "cases 0: must be a whole number from 1 to 1000000"),
        (lambda: stiction.ensemble(rate=3), "rate 3: must be a number from 50 to 10000"),
        (lambda: stiction.ensemble(condition="x"), "condition x: must be one of nominal, drift"),
        (lambda: stiction.ensemble(motion="x"), "motion x: must be profiled or step"),
        (lambda: stiction.ensemble(controller="sfrn"), "did you mean `srnf`"),
        (lambda: stiction.ensemble(spread={"a": (1, 2)}), "spread needs a machine's own file"),
        (lambda: stiction.ensemble("a.toml", hard=True), "hard does not go with plant='a.toml'"),
        (lambda: stiction.run("step-responce"), "did you mean `step-response`"),
        (lambda: stiction.run("step-response", "pdd"), "did you mean `pd`"),
        (lambda: stiction.run("step-response", target="moon"), "must be host or servo"),
        (lambda: stiction.run("step-response", set={"run.step_s": 0}), "run.step_s"),
        (lambda: stiction.benchmark("step-response", {"speed": 1}), "no column `speed`"),
        (lambda: stiction.tune("step-response", "pd", goal="best"), "goal best: must be one of"),
        (lambda: stiction.tune("step-response", "pd", cases=0), "cases 0"),
        (lambda: stiction.draft(), r"missing: motor\.driven_by.*typical joint: harmonic"),
        (lambda: stiction.draft("harmonik"), "did you mean `harmonic`"),
        (lambda: stiction.draft("harmonic", {"load.inertia": 1}), "did you mean `load.inertia_kg"),
        (lambda: stiction.identify(TIME, STILL, STILL), "the position never changes"),
        (lambda: stiction.identify(TIME, STILL[1:], STILL), "1000 times, 999 positions"),
        (lambda: stiction.identify(TIME[::-1], TIME, STILL), "row 2: the time .* must increase"),
        (lambda: stiction.identify(TIME, TIME, TIME, position_unit="grad"), "must be one of m, mm"),
        (lambda: stiction.identify(TIME, TIME, TIME, position_unit="count"), "counts_per_turn"),
        (lambda: stiction.identify(TIME, TIME, TIME, time_unit="h"), "must be s, ms, us or ns"),
        (lambda: stiction.identify(TIME, TIME, TIME, cut_off=-1.0), "cut_off is -1"),
        (lambda: stiction.identify(TIME, TIME, TIME, model="odd"), "symmetric or asymmetric"),
        (lambda: stiction.identify([TIME], [TIME], [TIME]), "time has 2 dimensions"),
    ],
)
def test_a_refusal_is_a_sentence_with_the_argument(call, sentence):
    with pytest.raises(stiction.Refused, match=sentence) as refused:
        call()
    assert "--" not in str(refused.value)


def test_a_file_that_is_missing_or_exists_is_an_error_of_the_system(tmp_path):
    with pytest.raises(FileNotFoundError, match="cannot read .*none.toml"):
        stiction.run(tmp_path / "none.toml")
    path = stiction.new(tmp_path / "arm.toml", "gimbal")
    written = path.read_text()
    with pytest.raises(FileExistsError):
        stiction.new(path, "harmonic")
    assert path.read_text() == written
    stiction.new(path, "harmonic", force=True)
    assert path.read_text() != written


def test_a_doubtful_value_is_a_warning(arm):
    # A friction in motion of a tenth of that at rest: no gear has that.
    text = re.sub(r"(?m)^slip_nm = .*$", "slip_nm = 0.001", arm.read_text(), count=1)
    arm.write_text(text)
    with pytest.warns(stiction.Doubt):
        stiction.run(arm, "pd")


@pytest.mark.parametrize(
    "work",
    [
        lambda arm: stiction.ensemble("rigid", cases=1_000_000, controller="pd"),
        lambda arm: stiction.ensemble(arm, cases=1_000_000, controller="pd"),
        lambda arm: stiction.tune(arm, "srnf", cases=1000),
        lambda arm: stiction.run(arm, "pd", set={"reference.steps_deg": [
            1 + k / 100 for k in range(400)], "run.duration_s": 20}),
    ],
    ids=["ensemble", "ensemble of a file", "tuning", "runs"],
)
def test_ctrl_c_ends_work_that_would_take_minutes(arm, work):
    # A process in the background ignores the signal unless it has a handler.
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    # Another thread raises it, so it also fails if the work keeps the interpreter's lock.
    timer = threading.Timer(0.3, signal.raise_signal, [signal.SIGINT])
    timer.start()
    try:
        with pytest.raises(KeyboardInterrupt):
            work(arm)
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)

from collections.abc import Callable
from typing import Any

class LawJoint:
    """A joint as the built-in laws know it: the nominal joint and bounds of its friction.

    Angles are in rad and times in s; the effort is in the unit of the joint's drive.
    """

    sample_time: float
    count: float
    largest_effort: float
    effort_step: float
    inertia: float
    viscous: float
    breakaway_low: float
    breakaway_high: float
    load: float
    hold_effort: float
    jitter: float
    encoder_at_load: bool

class LawSample:
    """One tick of a law: what the servo measures, in rad and s."""

    counts: int
    target_counts: float
    error: float
    velocity: float
    target_velocity: float
    target_acceleration: float
    applied: float
    saturated: bool

class Refused(ValueError): ...

_Observation = tuple[float, int, float, float, float, bool, float]

class Joint:
    sample_time_s: float
    count_deg: float
    largest_effort_v: float
    nm_per_v: float | None
    drawn: list[str]
    def __init__(self, file: str) -> None: ...
    def reset(self, seed: int | None) -> _Observation: ...
    def step(self, effort_v: float) -> _Observation: ...

_Laws = list[tuple[str, str, Callable[[LawJoint], Callable[[LawSample], float]]]]

def benchmark(file: str, weights: list[str], laws: _Laws) -> str: ...
def doubts(file: str) -> list[str]: ...
def draft(
    name: str, like: str | None, answers: list[tuple[str, str]]
) -> tuple[str, list[str]]: ...
def ensemble(arguments: dict[str, Any], laws: _Laws) -> str: ...
def ensemble_of_file(
    file: str,
    cases_and_seed: tuple[int, int],
    controllers: list[str],
    spread: list[str],
    rate: float | None,
    laws: _Laws,
) -> str: ...
def experiments() -> list[tuple[str, str]]: ...
def identify(time: bytes, position: bytes, effort: bytes, settings: dict[str, Any]) -> str: ...
def run(
    file: str, controllers: list[str], set: list[str], by_servo: bool, laws: _Laws
) -> tuple[str, list[list[tuple[str, bytes]]]]: ...
def tune(file: str, controller: str, arguments: dict[str, Any]) -> tuple[str, str | None]: ...
def typical() -> list[str]: ...

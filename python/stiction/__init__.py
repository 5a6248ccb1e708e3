"""Joints with stick-slip friction: simulate, identify, tune, rank controllers.

Everything is simulated; nothing here has run on a motor. The joint is described by a machine's
file, which the command line ``stiction`` reads as well; ``new`` writes a first one. Angles are in
degrees and efforts in volts at the controller's output, as in that file; ``Joint.nm_per_v``
converts a voltage to a torque if the file has a data sheet.

>>> import stiction
>>> text = stiction.draft("harmonic")
>>> joint = stiction.Joint.from_file("step-response")
>>> joint.step(2.0).stuck
False
"""

from ._benchmark import benchmark
from ._ensemble import Ensemble, ensemble
from ._files import Doubt, draft, experiments, new, typical_joints
from ._identify import identify
from ._joint import Joint, Sample
from ._native import LawJoint, LawSample, Refused
from ._run import Run, run
from ._tune import Tuning, tune

__all__ = [
    "Doubt",
    "Ensemble",
    "Joint",
    "LawJoint",
    "LawSample",
    "Refused",
    "Run",
    "Sample",
    "Tuning",
    "benchmark",
    "draft",
    "ensemble",
    "experiments",
    "identify",
    "new",
    "run",
    "tune",
    "typical_joints",
]

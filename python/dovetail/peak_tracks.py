"""The peak over one parameter of a range, followed by the program in one run ([path] peak)."""

from dataclasses import dataclass, field

import numpy as np

from .case_runs import has_peak, tracked_peaks

SAME = 1e-9  # of the whole range: what counts as a number that was wanted
SAME_PEAK = 0.01  # relative: ends of a track and of a sweep that are farther apart are different peaks


@dataclass
class Track:
    """A followed peak. number : (n,) of the parameter, as in the range; omega, amplitude, rms : (n,); `reason` why it is none, or why it
    is not the whole range, or empty. `wanted`: the Range."""

    wanted: object
    number: np.ndarray = field(default_factory=lambda: np.zeros(0))
    omega: np.ndarray = field(default_factory=lambda: np.zeros(0))
    amplitude: np.ndarray = field(default_factory=lambda: np.zeros(0))
    rms: np.ndarray = field(default_factory=lambda: np.zeros(0))
    reason: str = ""

    def at(self, places):
        """Records as of `case_runs.largest_peak` at places xi; None where it does not come."""
        found = []
        for number in self.wanted.at(np.asarray(places)):
            here = np.flatnonzero(np.abs(self.number - number) <= SAME * (self.wanted.high - self.wanted.low))
            found.append({"status": 0, "reason": "", "peak": True} | {name: float(getattr(self, name)[here[0]]) for name in
                                                                       ("omega", "amplitude", "rms")} if len(here) else None)
        return found


def follow(runs, wanted, changes, places, digest):
    """The Track of one Range from its lower to its upper end, places xi between passed exactly, the others in the middle.

    Its ends are compared with the largest peaks of sweeps: one that belongs to another peak is none.
    """
    middle, numbers = wanted.at(0.0), wanted.at(np.asarray(places))
    steps = numbers - middle if wanted.kind == "offset" else numbers / middle
    path = {"parameter": wanted.name, "range": [float(steps[0]), float(steps[-1])], "peak": "amplitude", "at": steps[1:-1].tolist()}
    [record] = runs.each([changes({})], lambda results: tracked_peaks(results, runs.dof), f"following the peak over {wanted.name}",
                         path=path)
    if record["status"] != 0:
        return Track(wanted, reason=record["reason"])
    numbers = np.array(record["parameter"])
    track = Track(wanted, numbers + middle if wanted.kind == "offset" else numbers * middle,
                  *(np.array(record[name]) for name in ("omega", "amplitude", "rms")))
    ends = runs.each([changes({wanted.name: sign}) for sign in (-1.0, 1.0)], digest, f"ends of {wanted.name}")
    for here, swept in zip(track.at((-1.0, 1.0)), ends):
        if here is None:
            track.reason = f"it ends at {track.number[-1]:.6g}"
        elif has_peak(swept) and any(abs(here[name] / swept[name] - 1) > SAME_PEAK for name in ("omega", "amplitude")):
            return Track(wanted, reason="it is another peak than the largest of a sweep at an end of the range")
    return track

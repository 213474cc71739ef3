"""The methods of scripts/bench/field on one chain.

Each gives amplitudes at the same frequencies, processor seconds per point of the curve, and seconds spent.
"""

import json
import os
import subprocess
import sys
import time

import numpy as np
from field_newmark import steady_harmonic
from measure import BINARY, OUTPUT, ROOT, summary_of, weigh

from dovetail import Results, reference

sys.path.insert(0, str(ROOT / "tests/verification"))
import chain

INTEGRATE = BINARY.with_name("integrate")
PLACES = (0.9, 0.97, 1.0, 1.03, 1.1)  # of the peak: where amplitudes are compared
SWEEP, WALK = (0.85, 1.15), 25  # of the peak: what the curves span, and in how many steps methods without step control go
WORK = 1e13  # multiplications that the integration may take: enough for 64 contact points
SAMPLES, XI = 128, 0.02  # N where contact is sampled; damping
PEER, PEER_FOLDER = "pyharm-os==1.2.2", OUTPUT / "peer"  # its name in the package registry; installed nowhere else
SINGLE = {"JAX_ENABLE_X64": "1", "XLA_FLAGS": "--xla_cpu_multi_thread_eigen=false intra_op_parallelism_threads=1", "NUMBA_NUM_THREADS": "1"}


class Chain:
    """A chain of N_c contact points; `omegas`: the frequencies that are compared [rad/s]."""

    def __init__(self, points):
        self.points, self.folder = points, OUTPUT / f"field/{points}"
        model = self.model = chain.model(points)
        self.K, self.M = (A.toarray() for A in (model.K, model.M))
        self.reduced = reference.craig_bampton(self.K, self.M, model.contact_dofs, model.force, model.preload, 3)
        self.contact = reference.Contact.uniform(points, 2 / points, 1 / points, 0.5)
        self.preload = reference.contact_preload(self.reduced, self.contact)
        _, phi, psi = reference.bases(self.K, self.M, model.contact_dofs, 3)
        self.tip = np.concatenate([phi[0], psi[0]])  # t1 of the tip, the first elastic dof, from the reduced unknowns
        omega, q, _ = self.curve(10, "exact", (0.8, 2.6), ())
        self.peak = round(float(omega[np.argmax(self.amplitudes(q))]), 3)
        self.omegas = [place * self.peak for place in PLACES]
        self.sweep = tuple(end * self.peak for end in SWEEP)
        steps = [omega for omega in np.linspace(*self.sweep, WALK) if np.abs(omega - self.omegas).min() > 1e-6]
        self.walk = sorted([*steps, *self.omegas])

    def amplitudes(self, q):
        """First harmonic of the tip from coefficients (..., n, 2H+1)."""
        return np.hypot(*np.moveaxis(self.tip @ np.asarray(q)[..., 1:3], -1, 0))

    def curve(self, harmonics, samples, sweep, at):
        """Dovetail: omega, coefficients, seconds of processor per point of the curve."""
        folder = self.folder / f"{harmonics}_{samples}"
        weigh([BINARY, "run", chain.write(folder, self.points, harmonics, samples, omega=sweep, at=at), "--out", folder])
        results, (summary, _) = Results(folder / "results.h5"), summary_of(folder)
        cpu = next(sum(stage["cpu"]) for stage in summary["stages"] if stage["name"] == "5 branch")
        return results.omega, results.coefficients, cpu / len(results)

    def dovetail(self, harmonics, samples="exact"):
        omega, q, seconds = self.curve(harmonics, samples, self.sweep, self.omegas)
        here = [int(np.argmin(np.abs(omega - wanted))) for wanted in self.omegas]
        assert np.allclose(omega[here], self.omegas, rtol=1e-9), "not all frequencies were passed"
        return self.amplitudes(q[here]), seconds, seconds * len(omega)

    def sampled(self, harmonics):
        return self.dovetail(harmonics, SAMPLES)

    def system(self, harmonics):
        return reference.HarmonicBalance(self.reduced, self.contact, self.preload, XI, [0, 1, 0], harmonics, SAMPLES)

    def numpy(self, harmonics):
        """dovetail.reference, from frequency to frequency."""
        system, q, found = self.system(harmonics), None, {}
        began = time.process_time()
        for omega in self.walk:
            q = system.solve(omega, q)
            found[omega] = self.amplitudes(q)
        spent = time.process_time() - began
        return np.array([found[omega] for omega in self.omegas]), spent / len(self.walk), spent

    def newmark(self, accuracy):
        """From rest, with 2 pi / sqrt(accuracy) steps in a period."""
        system, steps = self.system(1), int(np.ceil(2 * np.pi / np.sqrt(accuracy)))
        static = np.concatenate([np.zeros(3), -self.reduced.r])
        began = time.process_time()
        found = [abs(steady_harmonic(system, static, omega, steps, accuracy, self.tip)[0]) for omega in self.omegas]
        spent = time.process_time() - began
        return np.array(found), spent / len(found), spent

    def events(self, accuracy):
        """build/integrate, from rest: from contact event to contact event; what it says of its time is wall time."""
        case = chain.write(self.folder / "integrate", self.points, 1, omega=self.sweep)
        text, _ = weigh([INTEGRATE, case, "--tolerance", accuracy, "--work", WORK, *map(repr, map(float, self.omegas))])
        said = [json.loads(line) for line in text.splitlines() if line.startswith("{")]
        if not all(answer["settled"] for answer in said):
            raise RuntimeError("not settled")
        spent = sum(answer["seconds"] for answer in said)
        return self.amplitudes([answer["coefficients"] for answer in said]), spent / len(said), spent

    def pyharm(self, harmonics):
        """field_pyharm.py in a process of its own, from frequency to frequency."""
        asked = {"K": self.K.tolist(), "M": self.M.tolist(), "force": self.model.force.tolist(), "xi": XI, "mu": 0.5,
                 "kn": 2 / self.points, "kt": 1 / self.points, "N0": self.preload.g[:, 2].tolist(), "samples": SAMPLES,
                 "omegas": list(map(float, self.walk)), "harmonics": harmonics}
        run = subprocess.run([sys.executable, ROOT / "scripts/bench/field_pyharm.py"], input=json.dumps(asked), text=True,
                             cwd=self.folder, capture_output=True,  # it leaves files there and in the home folder
                             env=os.environ | SINGLE | {"PYTHONPATH": str(PEER_FOLDER), "HOME": str(self.folder)})
        if run.returncode:
            raise RuntimeError((run.stderr.strip().splitlines() or ["no answer"])[-1])
        answer = json.loads(run.stdout.splitlines()[-1])
        here = [self.walk.index(omega) for omega in self.omegas]
        return np.array(answer["amplitudes"])[here], answer["seconds"] / (len(self.walk) - 1), answer["seconds"]

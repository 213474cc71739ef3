"""Results of the ring's sector, as the program computes them in a second: under a load that travels round it, or of the sector alone."""

from ring import N, sector

from dovetail import Joint, Results
from launch import BINARY, words_of

ORDER = 2
CASE = """model = "model.h5"
reduction.modes = 8
damping.stiffness = 5e-3
excitation = {{ fourier = [0, 1]{order} }}
harmonic_balance.harmonics = 3
continuation.omega = {omega}
stability.enabled = false
output.motion = {motion}
"""
STIFF = {"normal_stiffness": 1e3, "tangential_stiffness": 5e2, "friction": 0.3}


def computed(folder, cyclic=True, motion='"all"'):
    """Results of the ring's sector, in contact with the next one or with the ground."""
    structure = sector().with_springs("bore", [50, 50, 50]).with_force("over_right", [0.4, 1.0, 0.6]).with_preload("over_right", [0, 0, 1])
    if cyclic:
        structure = structure.cyclic(N, "left", "right", (0, 0, 1)).with_preload("over_left", [0, 0, -1])
        joint = Joint.between(structure.surface("over_right"), structure.surface("over_left"), next_sector=True, gap=-1e-3, **STIFF)
    else:
        joint = Joint.ground(structure.surface("over_right"), gap=-1e-3, **STIFF)
    structure.join(joint).write(folder / "model.h5")
    omega = "[1.0, 1.6]" if cyclic else "[1.1, 1.25]"
    order = f", engine_order = {ORDER}" if cyclic else ""
    (folder / "case.toml").write_text(CASE.format(order=order, omega=omega, motion=motion))
    words_of([BINARY, "run", folder / "case.toml", "--out", folder, "-modes_eps_type", "lapack"])
    return Results(folder / "results.h5")

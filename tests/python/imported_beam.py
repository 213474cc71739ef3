"""What the tests of importers put around the beam they read: a set-up file that shakes one set and holds another, and a case."""

SETUP = """[[force]]
set = "{shaken}"
vector = [0, 1, 0]

[[joint]]
ground = "{held}"
normal_stiffness = 1e3
tangential_stiffness = 1e3
friction = 0.3
"""
CASE = """model = "model.h5"
[reduction]
modes = 3
[damping]
stiffness = 1e-6
[excitation]
fourier = [0, 1, 0]
[harmonic_balance]
harmonics = 3
[continuation]
omega = [1.0, 2.0]
step = 0.1
"""

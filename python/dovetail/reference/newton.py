"""Newton's method."""

import numpy as np


def newton(residual, jacobian, x, tolerance=1e-11, iterations=60):
    """Newton's method, steps halved while they do not reduce the residual; ends when the step is below `tolerance` |x|."""
    for _ in range(iterations):
        r = residual(x)
        step = -np.linalg.solve(jacobian(x), r)
        if np.linalg.norm(step) <= tolerance * np.linalg.norm(x + step):
            return x + step
        part = 1.0
        while part > 1e-3 and np.linalg.norm(residual(x + part * step)) >= np.linalg.norm(r):
            part /= 2
        x = x + part * step
    raise RuntimeError(f"Newton's method did not converge in {iterations} iterations")

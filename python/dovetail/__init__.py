"""Dovetail: forced response of structures with frictional joints; set-up and post-processing in Python."""

from . import blas_kernel

blas_kernel.settle()  # before the rest: it may start the interpreter anew

from .joint import Joint
from .model import Model
from .results import Results
from .running import run
from .structure import Structure
from .studies import Study
from .study_runs import RunFailed
from .surface import Surface

__version__ = "0.1.0"
__all__ = ["Joint", "Model", "Results", "RunFailed", "Structure", "Study", "Surface", "__version__", "run"]

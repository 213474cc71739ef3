"""Dovetail: forced response of structures with frictional joints; set-up and post-processing in Python."""

from .model import Model
from .results import Results

__version__ = "0.1.0"
__all__ = ["Model", "Results", "__version__"]

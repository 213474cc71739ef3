"""Which kernel of OpenBLAS computes in NumPy and SciPy, and whether it suits the processor.

OpenBLAS chooses its kernel when it is loaded, and without a word takes the slowest for a processor that it does not
know. `python3 -m dovetail` then starts itself anew, once, with OPENBLAS_CORETYPE set, as the program does. A script
that imports the package is never started anew: a warning tells what to set. Nothing is done where the user has set
OPENBLAS_CORETYPE, and nothing is said of a BLAS that is not the system's, such as the one inside a NumPy from pip.
"""

import ctypes
import os
import sys
import warnings
from dataclasses import dataclass
from functools import lru_cache
from importlib import import_module
from pathlib import Path

CHOICE = "OPENBLAS_CORETYPE"
MARK = "DOVETAIL_REPLACED_KERNEL"  # set from one start to the next only
SSE, AVX, AVX2, AVX512 = range(4)  # by speed
CLASSES = ["katmai coppermine northwood prescott banias atom core2 penryn dunnington nehalem athlon opteron "
           "opteron_sse3 barcelona nano bobcat", "sandybridge bulldozer piledriver steamroller",
           "excavator haswell zen", "skylakex cooperlake sapphirerapids"]
SUITS = [None, "Sandybridge", "Haswell", "SkylakeX"]


@dataclass
class Kernel:
    """The kernel at work, and whose choice it is; `name` is empty where BLAS is not the system's OpenBLAS."""

    name: str
    better: str = ""  # would suit the processor
    user: str | None = None  # what the user asked for
    asked: str = ""  # by this package
    replaced: str = ""  # OpenBLAS's own choice then

    def __str__(self):
        why = "chosen by OpenBLAS"
        if self.user is not None and self.user.lower() == self.name.lower():
            why = f"set by {CHOICE}"
        elif self.user is not None:
            why = f'not "{self.user}", as {CHOICE} asks for'
        elif self.replaced and self.asked.lower() == self.name.lower():
            why = f"chosen by Dovetail instead of {self.replaced}"
        elif self.replaced:
            why = f"though Dovetail asked for {self.asked} instead of {self.replaced}"
        return f"{self.name} ({why}" + (f"; {self.better} would suit this processor)" if self.better else ")")


def class_of(name):
    """SSE, AVX, ...; None if nothing is known of a kernel of this name."""
    return next((number for number, names in enumerate(CLASSES) if name.lower() in names.split()), None)


def class_of_processor(cpuinfo="/proc/cpuinfo"):
    """The same of the processor, as far as the system lets it be used; None if it is no x86."""
    try:
        flags = next(line for line in Path(cpuinfo).read_text().splitlines() if line.startswith("flags")).split()
    except (OSError, StopIteration):
        return None
    if {"avx512f", "avx512dq", "avx512bw", "avx512vl", "avx512cd"} <= set(flags):
        return AVX512
    if {"avx2", "fma"} <= set(flags):
        return AVX2
    return AVX if "avx" in flags else SSE


def better(name, processor):
    """A kernel that suits the processor, where this one is of a lower class; else empty."""
    present = class_of(name)
    return "" if None in (present, processor) or present >= processor else SUITS[processor]


def _answer(function):
    """What a function of the OpenBLAS that is loaded says; empty if it is another BLAS."""
    for library in ("libblas.so.3", "libopenblas.so.0"):
        try:
            ask = getattr(ctypes.CDLL(library, mode=os.RTLD_NOW | os.RTLD_NOLOAD), function)
        except (OSError, AttributeError):  # not loaded, or not of OpenBLAS
            continue
        ask.restype = ctypes.c_char_p
        return (ask() or b"").decode()
    return ""


@lru_cache
def kernel_at_work():
    """The kernel in this process. The first call takes what the package asked for out of the environment."""
    import_module("numpy")  # which loads BLAS
    name = _answer("openblas_get_corename")
    kernel = Kernel(name, better(name, class_of_processor()))
    kernel.replaced = os.environ.pop(MARK, "")
    if kernel.replaced:
        kernel.asked = os.environ.pop(CHOICE, "")
    else:
        kernel.user = os.environ.get(CHOICE)
    return kernel


def in_words():
    """Library and kernel in one line."""
    name = " ".join(_answer("openblas_get_config").split()[:2])  # "OpenBLAS 0.3.21 DYNAMIC_ARCH ..."
    return f"{name}, kernel {kernel_at_work()}" if name else "that of NumPy"


def settle():
    """Starts `python3 -m dovetail` anew, or warns, where a better kernel is possible and the user has not chosen."""
    kernel = kernel_at_work()
    if not kernel.better or kernel.user is not None:
        return
    if _is_own_command() and not kernel.replaced and "DYNAMIC_ARCH" in _answer("openblas_get_config"):
        try:
            os.execve(sys.executable, sys.orig_argv, os.environ | {CHOICE: kernel.better, MARK: kernel.name})
        except OSError:
            pass  # goes on with the kernel that there is
    remedy = f"set {CHOICE}={kernel.better} before Python starts"
    warnings.warn(f"OpenBLAS kernel: {kernel}: {remedy}", RuntimeWarning, stacklevel=3)


def _is_own_command():
    """Whether Python was started as `python3 -m dovetail`, nothing of which has been done yet."""
    if sys.argv[:1] != ["-m"] or "mpi4py.MPI" in sys.modules:  # Python's word for a module that it still looks for
        return False
    return sys.orig_argv[sys.orig_argv.index("-m") + 1:][:1] == ["dovetail"]

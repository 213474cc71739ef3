"""A run while it goes on: `python3 -m dovetail watch RESULTS.h5`. Reads what the run writes, and nothing else."""

import fcntl
import json
import shutil
import sys
import time
from pathlib import Path

from .results import Results
from .text_plot import text_plot
from .units import bracket

PAUSE = 1.0  # between pictures [s], at least; a picture that takes long is drawn less often
SHARE = 9  # times what drawing takes, the pause after it
BAR = 40  # characters of a bar
CLEAR = "\x1b[H\x1b[J"  # the cursor to the top left, and all away


def is_running(folder):
    """Whether a run holds the folder: by its lock, which goes however the run ends."""
    try:
        with open(folder / "dovetail.lock") as lock:
            fcntl.flock(lock, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    except OSError:  # no such file; or no locks there, and then nothing is known
        return False
    return False


def content(file):
    """Of a JSON file, {} where there is none."""
    try:
        found = json.loads(file.read_text())
    except (OSError, ValueError):
        return {}
    return found if isinstance(found, dict) else {}


def bar(share):
    """A share from 0 to 1, drawn."""
    full = round(BAR * min(max(share, 0.0), 1.0))
    return f"[{'#' * full}{'.' * (BAR - full)}]"


def span(seconds):
    return f"{seconds:.0f} s" if seconds < 100 else time.strftime("%H:%M:%S", time.gmtime(seconds))


def progress(running, status, summary, points):
    """What is told above the curve."""
    if not running:
        end = summary.get("end") or "broken off"
        why = f": {summary['why']}" if summary.get("why") else ""
        return [f"ended ({end}), {points} points{why}"]
    state, stage = status.get("state", "running"), status.get("stage", "").partition(" ")[2]
    lines = [f"{state}{f' ({stage})' if stage and state != 'following' else ''}, {points} points, {span(status.get('seconds', 0.0))}"]
    if "done" in status:
        left = status.get("left")
        lines.append(f"{100 * status['done']:.0f} %" + (f", about {span(left)} left" if left is not None else ""))
    return lines


def head_of(path, running, model=None):
    """The results so far or None, the title, lines about how far the run is, and what status.json says."""
    status = content(path.with_name("status.json")) if running else {}
    results = None
    if path.is_file() and (not running or not status or "points" in status):  # else it is of the run before
        results = Results(path, model)
    points = 0 if results is None else len(results)
    title = results.title if results is not None and results.title else str(path)
    title = "".join(letter if letter.isprintable() else "?" for letter in title)  # no command of the terminal
    return results, title, progress(running, status, content(path.with_name("summary.json")), points), status


def shares_of(results):
    """States of the contact points at the last point of the curve."""
    return "   ".join(f"{state} {100 * results.points(state)[-1]:3.0f} %" for state in ("stick", "slip", "open"))


def frame(path, running, dof=None, width=80, height=24, model=None):
    """One picture as text."""
    results, title, lines, status = head_of(path, running, model)
    if "done" in status:
        lines[-1] = f"{bar(status['done'])} {lines[-1]}"
    head = [title, *lines]
    if results is None or not len(results):
        return "\n".join([*head, "no point yet"])
    dof = dof or results.watched
    curve, name = results.response(dof), results.parameter_name or "frequency"
    kinds = "".join(letter * round(BAR * results.points(state)[-1]) for state, letter in (("stick", "="), ("slip", "~"), ("open", " ")))
    foot = [f"contact points at the last point (@): {shares_of(results)}", f"[{kinds[:BAR]:<{BAR}}]  = stick, ~ slip, blank open"]
    labels = f"{name.replace('_', ' ')}{bracket(results.along_unit)}", f"amplitude of {dof}{bracket(curve.unit)}"
    rest = height - len(head) - len(foot) - 2
    return "\n".join([*head, *text_plot(results.along, curve.amplitude, width, rest, results.jumps, labels), *foot])


def watch(arguments):
    """The command."""
    path = Path(arguments.file)
    if path.is_dir():
        path = path / "results.h5"
    running = is_running(path.parent)
    if not running and not path.is_file():
        raise ValueError(f"{path}: no such file, and no run goes on in that folder")
    if arguments.page is not None:
        from .watch_page import Page, serve

        return serve(Page(path, arguments.dof, arguments.model), arguments.page)
    if arguments.once:
        return print(frame(path, running, arguments.dof, model=arguments.model))
    if not sys.stdout.isatty():
        raise ValueError("watch: standard output is no terminal; --once prints one picture")
    try:
        while True:
            began, running = time.monotonic(), is_running(path.parent)
            size = shutil.get_terminal_size()
            print(CLEAR + frame(path, running, arguments.dof, size.columns, size.lines, arguments.model), flush=True)
            if not running:
                return
            time.sleep(max(PAUSE, SHARE * (time.monotonic() - began)))
    except KeyboardInterrupt:
        print()

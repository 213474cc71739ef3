"""Arguments of the commands of python3 -m dovetail."""

import argparse
import math

from . import __version__, commands, life
from .case_changes import CONTACT, NAMES
from .importers import FORMATS


def samples(word):
    """Argument of --samples: a whole number, or "exact"."""
    return word if word == "exact" else int(word)


def finite(word):
    """Argument of --at."""
    value = float(word)
    if not math.isfinite(value):
        raise argparse.ArgumentTypeError(f"a finite number is wanted, found {word}")
    return value


class Parser(argparse.ArgumentParser):
    """Options in full: verify's --points must not be taken for the --point of others."""

    def __init__(self, *given, **named):
        super().__init__(*given, allow_abbrev=False, **named)


def parser():
    top = Parser(prog="python3 -m dovetail", description="Set-up and post-processing for dovetail, which computes "
                                  "the forced response of structures with frictional joints.")
    top.add_argument("--version", action="version", version=f"dovetail {__version__}",
                     help="with -v: the libraries, too, and which kernel of OpenBLAS computes")
    adding = top.add_subparsers(required=True, metavar="COMMAND")

    command = adding.add_parser("new", help="a folder to start from", description="Make a folder with a small jointed model, "
                                  "a commented case file and a README, ready to run.")
    command.add_argument("name", metavar="NAME", help="folder to make; must not exist")
    command.set_defaults(run=commands.new)

    command = adding.add_parser("import", help="convert files of other programs", description="Convert files of other programs to a "
                                  "model file (or reduced matrices, with csv, to a reduced file).",
                                  formatter_class=argparse.RawDescriptionHelpFormatter, epilog="formats and their files:\n" +
                                  "".join(f"  {name:<10}{files}\n" for name, files in FORMATS.items()) +
                                  "\ndocs/how-to/import-FORMAT.md says how to write them,\n"
                                  "docs/reference/joints-file.md what JOINTS.toml may hold.")
    command.add_argument("format", metavar="FORMAT", choices=list(FORMATS), help=", ".join(FORMATS))
    command.add_argument("files", metavar="FILES", nargs="+", help="see below")
    command.add_argument("--setup", metavar="JOINTS.toml",
                         help="supports, loads and joints by the names of sets; needed for files with a mesh")
    command.add_argument("-o", "--output", metavar="MODEL.h5", required=True, help="file to write")
    command.set_defaults(run=commands.import_)

    command = adding.add_parser("plot", help="draw results, or a mesh", description="Draw a picture of a results file, also of one "
                                  "that is still being written, or of the mesh and contact points of a model file. Prints the name of "
                                  "the picture.")
    command.add_argument("file", metavar="FILE.h5", help="results or model")
    command.add_argument("further", metavar="MORE.h5", nargs="*", help="more results, whose curves are drawn into the same picture")
    command.add_argument("--labels", metavar="TEXT", nargs="+", help="of the curves of several results; default: titles or folders")
    command.add_argument("--dof", metavar="NAME", nargs="+", help="a1, a2, ... (modes), x1.t1, x1.t2, x1.n, ... (contact points), "
                         "tip.y, 17.z, ... (node sets and nodes of the model); default: the loaded node, and the contact point that "
                         "is watched or moves most")
    command.add_argument("--kind", choices=["response", "history", "hysteresis", "map", "pressure", "sensitivity", "mode",
                                              "diameters", "campbell", "motion", "waterfall"], default="response",
                         help="default: %(default)s; map: which contact points slip or open over a period, in the plane of each joint; "
                              "pressure: the joints under their preload; sensitivity: which contact points a peak depends on; mode: "
                              "frequency and damping over the amplitude, peaks over the force, of a run with [mode]; diameters: frequency "
                              "over the nodal diameter of a cyclic sector, with the engine orders of the sweep; campbell: over its rotor "
                              "speed; motion: the mesh as it moves, enlarged, a whole wheel of a cyclic sector; waterfall: curves "
                              "of several results, one above the other")
    command.add_argument("--at", metavar="OMEGA", type=finite, help="frequency in units of the model, rad/s (in Hz with --hz), or value "
                         "of the parameter that is varied: marked in "
                         "the response, chosen for the others; default there: the peak of the first dof")
    command.add_argument("--model", metavar="MODEL.h5", help="the model file, for maps, pressures and nodes, if it is not where it "
                         "was when the run started")
    command.add_argument("--harmonic", metavar="K", type=int, help="mode: that of the load which excites the mode; default: its lowest")
    command.add_argument("--sector", metavar="J", type=int, help="of a cyclic structure, for motion (default: all) and history (0)")
    command.add_argument("--up", choices="xyz", default="z", help="mesh, motion: the axis that points upwards; default: %(default)s")
    command.add_argument("--hz", action="store_true", help="frequencies in Hz")
    command.add_argument("-o", "--output", metavar="FILE.png", help="picture to write; default: beside the results; of motion also "
                         "FILE.gif, a film of one period")
    command.set_defaults(run=commands.plot)

    _export_options(adding)
    _stress_options(adding)

    command = adding.add_parser("info", help="what is in a file", description="Sizes, units, range and peaks of model, reduced and "
                                  "results files.")
    command.add_argument("files", metavar="FILE.h5", nargs="+")
    command.set_defaults(run=commands.info)

    command = adding.add_parser("peaks", help="table of peaks over the force, from one nonlinear mode", description="For each force: "
                                  "amplitude, frequency, damping ratio, shares of the contact points that slip and open, friction "
                                  "energy and estimated error at the peak, from the results of one run with [mode]. Printed, and written "
                                  "as csv and text.")
    command.add_argument("file", metavar="RESULTS.h5")
    command.add_argument("--force", metavar="F", nargs="+", type=float, help="factors on the loads of the case; default: 1, 2, 5 times "
                         "powers of ten, from where the joint sticks to what the mode reaches")
    command.add_argument("--dof", metavar="NAME", help="the unknown or node whose peaks are meant; default: the one that is watched")
    command.add_argument("--harmonic", metavar="K", type=int, help="that of the load which excites the mode; default: its lowest")
    command.add_argument("--refine", action="store_true", help="solve the true equations near each peak")
    command.add_argument("--hz", action="store_true", help="frequencies in Hz")
    command.add_argument("--model", metavar="MODEL.h5", help="the model file, for nodes, if it is not where it was when the run started")
    command.add_argument("-o", "--output", metavar="FILE.csv", help="table to write, FILE.txt beside it; default: beside the results")
    command.set_defaults(run=commands.peaks)

    _looking_options(adding)

    command = adding.add_parser("study", help="speed against accuracy on a case", description="Run a case with a grid of settings, "
                                  "compare each with a reference of at least twice the harmonics and exact contact forces, and write "
                                  "table, JSON and chart of error against time. Called again, it goes on where it was broken off.")
    command.add_argument("case", metavar="CASE.toml")
    command.add_argument("--harmonics", metavar="H", nargs="+", type=int,
                         help="default: that of the case, and 1 3 5 7 10 15 20 30 40 up to twice it")
    command.add_argument("--samples", metavar="N", nargs="+", type=samples,
                         help="per period, or exact; default: that of the case, and 64 256 exact")
    command.add_argument("--tolerances", metavar="TOL", nargs="*", type=float, help="for harmonics that are chosen along the curve; "
                         "default: 1e-2 1e-3 1e-4; without a number: none")
    command.add_argument("--modes", metavar="N_A", nargs="+", type=int, help="default: those of the case")
    command.add_argument("--solvers", nargs="+", choices=["modal", "assembled"], help="default: that of the case")
    _running_options(command, "CASE_study")
    command.set_defaults(run=commands.study)
    _range_options(adding)
    _fit_options(adding)
    _wear_options(adding)
    _wheel_options(adding)
    return top


def _export_options(adding):
    command = adding.add_parser("export", help="files for ParaView, and tables", description="Write a folder that ParaView opens: the "
                                  "mesh in motion over one period (motion.pvd), the contact points with their states and forces "
                                  "(contact.pvd), and the curve as a table (curve.csv).")
    command.add_argument("file", metavar="RESULTS.h5")
    _point_options(command)
    command.add_argument("--frames", metavar="N", type=int, help="instants of the period; default: 24")
    command.add_argument("--along", metavar="N", type=int, help="in place of a period: so many points, evenly over the curve, its ends "
                         "and peaks among them, each at the instant of its largest motion")
    command.add_argument("--sector", metavar="J", type=int, help="of a cyclic structure, in its place; default: 0")
    command.add_argument("--wheel", action="store_true", help="all sectors of a cyclic structure, their outer faces")
    cells = command.add_mutually_exclusive_group()
    cells.add_argument("--surface", action="store_true", help="outer faces in place of the cells, also of one sector")
    cells.add_argument("--solid", action="store_true", help="the cells in place of outer faces, also of a wheel")
    command.add_argument("--dof", metavar="NAME", nargs="+", help="columns of the table, as in plot")
    command.add_argument("--model", metavar="MODEL.h5", help="the model file, if it is not where it was when the run started")
    life.add_options(command, finite)
    command.add_argument("--wear", metavar="K", type=finite, help="wear: volume that a unit of friction work takes away, in units of the "
                         "model [m^3/J]; gives the depth after a million periods")
    command.add_argument("--replace", action="store_true", help="also files that no export has written")
    command.add_argument("-o", "--output", metavar="DIR", help="folder to write; default: RESULTS_paraview beside the results; of a name "
                         "that ends with .csv: the table alone")
    command.set_defaults(run=commands.export)


def _stress_options(adding):
    command = adding.add_parser("stress", help="stress and utilisation of the part", description="Stress at the nodes from the static "
                                  "preload and the harmonics of a point of the curve: mean and amplitude over the period, and with the "
                                  "strengths of the material the utilisation by Goodman's line. Lists the worst points.")
    command.add_argument("file", metavar="RESULTS.h5")
    _point_options(command)
    command.add_argument("--dof", metavar="NAME", nargs=1, help="whose peak is meant, as in plot; default: the loaded node")
    command.add_argument("--worst", metavar="N", type=int, default=10, help="points of the list; default: %(default)s")
    command.add_argument("--without", metavar="SET", nargs="+", default=[], help="without the nodes of these sets, such as a patch of "
                         "contact")
    command.add_argument("--reaction", metavar="SET", nargs="+", help="also the forces of the supports in the held directions of node sets")
    command.add_argument("--up", choices="xyz", default="z", help="the axis that points upwards in the picture; default: %(default)s")
    command.add_argument("--model", metavar="MODEL.h5", help="the model file, if it is not where it was when the run started")
    life.add_options(command, finite)
    command.add_argument("-o", "--output", metavar="FILE", nargs="+", default=[], help="FILE.csv: a table of all nodes; FILE.png: a "
                         "picture of the part and the Haigh diagram")
    command.set_defaults(run=commands.stress)


def _point_options(command):
    command.add_argument("--at", metavar="OMEGA", type=finite, help="frequency in units of the model, rad/s (in Hz with --hz), or value "
                         "of the parameter that is varied; default: the peak of the first dof")
    command.add_argument("--point", metavar="I", type=int, help="the point of the curve, counted from 0, or from its end if negative")
    command.add_argument("--hz", action="store_true", help="--at is in Hz")


def _looking_options(adding):
    command = adding.add_parser("verify", help="points computed again, without the program", description="Compute points of results "
                                  "again in NumPy alone: what is missing of the equations, and whether the work put in is what damping "
                                  "and friction take. Exit status 3 where a point does not hold.")
    command.add_argument("file", metavar="RESULTS.h5")
    command.add_argument("--points", metavar="N", type=int, default=12, help="how many, evenly over the curve, from 2 on with its ends, "
                         "from 3 on with its largest, then its peaks; default: %(default)s, which take some ten seconds")
    command.add_argument("--model", metavar="MODEL.h5", help="the model file, if it is not where it was when the run started")
    command.set_defaults(run=commands.verify)

    command = adding.add_parser("watch", help="a run while it goes on", description="Draw the curve, the states of the contact points "
                                  "and the progress of a run in the terminal, anew each second, until the run ends.")
    command.add_argument("file", metavar="RESULTS.h5", help="the file, or the folder of the run")
    command.add_argument("--dof", metavar="NAME", help="the unknown that is drawn; default: the one that is watched or moves most")
    command.add_argument("--model", metavar="MODEL.h5", help="the model file, for nodes, if it is not where it was when the run started")
    shown = command.add_mutually_exclusive_group()
    shown.add_argument("--once", action="store_true", help="one picture, now")
    shown.add_argument("--page", metavar="PORT", nargs="?", type=int, const=0, help="as a page for a browser on this machine, in place "
                       "of the terminal; default: a port that is free. Prints its address")
    command.set_defaults(run=commands.watch)


def _range_options(adding):
    command = adding.add_parser("range", help="what ranges of parameters make of a peak", description="Run a case with parameters "
                                  "between two numbers: first order from the middle, the peak over each parameter, and samples of all of "
                                  "them. Numbers are values for all contact points; with an x behind them, factors on what the case has "
                                  "(0.5x 2x). Called again, it goes on where it was broken off.")
    command.add_argument("case", metavar="CASE.toml")
    for name in CONTACT:
        command.add_argument(f"--{name}", metavar=("FROM", "TO"), nargs=2, help="offsets, added to what the case has"
                             if name == "gap" else "values, or factors as 0.5x 2x")
    command.add_argument("--force", metavar=("FROM", "TO"), nargs=2, help="factors on all loads, as 0.9x 1.1x")
    command.add_argument("--damping", metavar=("FROM", "TO"), nargs=2, help="factors on all numbers of [damping]")
    command.add_argument("--preload", metavar=("FROM", "TO"), nargs=2, help="factors on the static load")
    command.add_argument("--omega", metavar=("FROM", "TO"), nargs=2, type=float, help="sweep that holds the peak, in the unit of the case; "
                         "default: that of the case")
    command.add_argument("--watch", metavar="NAME", help="the unknown or node whose largest peak is meant; default: that of the case")
    command.add_argument("--samples", metavar="N", type=int, default=128, help="of all ranges together; default: %(default)s; 0: none")
    command.add_argument("--along", metavar="N", type=int, default=9,
                         help="points over each parameter alone; default: %(default)s; 0: none")
    command.add_argument("--track", action="store_true", help="follow the peak over each parameter alone, in one run each, in place of "
                         "sweeps")
    command.add_argument("--sliders", metavar="N", type=int, help="N states of friction that the preload may leave where points stick, "
                         "besides none, and all that friction allows in each direction")
    command.add_argument("--each-point", action="store_true", help="contact points vary each by itself in the samples, not all alike")
    command.add_argument("--until-peak", metavar="N", type=int, help="end every sweep behind so many peaks: quicker, without the band of "
                         "curves")
    command.add_argument("--seed", metavar="N", type=int, default=1, help="of the samples; default: %(default)s")
    _running_options(command, "CASE_range")
    command.set_defaults(run=commands.ranges)


def _fit_options(adding):
    command = adding.add_parser("fit", help="parameters of a joint from measured curves", description="Find factors on parameters of "
                                  "a case by which its response curves, or its nonlinear mode, fit measured ones, by least squares of "
                                  "relative errors, with confidence intervals. Called again, it goes on where it was broken off.")
    command.add_argument("case", metavar="CASE.toml")
    command.add_argument("measured", metavar="MEASURED.csv", nargs="+", help='frequency and amplitude in two columns, under a header that '
                         'says units: "frequency [Hz], amplitude [mm]"; several files want --force; of a case with [mode] a backbone: '
                         '"amplitude [mm], frequency [Hz], damping [%%]"')
    command.add_argument("--force", metavar="FACTOR", nargs="+", type=finite, help="factor on the loads of the case with which each file "
                         "was measured, in the order of the files; default, of a single file: 1")
    command.add_argument("--parameters", metavar="NAME", nargs="+", choices=[name for name in NAMES if name not in ("gap", "preload")],
                         help="friction, tangential_stiffness (the default), friction_1, friction_2, tangential_stiffness_1, "
                         "tangential_stiffness_2, normal_stiffness, damping, force")
    command.add_argument("--by-joint", action="store_true", help="a factor for each joint of the model, not one for all points")
    command.add_argument("--harmonic", metavar="K", type=int, help="what was measured is the amplitude of this harmonic; default: half the "
                         "peak-to-peak")
    command.add_argument("--watch", metavar="NAME", help="the unknown or node that was measured; default: that of the case")
    _running_options(command, "CASE_fit")
    command.set_defaults(run=commands.fit)


def _wear_options(adding):
    command = adding.add_parser("wear", help="wear of a joint over the cycles, and what it changes", description="Let a joint wear by "
                                  "the friction work of its motion: run, add the depth of a block of cycles to the gaps, run again. Called "
                                  "again, it goes on where it was broken off.")
    command.add_argument("case", metavar="CASE.toml")
    command.add_argument("--cycles", metavar="N", type=finite, required=True, help="periods of the vibration")
    coefficient = command.add_mutually_exclusive_group()
    coefficient.add_argument("--archard", metavar=("K", "UNIT"), nargs=2, help="volume per normal load and sliding distance, as 1e-15 1/Pa "
                             "or 1e-6 mm^3/Nm")
    coefficient.add_argument("--energy-wear", metavar=("K", "UNIT"), nargs=2, help="volume per friction work, as 1e-5 mm^3/J")
    command.add_argument("--at", metavar="OMEGA", type=finite, help="frequency of the motion, in the unit of the case; default: at every "
                         "moment that of the peak")
    command.add_argument("--share", metavar="S", type=finite, default=0.1, help="of how far a contact point is pressed in: what it loses "
                         "in a block at most; default: %(default)s")
    command.add_argument("--watch", metavar="NAME", help="the unknown or node whose peak is meant; default: that of the case")
    _folder_options(command, "CASE_wear")
    command.set_defaults(run=commands.wear)


def _wheel_options(adding):
    command = adding.add_parser("wheel", help="is a travelling wave stable", description="Of points of a cyclic sector's results: does "
                                  "a small motion of any nodal diameter die out or grow, and which are in it. By Hill's method in NumPy.")
    command.add_argument("file", metavar="RESULTS.h5")
    command.add_argument("--at", metavar="OMEGA", type=finite, nargs="+", help="in units of the model, rad/s (in Hz with --hz), "
                         "to the nearest points; default: the peaks, or the largest point")
    command.add_argument("--hz", action="store_true", help="frequencies in Hz")
    command.add_argument("--whole", action="store_true", help="also run the program on the whole wheel, all sectors as one structure, if "
                         "it is small")
    _folder_options(command, "RESULTS_wheel", "the results")
    command.set_defaults(run=commands.wheel)


def _running_options(command, folder):
    command.add_argument("--jobs", metavar="N", type=int, default=1, help="runs at a time; default: %(default)s")
    _folder_options(command, folder)


def _folder_options(command, folder, beside="the case"):
    command.add_argument("--out", metavar="DIR", help=f"folder to write; default: {folder} beside {beside}")
    command.add_argument("--binary", metavar="FILE",
                         help="the program; default: build/dovetail of this source tree, or dovetail on the path")

"""Pages of the documents: links, blocks, which are run, and numbers, which are recomputed. See docs/developer/testing.md."""

import math
import os
import re
import shutil
import signal
import subprocess
from dataclasses import dataclass
from decimal import Decimal

from launch import ROOT, SECONDS

PAGE_SECONDS = 3 * SECONDS  # far more than any page takes
SLOW_SECONDS = 40 * SECONDS  # the same with what is slow
MARK = "@@@ block"
CONSTANT = """tree=$PWD
constant() { sed -nE "s/.*\\b$2 = ([-+0-9.e]+).*/\\1/p" "$tree/$1"; }"""  # of a source file, for comments that recompute
NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
EFFORT = r"(?=\s+(?:s|ms|MiB|GiB)\b)"  # behind a number that the machine decides
COUNT = r"(?=\s+(?:points\b|Newton iterations|step cuts?|turning points?))"  # that last bits decide
NUMBERS = re.compile(r"^<!-- numbers([^:\n]*):(.*?)-->\n((?:[^\n]+\n)*)", re.MULTILINE | re.DOTALL)  # and the paragraph below
ROUNDING = 0.6  # of a unit of the last digit shown: a half, and a little for last bits
PROGRESS_ROW = re.compile(r"%\s+[\d.]+ s\s*$")


@dataclass
class Block:
    kind: str  # the word behind ```
    text: str
    line: int
    file: str  # the name in front of it, or empty
    given: str  # what a comment in front of it asks for, or empty
    output: str = None  # what the page shows below it
    within: float = 0.0  # relative: numbers in the text may be off so far
    slow: bool = False

    @property
    def is_run(self):
        return self.kind in ("sh", "python") or bool(self.file) or self.recomputes

    @property
    def recomputes(self):
        return self.kind.startswith("numbers")


@dataclass
class Finding:
    """What a page shows at a place, and what was found."""

    place: str
    shown: str
    found: str
    why: str  # they are not the same; empty if they are


def tracked(*patterns):
    """Files of the repository, as git knows them or, in a tree without git, as they lie there."""
    done = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", *patterns], cwd=ROOT, capture_output=True, text=True)
    if done.returncode == 0:
        return sorted(path for path in (ROOT / name for name in done.stdout.split("\n") if name) if path.is_file())
    return sorted(path for pattern in patterns for path in ROOT.rglob(pattern) if not any(part.startswith("build") for part in path.parts))


def blocks(page):
    """What a page has to be run: fenced blocks, each with the output shown below it, and comments that recompute numbers."""
    return sorted(fenced(page) + recomputing(page), key=lambda block: block.line)


def recomputing(page):
    """Comments "numbers: ...", each with the paragraph or table below it as output."""
    text, found = page.read_text(), []
    for match in NUMBERS.finditer(text):
        words = set(match[1].split())
        kind = "numbers python" if "python" in words else "numbers"
        within = [float(word) for word in words - {"python", "slow"}]
        found.append(Block(kind, match[2].strip() + "\n", text.count("\n", 0, match.start(3)) + 1, "", "", match[3], *within,
                           slow="slow" in words))
    return found


def fenced(page):
    found, rows, indent, block, before, given = [], [], 0, None, "", ""
    for number, line in enumerate(page.read_text().splitlines(), 1):
        words = line.strip()
        if block is not None:
            if words == "```":
                block.text = "".join(f"{row[indent:]}\n" for row in rows)
                if block.kind != "output":
                    found.append(block)
                elif found:
                    found[-1].output = block.text
                block, before, given = None, "", ""
            else:
                rows.append(line)
        elif words.startswith("```"):
            name = re.search(r"`([\w./-]+)`:$", before)
            block, rows, indent = Block(words[3:], "", number, name[1] if name else "", given), [], len(line) - len(line.lstrip())
        elif match := re.fullmatch(r"<!-- given: (.*) -->", words):
            given = match[1]
        elif words:
            before, given = words, ""
    assert block is None, f"{page}: the block of line {block.line} has no end"
    return found


def prose(page):
    """The text of a page without its blocks and code."""
    text = re.sub(r"^ *```.*?^ *```$|<!--.*?-->", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^    .*$", "", text, flags=re.MULTILINE) if page.suffix == ".md" else text
    return re.sub(r"`[^`\n]*`", lambda code: code[0] if "](" in code[0] else "", text)


def links(page):
    """Targets of the links and pictures of a page that lead into the repository."""
    found = re.findall(r"\]\(\s*([^)\s]+)\s*\)", prose(page))
    return [target for target in found if "://" not in target and not target.startswith("mailto:")]


def anchors(page):
    """What #names lead to in a page: its headings, as they are written in links."""
    text = re.sub(r"^ *```.*?^ *```$|<!--.*?-->", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    headings = re.findall(r"^#+ (.*)$", text, re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", heading.lower()).strip().replace(" ", "-") for heading in headings}


def users_folder(folder):
    """A copy of what a user has: the tree with its build. Models are written beside the inputs, so these are copies."""
    folder.mkdir(parents=True)
    for entry in ROOT.iterdir():
        if entry.name in ("inputs", "demo") or entry.name.startswith(".") or (entry.name.startswith("build") and entry.name != "build"):
            continue
        (folder / entry.name).symlink_to(entry)
    shutil.copytree(ROOT / "inputs", folder / "inputs", ignore=shutil.ignore_patterns("*.h5", "out", "__pycache__", "summary.json"))
    return folder


def lay_out_given(wish, folder, scratch):
    """The files of a job of tests/fuzz/importer_jobs.py, some under other names: "market K.mtx=stiff.mtx"."""
    import importer_jobs

    name, *renamed = wish.split()
    scratch.mkdir()
    job = importer_jobs.jobs(scratch).get(name)
    if job is None:
        return False
    importer_jobs.lay_out(job, folder)
    for old, new in (pair.split("=") for pair in renamed):
        (folder / old).rename(folder / new)
    return True


def script(parts, scratch):
    """All blocks of a page as one shell script, so that folder and variables last from one to the next; None if a reader is missing."""
    lines = ["set -eu -o pipefail", CONSTANT]
    for i, block in enumerate(parts):
        lines.append(f"echo '{MARK} {i}'")
        if block.given:
            folder = scratch / f"given{i}"
            if not lay_out_given(block.given, folder, scratch / f"made{i}"):
                return None
            lines.append(f"cp '{folder}'/* .")
        end = f"END_OF_BLOCK_{i}"
        if block.file:
            lines.append(f"cat > '{block.file}' <<'{end}'\n{block.text}{end}")
        elif block.kind.endswith("python"):
            lines.append(f"\"$PYTHON\" - <<'{end}'\n{block.text}{end}")
        else:
            lines.append(block.text)
        if block.recomputes:  # leaves folder and variables to the next one
            lines[-1] = f"(\n. \"$tree/scripts/environment\"\n{lines[-1]}\n)"
    return "\n".join(lines) + "\n"


def is_followed(page):
    """Whether a user follows the page from its first command to the last."""
    return page.resolve() in (ROOT / "README.md", *(ROOT / "docs/tutorial").glob("*.md"), *(ROOT / "docs/how-to").glob("*.md"))


def runnable(page, slow=False):
    """The blocks of a page that are run, without slow ones."""
    followed = is_followed(page)
    return [block for block in blocks(page) if (block.recomputes or block.is_run and followed) and (slow or not block.slow)]


def run(page, folder):
    """Runs the blocks of a page, as a user would who follows it, and compares what it shows. Returns complaints, or None to skip."""
    findings = examine(page, folder)
    if findings is None:
        return None
    return [f"{finding.place}: {finding.why}\nshown:\n{finding.shown}\nfound:\n{finding.found}" for finding in findings if finding.why]


def examine(page, folder, slow=False):
    """All that a page shows beside what was found; None if a reader of foreign files is missing."""
    parts = runnable(page, slow)
    scratch = folder / "scratch"
    scratch.mkdir(parents=True)
    text = script(parts, scratch)
    if text is None:
        return None
    (scratch / "page.sh").write_text(text)
    surroundings = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
    surroundings["PYTHONWARNINGS"] = "ignore:OpenBLAS kernel"  # said on some processors only; test_kernels.py asks for it
    process = subprocess.Popen(["bash", scratch / "page.sh"], cwd=users_folder(folder / "dovetail"), env=surroundings, text=True,
                               stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, start_new_session=True)
    try:
        said = process.communicate(timeout=SLOW_SECONDS if slow else PAGE_SECONDS)[0]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)  # what a block has started, too
        raise
    said = re.split(rf"^{MARK} \d+\n", said, flags=re.MULTILINE)[1:]
    ended = process.returncode and len(said) - 1
    findings = []
    for i, (block, found) in enumerate(zip(parts, said)):
        place = f"{page.name}:{block.line}"
        if process.returncode and i == ended:
            findings.append(Finding(place, block.text, found[-3000:], f"ended with {process.returncode}"))
        elif block.recomputes:
            findings += claims(page, block, found)
        elif block.output is not None:
            findings.append(Finding(place, block.output, found, difference(block.output, found)))
    return findings


def claims(page, block, found):
    """Lines that a comment prints, each beside the same words in the text below the comment."""
    findings, taken = [], []
    for line in (line.strip() for line in found.splitlines() if line.strip()):
        text, (pattern, numbers) = block.output.replace("\n", " "), expression(line)
        if line.startswith("|"):  # a row, and no part of a sentence
            text, pattern = block.output, "^" + pattern.replace(r"\s+", "[ \t]+")
        fits = []
        for match in re.finditer(rf"(?<![\w.]){pattern}(?![\d.]*\d)", text, re.MULTILINE):
            wrong = [f"{old} is {new}" for new, old in zip(numbers, match.groups()) if not as_printed(old, new, block.within)]
            if not any(match.start() < end and start < match.end() for start, end in taken):
                fits.append((len(wrong), match.span(), ", ".join(wrong)))
        if fits:
            _, (start, end), wrong = min(fits)
            taken.append((start, end))
            row = block.line + block.output.count("\n", 0, start)
            findings.append(Finding(f"{page.name}:{row}", text[start:end], line, wrong))
        else:
            findings.append(Finding(f"{page.name}:{block.line}", block.output, line, f'no such words in the text: "{line}"'))
    return findings or [Finding(f"{page.name}:{block.line}", block.output, "", "its comment prints nothing")]


def as_printed(shown, found, within):
    """Whether a number is what is shown, in the digits that are shown or within a relative tolerance."""
    unit = 10.0 ** Decimal(shown).as_tuple().exponent
    return abs(float(shown) - float(found)) <= max(ROUNDING * unit, within * abs(float(shown)))


def difference(shown, found):
    """Why an output is not the one shown; empty if it is."""
    shown, found = ([line.rstrip() for line in text.splitlines() if line.strip()] for text in (shown, found))
    furthest = 0
    reached = {0}  # numbers of lines found that the lines shown so far can account for
    for line in shown:
        if line.strip() == "...":
            reached = set(range(min(reached), len(found) + 1))
        else:
            reached = {j + 1 for j in reached if j < len(found) and same_line(line, found[j])}
        if not reached:
            return f'no such line at its place: "{line}" (after {furthest} lines that agree)'
        furthest = max(furthest, min(reached))
    return "" if len(found) in reached else "more is printed than is shown"


def same_line(shown, found):
    """Words are the same, numbers alike; "..." stands for anything."""
    pattern, numbers = expression(shown)
    whole = re.fullmatch(rf"\s*{pattern}", found)
    rests = [shown[match.end():] for match in re.finditer(NUMBER, shown)]
    kinds = ["any" if re.match(EFFORT, rest) else "count" if re.match(COUNT, rest) or PROGRESS_ROW.search(shown) else "value"
             for rest in rests]
    return whole is not None and all(alike(*three) for three in zip(numbers, whole.groups(), kinds))


def expression(line):
    """For the same words, whatever the numbers and the width of blanks; and the numbers of the line."""
    pattern, at = "", 0
    for match in re.finditer(rf"\.\.\.|\s+|{NUMBER}", line.strip()):
        pattern += re.escape(line.strip()[at:match.start()])
        pattern += ".*?" if match[0] == "..." else r"\s+" if match[0].isspace() else f"({NUMBER})"
        at = match.end()
    return pattern + re.escape(line.strip()[at:]), re.findall(NUMBER, line)


def alike(old, new, kind):
    if kind == "any":
        return True
    a, b = float(old), float(new)
    if kind == "count":
        return abs(a - b) <= max(3, 0.1 * abs(a)) if old.isdigit() else math.isclose(a, b, rel_tol=1e-2)
    return old == new if re.fullmatch(r"[-+]?\d+", old) else math.isclose(a, b, rel_tol=1e-3)

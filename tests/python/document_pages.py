"""Pages of the documents: their links, and their blocks, which are run. docs/developer/testing.md has the conventions."""

import math
import os
import re
import shutil
import signal
import subprocess
from dataclasses import dataclass

from launch import ROOT, SECONDS

PAGE_SECONDS = 3 * SECONDS  # far more than any page takes
MARK = "@@@ block"
NUMBER = r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?"
EFFORT = r"(?=\s+(?:s|ms|MiB|GiB)\b)"  # behind a number that the machine decides
COUNT = r"(?=\s+(?:points\b|Newton iterations|step cuts?|turning points?))"  # that last bits decide
PROGRESS_ROW = re.compile(r"%\s+[\d.]+ s\s*$")


@dataclass
class Block:
    kind: str  # the word behind ```
    text: str
    line: int
    file: str  # the name in front of it, or empty
    given: str  # what a comment in front of it asks for, or empty
    output: str = None  # what the page shows below it

    @property
    def is_run(self):
        return self.kind in ("sh", "python") or bool(self.file)


def tracked(*patterns):
    """Files of the repository, as git knows them or, in a tree without git, as they lie there."""
    done = subprocess.run(["git", "ls-files", "-co", "--exclude-standard", *patterns], cwd=ROOT, capture_output=True, text=True)
    if done.returncode == 0:
        return sorted(path for path in (ROOT / name for name in done.stdout.split("\n") if name) if path.is_file())
    return sorted(path for pattern in patterns for path in ROOT.rglob(pattern) if not any(part.startswith("build") for part in path.parts))


def blocks(page):
    """The fenced blocks of a page, each with the output shown below it."""
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
    text = re.sub(r"^ *```.*?^ *```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
    text = re.sub(r"^    .*$", "", text, flags=re.MULTILINE) if page.suffix == ".md" else text
    return re.sub(r"`[^`\n]*`", lambda code: code[0] if "](" in code[0] else "", text)


def links(page):
    """Targets of the links and pictures of a page that lead into the repository."""
    found = re.findall(r"\]\(\s*([^)\s]+)\s*\)", prose(page))
    return [target for target in found if "://" not in target and not target.startswith("mailto:")]


def anchors(page):
    """What #names lead to in a page: its headings, as they are written in links."""
    text = re.sub(r"^ *```.*?^ *```$", "", page.read_text(), flags=re.MULTILINE | re.DOTALL)
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
    lines = ["set -eu -o pipefail"]
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
        elif block.kind == "python":
            lines.append(f"\"$PYTHON\" - <<'{end}'\n{block.text}{end}")
        else:
            lines.append(block.text)
    return "\n".join(lines) + "\n"


def run(page, folder):
    """Runs the blocks of a page, as a user would who follows it, and compares what it shows. Returns complaints, or None to skip."""
    parts = [block for block in blocks(page) if block.is_run]
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
        said = process.communicate(timeout=PAGE_SECONDS)[0]
    except subprocess.TimeoutExpired:
        os.killpg(process.pid, signal.SIGKILL)  # what a block has started, too
        raise
    said = re.split(rf"^{MARK} \d+\n", said, flags=re.MULTILINE)[1:]
    if process.returncode:
        return [f"{page.name}:{parts[len(said) - 1].line}: ended with {process.returncode}\n{said[-1][-3000:]}"]
    complaints = []
    for block, found in zip(parts, said):
        if block.output is not None:
            why = difference(block.output, found)
            if why:
                complaints.append(f"{page.name}:{block.line}: {why}\nshown:\n{block.output}\nfound:\n{found}")
    return complaints


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
    pattern, kinds, at = "", [], 0
    for match in re.finditer(rf"\.\.\.|\s+|{NUMBER}", shown):
        pattern += re.escape(shown[at:match.start()])
        at = match.end()
        if match[0] == "...":
            pattern += ".*"
        elif match[0].isspace():
            pattern += r"\s+" if match.start() else r"\s*"
        else:
            pattern += f"({NUMBER})"
            rest = shown[at:]
            kinds.append((match[0], "any" if re.match(EFFORT, rest) else
                          "count" if re.match(COUNT, rest) or PROGRESS_ROW.search(shown) else "value"))
    whole = re.fullmatch(pattern + re.escape(shown[at:]), found)
    return whole is not None and all(alike(old, new, kind) for (old, kind), new in zip(kinds, whole.groups()))


def alike(old, new, kind):
    if kind == "any":
        return True
    a, b = float(old), float(new)
    if kind == "count":
        return abs(a - b) <= max(3, 0.1 * abs(a)) if old.isdigit() else math.isclose(a, b, rel_tol=1e-2)
    return old == new if re.fullmatch(r"[-+]?\d+", old) else math.isclose(a, b, rel_tol=1e-3)

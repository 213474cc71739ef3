"""What MkDocs makes the site of: a copy of the documents, and its settings, whose contents are those of docs/README.md."""

import json
import re
import shutil
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGES = re.compile(r"([A-Z]+|CITATION)(\.md|\.cff)?|(docs|inputs|tests)/.*\.(md|png|svg|ipynb)")
SETTINGS = {
    "site_name": "Dovetail",
    "docs_dir": "pages",
    "use_directory_urls": False,
    "theme": {"name": "material", "font": False, "features": ["navigation.sections", "search.highlight"]},
    "plugins": ["search"],
    "markdown_extensions": ["tables", "pymdownx.superfences", "pymdownx.highlight", "sane_lists", {"toc": {"permalink": True}}],
}
INDEX = "docs/README.md"


def contents():
    """Sections of the index, each a list of its pages: [{"Tutorial": ["docs/tutorial/first-run.md", ...]}, ...]."""
    sections, seen = [], set()  # MkDocs gives a page that stands there twice no title
    for line in (ROOT / INDEX).read_text().splitlines():
        if line.startswith("## "):
            sections.append((line[3:], []))
        for place in re.findall(r"\]\(([^)#]+\.md)", line):
            page = str((ROOT / "docs" / place).resolve().relative_to(ROOT))
            if sections and page not in seen:
                sections[-1][1].append(page)
                seen.add(page)
    return [{title: pages} for title, pages in sections]


def indented(text):
    """The same with what belongs to an item of a list twice as far in: Python's Markdown wants four blanks where others take two."""
    lines, inside, fenced, blank = [], False, False, True
    for line in text.splitlines():
        body = line.lstrip()
        if body.startswith("```"):
            fenced = not fenced
        elif not fenced and line == body and body:  # at the margin: an item, more of one, or something else
            inside = re.match(r"([-*]|\d+\.) ", body) is not None or inside and not blank
        lines.append(" " * (len(line) - len(body)) + line if inside else line)
        blank = not body
    return "\n".join(lines) + "\n"


def main(folder):
    pages = folder / "pages"
    shutil.rmtree(folder, ignore_errors=True)
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, check=True, capture_output=True, text=True).stdout.split()
    for name in filter(PAGES.fullmatch, tracked):
        (pages / name).parent.mkdir(parents=True, exist_ok=True)
        if name.endswith(".md"):
            (pages / name).write_text(indented((ROOT / name).read_text()))
        else:
            shutil.copyfile(ROOT / name, pages / name)
    nav = [{"Dovetail": "README.md"}, *contents(), {"Changes": "CHANGELOG.md"}, {"Contributing": "CONTRIBUTING.md"}]
    # JSON is YAML, but for this tag: anchors as the documents' links have them.
    text = json.dumps(SETTINGS | {"nav": nav}, indent=1)
    text = text.replace('"permalink": true', '"permalink": true, "slugify": !!python/name:pymdownx.slugs.gfm ""')
    (folder / "mkdocs.yml").write_text(text)


if __name__ == "__main__":
    main(Path(sys.argv[1]))

"""What ended a harness, from its words on stderr; and as a program, that of each input kept by libFuzzer: crash.py HARNESS FILES.

Crashes within libhdf5 are told apart: it is not ours, and reads damaged files of every kind into its own memory first.
"""

import re
import subprocess
import sys

LIBRARY = "in libhdf5"
SECONDS = 60
NOT_GUILTY = ("asan", "ubsan", "sanitizer", "fuzzer", "libc.so", "libstdc++", "operator new", "malloc", "__interceptor", "memcpy")


def describe(text):
    """The error and where it happened, without addresses."""
    error = re.search(r"message without its file.*|ERROR: .*|runtime error.*|what\(\).*", text)
    stack = re.split(r"^ +#0 ", text, flags=re.M)
    frames = re.findall(r"^(?: +#\d+ )?\w+ (?:in )?(.*)", stack[1], re.M) if len(stack) > 1 else []
    frames = [frame for frame in frames if not any(word in frame.lower() for word in NOT_GUILTY)]
    ours = [re.sub(r"\(BuildId.*", "", frame.split("/")[-1]) for frame in frames if "/src/" in frame][:2]
    library = f" {LIBRARY}" if frames and "libhdf5" in frames[0] else ""
    return re.sub(r"0x\w+|==\d+==", "", error[0] if error else text[-300:])[:160] + library + " | " + " < ".join(ours)


def main():
    harness, *files = sys.argv[1:]
    found = {}
    for file in files:
        try:
            done = subprocess.run([harness, "-timeout=10", "-rss_limit_mb=2048", "-malloc_limit_mb=1024", file], capture_output=True,
                                  text=True, errors="replace", timeout=SECONDS)
            what = describe(done.stderr) if done.returncode else "not again"
        except subprocess.TimeoutExpired:
            what = f"more than {SECONDS} s"
        found.setdefault(what, []).append(file)
    for what, same in found.items():
        print(f"{what}\n    {len(same)} inputs, the first {same[0]}")
    return any(LIBRARY not in what and what != "not again" for what in found)


if __name__ == "__main__":
    sys.exit(main())

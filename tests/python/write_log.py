"""Every moment of a file's life: what SIGKILL would leave if it came before, after, or in the middle of any of its writes.

A preloaded library notes each write to results.h5 in order, and what state.h5 holds when it gets its name. What a killed process
has written stays as it is, so playing the notes back shows, one after the other, all the files that a kill could leave. Within a
write the kernel may stop between two pages of memory: so does the playback. What is written when depends on the time, so that goes
on by TICK seconds with every look at it.
"""

import struct
import subprocess

SHIM = r"""
#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

static void note(char kind, int64_t offset, int64_t size, const void *data) {
  static int log = -1;
  if (log < 0) log = open(getenv("WRITE_LOG"), O_WRONLY | O_CREAT | O_APPEND, 0666);
  int64_t head[3] = {kind, offset, size};
  if (syscall(SYS_write, log, head, sizeof head) != sizeof head) abort();
  if (data && syscall(SYS_write, log, data, size) != size) abort();
}

static int ours(int descriptor) {
  char link[64] = "/proc/self/fd/", target[4096];
  char *end = link + strlen(link), digits[16];
  int count = 0;
  do digits[count++] = '0' + descriptor % 10; while (descriptor /= 10);
  while (count) *end++ = digits[--count];
  *end = 0;
  ssize_t length = readlink(link, target, sizeof target - 1);
  if (length < 0) return 0;
  target[length] = 0;
  const char *name = strrchr(target, '/');
  return name && strncmp(name, "/results.h5", 11) == 0;
}

double MPI_Wtime(void) {
  static double time;
  return time += atof(getenv("TICK"));
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t pwrite(int d, const void *data, size_t size, off_t at) {
  if (ours(d)) note('W', at, size, data);
  return REAL(pwrite)(d, data, size, at);
}
ssize_t pwrite64(int d, const void *data, size_t size, off64_t at) {
  if (ours(d)) note('W', at, size, data);
  return REAL(pwrite64)(d, data, size, at);
}
int posix_fallocate(int d, off_t at, off_t size) {
  if (ours(d)) note('G', at, size, NULL);
  return REAL(posix_fallocate)(d, at, size);
}
int ftruncate(int d, off_t size) {
  if (ours(d)) note('T', 0, size, NULL);
  return REAL(ftruncate)(d, size);
}
int rename(const char *from, const char *to) {
  const char *name = strrchr(to, '/');
  if (name && !strcmp(name, "/results.h5")) note('R', 0, 0, NULL);
  if (name && !strcmp(name, "/state.h5")) {
    static char state[1 << 22];
    const int d = open(from, O_RDONLY);
    note('S', 0, read(d, state, sizeof state), state);
    close(d);
  }
  return REAL(rename)(from, to);
}
"""
PAGE = 4096


def shim(folder):
    """Compiles the library; returns its path."""
    (folder / "shim.c").write_text(SHIM)
    subprocess.run(["cc", "-shared", "-fPIC", "-o", folder / "shim.so", folder / "shim.c", "-ldl"], check=True)
    return folder / "shim.so"


def notes(log):
    """(kind, offset, size, data) of every note."""
    data, at = log.read_bytes(), 0
    while at < len(data):
        kind, offset, size = struct.unpack_from("3q", data, at)
        at += 24
        written = data[at:at + size] if chr(kind) in "WS" else b""
        at += len(written)
        yield chr(kind), offset, size, written


def resize(file, kind, offset, size):
    """Plays such a note back, if it is one."""
    if kind == "T":
        file.truncate(size)
    elif kind == "G":
        file.seek(0, 2)
        file.truncate(max(file.tell(), offset + size))


def moments(log, path, tear=True):
    """Plays the notes back into `path`; yields the number of the write that comes next, wherever a kill could leave the file.

    Only from the moment on where the file has its name. With `tear` also between the pages of a write.
    """
    named, count = False, 0
    with open(path, "w+b") as file:
        for kind, offset, size, data in notes(log):
            if kind == "S":
                continue
            if kind == "R":
                named = True
            resize(file, kind, offset, size)
            while data:
                length = PAGE - offset % PAGE if tear else len(data)
                file.seek(offset)
                file.write(data[:length])
                data, offset = data[length:], offset + length
                if data and named:
                    file.flush()
                    yield count
            file.flush()
            count += 1
            if named:
                yield count


def states(log, path):
    """Plays the notes back into `path`; yields what state.h5 holds, whenever it gets its name."""
    with open(path, "w+b") as file:
        for kind, offset, size, data in notes(log):
            if kind == "S":
                file.flush()
                yield data
            resize(file, kind, offset, size)
            if kind == "W":
                file.seek(offset)
                file.write(data)

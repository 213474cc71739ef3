/* Preloaded before dovetail, makes one call fail: on rank FAULT_RANK, the FAULT_AT-th of FAULT_KIND, a kind or the name
   of a function. Appends to FAULT_LOG which call it was, with its callers; where none was to fail, how many of each
   kind there were. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <dmumps_c.h>
#include <errno.h>
#include <execinfo.h>
#include <fcntl.h>
#include <hdf5.h>
#include <mpi.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum Kind { ALLOC, FULL, BAD, SHORT, SYNC, CLOSE, RENAME, OPEN, MKDIR, TRUNCATE, MPI, HDF5, MUMPS, KINDS };
static const char *const names[KINDS] = {"alloc", "full",  "bad",      "short", "sync", "close", "rename",
                                         "open",  "mkdir", "truncate", "mpi",   "hdf5", "mumps"};

/* Bytes. Libraries ask for smaller pieces thousands of times, and a machine that is short refuses large ones. */
enum { LARGE = 4096 };

static atomic_long counts[KINDS], chosen;
static enum Kind kind = KINDS; /* that is to fail, or */
static const char *only = "";  /* this function */
static long wanted;            /* which of them */
static int running;            /* between SlepcInitialize and SlepcFinalize, which are MPI's and PETSc's alone */
static const char *folder, *rank = "0";

static void say(const char *text) {
  const char *log = getenv("FAULT_LOG");
  const int file = log ? syscall(SYS_openat, AT_FDCWD, log, O_WRONLY | O_CREAT | O_APPEND, 0666) : -1;
  if (file < 0) return;
  syscall(SYS_write, file, text, strlen(text));
  if (wanted > 0) {
    void *callers[24];
    backtrace_symbols_fd(callers, backtrace(callers, 24), file);
  }
  syscall(SYS_close, file);
}

__attribute__((constructor)) static void begin(void) {
  void *caller;
  backtrace(&caller, 1); /* loads what it needs while nothing fails */
  folder = getenv("FAULT_FOLDER");
  if (getenv("OMPI_COMM_WORLD_RANK")) rank = getenv("OMPI_COMM_WORLD_RANK");
  const char *name = getenv("FAULT_KIND"), *number = getenv("FAULT_AT"), *which = getenv("FAULT_RANK");
  if (!name || !number || strcmp(rank, which ? which : "0")) return;
  only = name, wanted = atol(number);
  for (int i = 0; i < KINDS; ++i)
    if (!strcmp(name, names[i])) kind = i;
}

__attribute__((destructor)) static void end(void) {
  if (getenv("FAULT_KIND")) return;
  char text[512];
  int used = snprintf(text, sizeof text, "rank %s", rank);
  for (int i = 0; i < KINDS; ++i) used += snprintf(text + used, sizeof text - used, " %s %ld", names[i], counts[i]);
  snprintf(text + used, sizeof text - used, "\n");
  say(text);
}

static int strikes(enum Kind which, const char *name) {
  ++counts[which];
  if (which != kind && strcmp(name, only)) return 0;
  const long now = ++chosen;
  if (now < wanted) return 0;
  if (now > wanted) return which == FULL; /* a full disk stays full */
  char text[128];
  snprintf(text, sizeof text, "rank %s: %s call %ld: %s\n", rank, only, now, name);
  say(text);
  return 1;
}

/* PETSc and SLEPc: when the program proper begins and ends. */
int SlepcInitialize(int *argc, char ***argv, const char file[], const char help[]) {
  int (*real)(int *, char ***, const char[], const char[]) = dlsym(RTLD_NEXT, "SlepcInitialize");
  const int code = real(argc, argv, file, help);
  running = 1;
  return code;
}
int SlepcFinalize(void) {
  int (*real)(void) = dlsym(RTLD_NEXT, "SlepcFinalize");
  running = 0;
  return real();
}

/* Time, which rules when results, states and the status are written: it goes on by a millisecond with every look at it, so
   that a busy machine makes the same calls. */
static atomic_long looks;
double MPI_Wtime(void) { return 1e-3 * ++looks; }
long _ZNSt6chrono3_V212steady_clock3nowEv(void) { return 1000000 * ++looks; } /* C++'s, in nanoseconds */

/* Memory. operator new, and Fortran's ALLOCATE, call malloc. */
void *__libc_malloc(size_t), *__libc_calloc(size_t, size_t), *__libc_realloc(void *, size_t),
    *__libc_memalign(size_t, size_t);

static int refused(size_t size, const char *name) {
  if (!running || size < LARGE || !strikes(ALLOC, name)) return 0;
  errno = ENOMEM;
  return 1;
}
void *malloc(size_t size) { return refused(size, "malloc") ? NULL : __libc_malloc(size); }
void *calloc(size_t n, size_t size) { return refused(n * size, "calloc") ? NULL : __libc_calloc(n, size); }
void *realloc(void *old, size_t size) { return refused(size, "realloc") ? NULL : __libc_realloc(old, size); }
void *memalign(size_t to, size_t size) { return refused(size, "memalign") ? NULL : __libc_memalign(to, size); }
void *aligned_alloc(size_t to, size_t size) { return memalign(to, size); }
int posix_memalign(void **place, size_t to, size_t size) {
  void *found = memalign(to, size);
  if (found) *place = found;
  return found ? 0 : ENOMEM;
}

/* Files: those of the run alone, beneath FAULT_FOLDER. */
#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

static int ours(const char *path) { return folder && path && !strncmp(path, folder, strlen(folder)); }
static int ours_open(int file) {
  char link[64], path[4096] = "";
  snprintf(link, sizeof link, "/proc/self/fd/%d", file);
  return folder && syscall(SYS_readlinkat, AT_FDCWD, link, path, sizeof path - 1) > 0 && ours(path);
}
static int fails(enum Kind which, const char *name, int why) {
  if (!strikes(which, name)) return 0;
  errno = why;
  return 1;
}
static int no_write(int file, const char *name) {
  return ours_open(file) && (fails(FULL, name, ENOSPC) || fails(BAD, name, EIO));
}
/* How much of a write is done: half of one that is to be short. */
static size_t done_of(int file, size_t size, const char *name) {
  return size > 1 && ours_open(file) && strikes(SHORT, name) ? size / 2 : size;
}

#define WRITE(name, declared, passed)                                                                                  \
  ssize_t name declared {                                                                                              \
    if (no_write(file, #name)) return -1;                                                                              \
    size = done_of(file, size, #name);                                                                                 \
    return REAL(name) passed;                                                                                          \
  }
WRITE(write, (int file, const void *data, size_t size), (file, data, size))
WRITE(pwrite, (int file, const void *data, size_t size, off_t to), (file, data, size, to))
WRITE(pwrite64, (int file, const void *data, size_t size, off64_t to), (file, data, size, to))

#define WRITE_PARTS(name, declared, passed)                                                                            \
  ssize_t name declared {                                                                                              \
    if (no_write(file, #name)) return -1;                                                                              \
    n = n > 1 ? (int)done_of(file, n, #name) : n;                                                                      \
    return REAL(name) passed;                                                                                          \
  }
WRITE_PARTS(writev, (int file, const struct iovec *parts, int n), (file, parts, n))
WRITE_PARTS(pwritev, (int file, const struct iovec *parts, int n, off_t to), (file, parts, n, to))
WRITE_PARTS(pwritev64, (int file, const struct iovec *parts, int n, off64_t to), (file, parts, n, to))

#define RESERVE(name, type)                                                                                            \
  int name(int file, type from, type size) { return no_write(file, #name) ? errno : REAL(name)(file, from, size); }
RESERVE(posix_fallocate, off_t)
RESERVE(posix_fallocate64, off64_t)

#define GUARD(name, declared, passed, condition, which, why)                                                           \
  int name declared { return (condition) && fails(which, #name, why) ? -1 : REAL(name) passed; }
GUARD(fsync, (int file), (file), ours_open(file), SYNC, EIO)
GUARD(fdatasync, (int file), (file), ours_open(file), SYNC, EIO)
GUARD(ftruncate, (int file, off_t size), (file, size), ours_open(file), TRUNCATE, ENOSPC)
GUARD(ftruncate64, (int file, off64_t size), (file, size), ours_open(file), TRUNCATE, ENOSPC)
GUARD(rename, (const char *from, const char *to), (from, to), ours(to), RENAME, EIO)
GUARD(renameat, (int a, const char *from, int b, const char *to), (a, from, b, to), ours(to), RENAME, EIO)
GUARD(unlink, (const char *path), (path), ours(path), RENAME, EIO)
GUARD(remove, (const char *path), (path), ours(path), RENAME, EIO)
GUARD(mkdir, (const char *path, mode_t mode), (path, mode), ours(path), MKDIR, ENOSPC)

int close(int file) { /* Linux closes it, whatever it says */
  const int mine = (fcntl(file, F_GETFL) & O_ACCMODE) != O_RDONLY && ours_open(file);
  const int code = REAL(close)(file);
  return mine && fails(CLOSE, "close", EIO) ? -1 : code;
}

#define OPENS(name, first, passed)                                                                                     \
  int name first {                                                                                                     \
    va_list more;                                                                                                      \
    va_start(more, flags);                                                                                             \
    const mode_t mode = flags & O_CREAT ? va_arg(more, mode_t) : 0;                                                    \
    va_end(more);                                                                                                      \
    const int writes = (flags & O_ACCMODE) != O_RDONLY;                                                                \
    return writes && ours(path) && fails(OPEN, #name, EACCES) ? -1 : REAL(name) passed;                                \
  }
OPENS(open, (const char *path, int flags, ...), (path, flags, mode))
OPENS(open64, (const char *path, int flags, ...), (path, flags, mode))
OPENS(openat, (int at_folder, const char *path, int flags, ...), (at_folder, path, flags, mode))

#define OPENS_STREAM(name)                                                                                             \
  FILE *name(const char *path, const char *mode) {                                                                     \
    return strpbrk(mode, "wa+") && ours(path) && fails(OPEN, #name, EACCES) ? NULL : REAL(name)(path, mode);           \
  }
OPENS_STREAM(fopen)
OPENS_STREAM(fopen64)

/* MPI: an error goes to the communicator's handler, as MPI's own would. Calls of PETSc, SLEPc, HDF5, ScaLAPACK, and
 * MUMPS. */
static int broken(MPI_Comm comm) {
  PMPI_Comm_call_errhandler(comm, MPI_ERR_OTHER);
  return MPI_ERR_OTHER;
}
#define ON(comm, name, declared, passed)                                                                               \
  int MPI_##name declared { return running && strikes(MPI, "MPI_" #name) ? broken(comm) : PMPI_##name passed; }
#define T MPI_Datatype
ON(comm, Allreduce, (const void *s, void *r, int n, T t, MPI_Op op, MPI_Comm comm), (s, r, n, t, op, comm))
ON(comm, Reduce, (const void *s, void *r, int n, T t, MPI_Op op, int to, MPI_Comm comm), (s, r, n, t, op, to, comm))
ON(comm, Scan, (const void *s, void *r, int n, T t, MPI_Op op, MPI_Comm comm), (s, r, n, t, op, comm))
ON(comm, Exscan, (const void *s, void *r, int n, T t, MPI_Op op, MPI_Comm comm), (s, r, n, t, op, comm))
ON(comm, Reduce_scatter, (const void *s, void *r, const int n[], T t, MPI_Op op, MPI_Comm comm), (s, r, n, t, op, comm))
ON(comm, Bcast, (void *b, int n, T t, int from, MPI_Comm comm), (b, n, t, from, comm))
ON(comm, Barrier, (MPI_Comm comm), (comm))
ON(comm, Ibarrier, (MPI_Comm comm, MPI_Request *q), (comm, q))
ON(comm, Iallreduce, (const void *s, void *r, int n, T t, MPI_Op op, MPI_Comm comm, MPI_Request *q),
   (s, r, n, t, op, comm, q))
ON(comm, Gather, (const void *s, int n, T t, void *r, int m, T u, int to, MPI_Comm comm), (s, n, t, r, m, u, to, comm))
ON(comm, Gatherv, (const void *s, int n, T t, void *r, const int m[], const int d[], T u, int to, MPI_Comm comm),
   (s, n, t, r, m, d, u, to, comm))
ON(comm, Scatterv, (const void *s, const int n[], const int d[], T t, void *r, int m, T u, int from, MPI_Comm comm),
   (s, n, d, t, r, m, u, from, comm))
ON(comm, Allgather, (const void *s, int n, T t, void *r, int m, T u, MPI_Comm comm), (s, n, t, r, m, u, comm))
ON(comm, Allgatherv, (const void *s, int n, T t, void *r, const int m[], const int d[], T u, MPI_Comm comm),
   (s, n, t, r, m, d, u, comm))
ON(comm, Alltoall, (const void *s, int n, T t, void *r, int m, T u, MPI_Comm comm), (s, n, t, r, m, u, comm))
ON(comm, Alltoallv,
   (const void *s, const int n[], const int d[], T t, void *r, const int m[], const int e[], T u, MPI_Comm comm),
   (s, n, d, t, r, m, e, u, comm))
ON(comm, Send, (const void *b, int n, T t, int to, int tag, MPI_Comm comm), (b, n, t, to, tag, comm))
ON(comm, Isend, (const void *b, int n, T t, int to, int tag, MPI_Comm comm, MPI_Request *q),
   (b, n, t, to, tag, comm, q))
ON(comm, Recv, (void *b, int n, T t, int from, int tag, MPI_Comm comm, MPI_Status *s), (b, n, t, from, tag, comm, s))
ON(comm, Irecv, (void *b, int n, T t, int from, int tag, MPI_Comm comm, MPI_Request *q), (b, n, t, from, tag, comm, q))
ON(comm, Send_init, (const void *b, int n, T t, int to, int tag, MPI_Comm comm, MPI_Request *q),
   (b, n, t, to, tag, comm, q))
ON(comm, Recv_init, (void *b, int n, T t, int from, int tag, MPI_Comm comm, MPI_Request *q),
   (b, n, t, from, tag, comm, q))
ON(MPI_COMM_WORLD, Startall, (int n, MPI_Request q[]), (n, q))
ON(MPI_COMM_WORLD, Test, (MPI_Request * q, int *flag, MPI_Status *s), (q, flag, s))
ON(MPI_COMM_WORLD, Wait, (MPI_Request * q, MPI_Status *s), (q, s))
ON(MPI_COMM_WORLD, Waitall, (int n, MPI_Request q[], MPI_Status s[]), (n, q, s))
ON(MPI_COMM_WORLD, Waitany, (int n, MPI_Request q[], int *i, MPI_Status *s), (n, q, i, s))
ON(comm, Iprobe, (int from, int tag, MPI_Comm comm, int *flag, MPI_Status *s), (from, tag, comm, flag, s))
ON(comm, Comm_dup, (MPI_Comm comm, MPI_Comm *to), (comm, to))
ON(comm, Comm_split, (MPI_Comm comm, int color, int key, MPI_Comm *to), (comm, color, key, to))
ON(comm, Comm_split_type, (MPI_Comm comm, int type, int key, MPI_Info info, MPI_Comm *to), (comm, type, key, info, to))
ON(MPI_COMM_WORLD, Comm_free, (MPI_Comm * comm), (comm))
ON(MPI_COMM_WORLD, Type_commit, (T * t), (t))

#define ON_FILE(file, name, declared, passed)                                                                          \
  int MPI_##name declared {                                                                                            \
    if (!running || !strikes(MPI, "MPI_" #name)) return PMPI_##name passed;                                            \
    PMPI_File_call_errhandler(file, MPI_ERR_IO);                                                                       \
    return MPI_ERR_IO;                                                                                                 \
  }
ON_FILE(MPI_FILE_NULL, File_open, (MPI_Comm comm, const char *path, int mode, MPI_Info info, MPI_File *f),
        (comm, path, mode, info, f))
ON_FILE(*f, File_close, (MPI_File * f), (f))
ON_FILE(f, File_set_size, (MPI_File f, MPI_Offset size), (f, size))
ON_FILE(f, File_sync, (MPI_File f), (f))
ON_FILE(f, File_set_view, (MPI_File f, MPI_Offset to, T t, T u, const char *how, MPI_Info info),
        (f, to, t, u, how, info))
ON_FILE(f, File_write_at, (MPI_File f, MPI_Offset to, const void *b, int n, T t, MPI_Status *s), (f, to, b, n, t, s))
ON_FILE(f, File_write_at_all, (MPI_File f, MPI_Offset to, const void *b, int n, T t, MPI_Status *s),
        (f, to, b, n, t, s))
ON_FILE(f, File_read_at, (MPI_File f, MPI_Offset to, void *b, int n, T t, MPI_Status *s), (f, to, b, n, t, s))

/* MPI from Fortran, which MUMPS calls: arguments are references, the last one takes the error. */
#define FORTRAN(name, comm, declared, passed)                                                                          \
  void mpi_##name##_ declared {                                                                                        \
    if (running && strikes(MPI, "mpi_" #name "_"))                                                                     \
      *error = broken(comm);                                                                                           \
    else                                                                                                               \
      ((void(*) declared)dlsym(RTLD_NEXT, "mpi_" #name "_")) passed;                                                   \
  }
#define OF PMPI_Comm_f2c(*comm)
FORTRAN(allreduce, OF, (void *s, void *r, int *n, int *t, int *op, int *comm, int *error),
        (s, r, n, t, op, comm, error))
FORTRAN(reduce, OF, (void *s, void *r, int *n, int *t, int *op, int *to, int *comm, int *error),
        (s, r, n, t, op, to, comm, error))
FORTRAN(bcast, OF, (void *b, int *n, int *t, int *from, int *comm, int *error), (b, n, t, from, comm, error))
FORTRAN(barrier, OF, (int *comm, int *error), (comm, error))
FORTRAN(send, OF, (void *b, int *n, int *t, int *to, int *tag, int *comm, int *error), (b, n, t, to, tag, comm, error))
FORTRAN(isend, OF, (void *b, int *n, int *t, int *to, int *tag, int *comm, int *q, int *error),
        (b, n, t, to, tag, comm, q, error))
FORTRAN(recv, OF, (void *b, int *n, int *t, int *from, int *tag, int *comm, int *s, int *error),
        (b, n, t, from, tag, comm, s, error))
FORTRAN(irecv, OF, (void *b, int *n, int *t, int *from, int *tag, int *comm, int *q, int *error),
        (b, n, t, from, tag, comm, q, error))
FORTRAN(iprobe, OF, (int *from, int *tag, int *comm, int *flag, int *s, int *error), (from, tag, comm, flag, s, error))
FORTRAN(test, MPI_COMM_WORLD, (int *q, int *flag, int *s, int *error), (q, flag, s, error))
FORTRAN(wait, MPI_COMM_WORLD, (int *q, int *s, int *error), (q, s, error))

/* HDF5: every call that dovetail makes and that may fail. */
#define H5(type, name, declared, passed)                                                                               \
  type name declared { return strikes(HDF5, #name) ? -1 : REAL(name) passed; }
#define CLOSES(name) H5(herr_t, name, (hid_t id), (id))
CLOSES(H5Aclose)
CLOSES(H5Dclose)
CLOSES(H5Fclose)
CLOSES(H5Gclose)
CLOSES(H5Pclose)
CLOSES(H5Sclose)
CLOSES(H5Tclose)
H5(hid_t, H5Acreate2, (hid_t at, const char *name, hid_t t, hid_t s, hid_t c, hid_t a), (at, name, t, s, c, a))
H5(hid_t, H5Acreate_by_name, (hid_t at, const char *of, const char *name, hid_t t, hid_t s, hid_t c, hid_t a, hid_t l),
   (at, of, name, t, s, c, a, l))
H5(htri_t, H5Aexists, (hid_t at, const char *name), (at, name))
H5(htri_t, H5Aexists_by_name, (hid_t at, const char *of, const char *name, hid_t l), (at, of, name, l))
H5(hid_t, H5Aget_space, (hid_t id), (id))
H5(hid_t, H5Aget_type, (hid_t id), (id))
H5(hid_t, H5Aopen, (hid_t at, const char *name, hid_t a), (at, name, a))
H5(hid_t, H5Aopen_by_name, (hid_t at, const char *of, const char *name, hid_t a, hid_t l), (at, of, name, a, l))
H5(herr_t, H5Aread, (hid_t id, hid_t t, void *b), (id, t, b))
H5(herr_t, H5Awrite, (hid_t id, hid_t t, const void *b), (id, t, b))
H5(hid_t, H5Dcreate2, (hid_t at, const char *name, hid_t t, hid_t s, hid_t l, hid_t c, hid_t a),
   (at, name, t, s, l, c, a))
H5(hid_t, H5Dget_create_plist, (hid_t id), (id))
H5(hid_t, H5Dget_space, (hid_t id), (id))
H5(hid_t, H5Dget_type, (hid_t id), (id))
H5(hid_t, H5Dopen2, (hid_t at, const char *name, hid_t a), (at, name, a))
H5(herr_t, H5Dread, (hid_t id, hid_t t, hid_t m, hid_t s, hid_t p, void *b), (id, t, m, s, p, b))
H5(herr_t, H5Dset_extent, (hid_t id, const hsize_t n[]), (id, n))
H5(herr_t, H5Dwrite, (hid_t id, hid_t t, hid_t m, hid_t s, hid_t p, const void *b), (id, t, m, s, p, b))
H5(hid_t, H5Fcreate, (const char *path, unsigned flags, hid_t c, hid_t a), (path, flags, c, a))
H5(herr_t, H5Fflush, (hid_t id, H5F_scope_t scope), (id, scope))
H5(herr_t, H5Fget_filesize, (hid_t id, hsize_t *n), (id, n))
H5(htri_t, H5Fis_hdf5, (const char *path), (path))
H5(hid_t, H5Fopen, (const char *path, unsigned flags, hid_t a), (path, flags, a))
H5(hid_t, H5Gopen2, (hid_t at, const char *name, hid_t a), (at, name, a))
H5(hid_t, H5Iget_file_id, (hid_t id), (id))
H5(htri_t, H5Lexists, (hid_t at, const char *name, hid_t l), (at, name, l))
H5(hid_t, H5Pcreate, (hid_t of), (of))
H5(herr_t, H5Pset_chunk, (hid_t id, int n, const hsize_t size[]), (id, n, size))
H5(herr_t, H5Pset_chunk_cache, (hid_t id, size_t n, size_t bytes, double w), (id, n, bytes, w))
H5(herr_t, H5Pset_create_intermediate_group, (hid_t id, unsigned on), (id, on))
H5(herr_t, H5Pset_driver, (hid_t id, hid_t driver, const void *more), (id, driver, more))
H5(herr_t, H5Pset_dxpl_mpio, (hid_t id, H5FD_mpio_xfer_t how), (id, how))
H5(herr_t, H5Pset_fapl_mpio, (hid_t id, MPI_Comm comm, MPI_Info info), (id, comm, info))
H5(herr_t, H5Pset_file_locking, (hid_t id, hbool_t on, hbool_t anyway), (id, on, anyway))
H5(herr_t, H5Pset_libver_bounds, (hid_t id, H5F_libver_t low, H5F_libver_t high), (id, low, high))
H5(hid_t, H5Screate, (H5S_class_t of), (of))
H5(hid_t, H5Screate_simple, (int n, const hsize_t size[], const hsize_t most[]), (n, size, most))
H5(int, H5Sget_simple_extent_dims, (hid_t id, hsize_t size[], hsize_t most[]), (id, size, most))
H5(int, H5Sget_simple_extent_ndims, (hid_t id), (id))
H5(hssize_t, H5Sget_simple_extent_npoints, (hid_t id), (id))
H5(herr_t, H5Sselect_hyperslab,
   (hid_t id, H5S_seloper_t op, const hsize_t s[], const hsize_t d[], const hsize_t n[], const hsize_t b[]),
   (id, op, s, d, n, b))
H5(herr_t, H5Sselect_none, (hid_t id), (id))
H5(hid_t, H5Tcopy, (hid_t id), (id))
H5(herr_t, H5Tset_cset, (hid_t id, H5T_cset_t set), (id, set))
H5(herr_t, H5Tset_size, (hid_t id, size_t size), (id, size))
H5(hid_t, H5FDregister, (const H5FD_class_t *driver), (driver))

/* MUMPS: the call is made, and then says that it failed; on all ranks, as MUMPS itself would. */
void dmumps_c(DMUMPS_STRUC_C *id) {
  enum { ANALYSE = 1, ALL = 6, NO_MEMORY = -13, NO_ROOM = -9, ANOTHER_RANK = -1 };
  const int job = id->job;
  REAL(dmumps_c)(id);
  if (job < ANALYSE || job > ALL) return;
  int own = strikes(MUMPS, "dmumps_c"), any = own;
  PMPI_Allreduce(&own, &any, 1, MPI_INT, MPI_LOR, PMPI_Comm_f2c(id->comm_fortran));
  if (!any) return;
  id->infog[0] = job == 2 && counts[MUMPS] % 2 ? NO_ROOM : NO_MEMORY, id->infog[1] = 1000;
  id->info[0] = own ? id->infog[0] : ANOTHER_RANK, id->info[1] = 1000;
}

#include "support/ordered_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <limits>
#include <map>
#include <memory>
#include <vector>

namespace dovetail::h5 {
namespace {

constexpr haddr_t page = 4096;
constexpr haddr_t ahead = 1 << 20; // space a file is given beyond its need, at least
constexpr haddr_t largest = std::numeric_limits<off_t>::max();

struct Piece {
  H5FD_mem_t type;
  std::vector<unsigned char> bytes;
};

struct State {
  int descriptor = -1;
  haddr_t allocated = 0;           // the file's size as HDF5 sees it
  haddr_t size = 0;                // on disk
  haddr_t known = 0;               // what may be pointed to from within the file: allocated at the last flush
  std::map<haddr_t, Piece> pieces; // written by HDF5, not yet in the file; they do not overlap
  ~State() { close(descriptor); }
};

struct File {
  H5FD_t head; // HDF5's own part comes first
  State *state;
};

State &of(H5FD_t *file) { return *reinterpret_cast<File *>(file)->state; }
const State &of(const H5FD_t *file) { return *reinterpret_cast<const File *>(file)->state; }

// Nodes of the trees that index chunks (version 1): "TREE", kind, level.
int level_of(const Piece &piece) {
  const bool node = piece.bytes.size() > 5 && std::memcmp(piece.bytes.data(), "TREE", 4) == 0;
  return node ? piece.bytes[5] : 0;
}

int turn_of(haddr_t begin, const Piece &piece, haddr_t known) {
  if (begin >= known) return 0;
  switch (piece.type) {
  case H5FD_MEM_DRAW:
    return 1;
  case H5FD_MEM_SUPER:
    return 2;
  case H5FD_MEM_OHDR:
    return 1000;
  default:
    return 300 - level_of(piece);
  }
}

bool write_whole(int descriptor, haddr_t begin, const std::vector<unsigned char> &bytes) {
  for (std::size_t done = 0; done < bytes.size();) {
    const ssize_t now = pwrite(descriptor, bytes.data() + done, bytes.size() - done, static_cast<off_t>(begin + done));
    if (now < 0 && errno != EINTR) return false;
    if (now > 0) done += static_cast<std::size_t>(now);
  }
  return true;
}

bool reach(State &state, haddr_t size) {
  int error;
  do error = posix_fallocate(state.descriptor, static_cast<off_t>(state.size), static_cast<off_t>(size - state.size));
  while (error == EINTR);
  if (error != 0) return false;
  state.size = size;
  return true;
}

bool commit(State &state) {
  const haddr_t needed = state.allocated;
  if (needed > state.size && !reach(state, needed + std::max(ahead, needed / 4)) && !reach(state, needed)) return false;
  std::multimap<int, const std::pair<const haddr_t, Piece> *> turns; // equals stay in the order of their places
  for (const auto &entry : state.pieces) turns.emplace(turn_of(entry.first, entry.second, state.known), &entry);
  for (auto next = turns.begin(); next != turns.end();) { // neighbours of one turn together
    const auto first = next;
    std::vector<unsigned char> bytes;
    do {
      const std::vector<unsigned char> &more = next->second->second.bytes;
      bytes.insert(bytes.end(), more.begin(), more.end());
    } while (++next != turns.end() && next->first == first->first &&
             next->second->first == first->second->first + bytes.size());
    if (!write_whole(state.descriptor, first->second->first, bytes)) return false;
  }
  state.pieces.clear();
  state.known = state.allocated;
  return true;
}

// Takes bytes in: they replace what the pieces held of the same places.
void keep(State &state, H5FD_mem_t type, haddr_t begin, const unsigned char *bytes, std::size_t size) {
  const haddr_t end = begin + size;
  std::map<haddr_t, Piece> fresh; // the stretches that lie in no piece yet
  const auto add = [&](haddr_t from, haddr_t to) {
    if (from < to) fresh.emplace(from, Piece{type, {bytes + (from - begin), bytes + (to - begin)}});
  };
  haddr_t done = begin;
  for (auto &[old, piece] : state.pieces) {
    const haddr_t from = std::max(old, begin), to = std::min<haddr_t>(old + piece.bytes.size(), end);
    if (from >= to) continue;
    std::copy(bytes + (from - begin), bytes + (to - begin), piece.bytes.begin() + (from - old));
    add(done, from);
    done = to;
  }
  add(done, end);
  state.pieces.merge(fresh);
}

H5FD_t *open_file(const char *name, unsigned flags, hid_t, haddr_t) {
  int mode = flags & H5F_ACC_RDWR ? O_RDWR : O_RDONLY;
  if (flags & H5F_ACC_CREAT) mode |= O_CREAT;
  if (flags & H5F_ACC_TRUNC) mode |= O_TRUNC;
  if (flags & H5F_ACC_EXCL) mode |= O_EXCL;
  const int descriptor = open(name, mode | O_CLOEXEC, 0666);
  if (descriptor < 0) return nullptr;
  auto state = std::make_unique<State>();
  state->descriptor = descriptor;
  struct stat now {};
  if (fstat(descriptor, &now) != 0) return nullptr;
  state->size = static_cast<haddr_t>(now.st_size);
  auto file = std::make_unique<File>();
  file->state = state.release();
  return &file.release()->head;
}

herr_t close_file(H5FD_t *file) {
  const State &state = of(file);
  const bool good = commit(of(file));
  [[maybe_unused]] const int spare = good ? ftruncate(state.descriptor, static_cast<off_t>(state.allocated)) : 0;
  delete reinterpret_cast<File *>(file)->state;
  delete reinterpret_cast<File *>(file);
  return good ? 0 : -1;
}

herr_t query(const H5FD_t *, unsigned long *flags) {
  if (flags) *flags = 0; // no gathering of small parts into blocks: each passes through here
  return 0;
}

haddr_t allocate(H5FD_t *file, H5FD_mem_t type, hid_t, hsize_t size) {
  State &state = of(file);
  haddr_t begin = state.allocated;
  const bool crosses = begin / page != (begin + size - 1) / page;
  if (type != H5FD_MEM_DRAW && size <= page && crosses) begin = (begin / page + 1) * page;
  state.allocated = begin + size;
  return begin;
}

haddr_t get_allocated(const H5FD_t *file, H5FD_mem_t) { return of(file).allocated; }

herr_t set_allocated(H5FD_t *file, H5FD_mem_t, haddr_t end) {
  of(file).allocated = end;
  return 0;
}

haddr_t get_size(const H5FD_t *file, H5FD_mem_t) { return of(file).size; }

herr_t read(H5FD_t *file, H5FD_mem_t, hid_t, haddr_t begin, std::size_t size, void *buffer) {
  const State &state = of(file);
  auto *bytes = static_cast<unsigned char *>(buffer);
  std::memset(bytes, 0, size); // beyond the end of the file
  for (std::size_t done = 0; done < size;) {
    const ssize_t now = pread(state.descriptor, bytes + done, size - done, static_cast<off_t>(begin + done));
    if (now < 0 && errno != EINTR) return -1;
    if (now == 0) break;
    if (now > 0) done += static_cast<std::size_t>(now);
  }
  for (const auto &[place, piece] : state.pieces) {
    const haddr_t from = std::max(begin, place), to = std::min<haddr_t>(begin + size, place + piece.bytes.size());
    if (from < to) std::memcpy(bytes + (from - begin), piece.bytes.data() + (from - place), to - from);
  }
  return 0;
}

herr_t write(H5FD_t *file, H5FD_mem_t type, hid_t, haddr_t begin, std::size_t size, const void *buffer) {
  keep(of(file), type, begin, static_cast<const unsigned char *>(buffer), size);
  return 0;
}

herr_t flush(H5FD_t *file, hid_t, hbool_t) { return commit(of(file)) ? 0 : -1; }

hid_t driver() {
  static const hid_t id = [] {
    static H5FD_class_t methods{}; // HDF5 keeps a copy
#if H5_VERSION_GE(1, 14, 0)
    methods.version = H5FD_CLASS_VERSION;
    methods.value = H5_VFD_MAX; // beyond those that are registered with the HDF Group
#endif
    methods.name = "ordered";
    methods.maxaddr = largest;
    methods.fc_degree = H5F_CLOSE_WEAK;
    methods.open = open_file;
    methods.close = close_file;
    methods.query = query;
    methods.alloc = allocate;
    methods.get_eoa = get_allocated;
    methods.set_eoa = set_allocated;
    methods.get_eof = get_size;
    methods.read = read;
    methods.write = write;
    methods.flush = flush;
    for (H5FD_mem_t &type : methods.fl_map) type = H5FD_MEM_DEFAULT; // no lists of freed parts by kind
    return H5FDregister(&methods);
  }();
  return id;
}

} // namespace

bool use_ordered_driver(hid_t access) { return H5Pset_driver(access, driver(), nullptr) >= 0; }

} // namespace dovetail::h5

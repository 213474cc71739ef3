#include "stuck/slab.hpp"

#include <sys/mman.h>

#include <cstdint>
#include <new>

namespace dovetail {

void *allocate_lines(std::size_t bytes) {
  constexpr std::size_t line = 64;
  const std::size_t size = std::max(line, (bytes + line - 1) / line * line);
  void *const values = std::aligned_alloc(line, size);
  if (!values) throw std::bad_alloc();
#ifdef MADV_HUGEPAGE // rows side by side lie in so many small pages that finding these costs more than their numbers
  constexpr std::uintptr_t page = 4096, large = 2 << 20;
  const auto begin = (reinterpret_cast<std::uintptr_t>(values) + page - 1) / page * page,
             end = (reinterpret_cast<std::uintptr_t>(values) + size) / page * page;
  if (end >= begin + large) madvise(reinterpret_cast<void *>(begin), end - begin, MADV_HUGEPAGE); // a wish
#endif
  return values;
}

} // namespace dovetail

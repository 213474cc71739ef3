#include "support/blas_buffer.hpp"

#include <petscsys.h>
// after the types that it wants
#include <petscblaslapack.h>
#include <sys/mman.h>

#include <new>

namespace dovetail {

void take_blas_buffer() {
  constexpr std::size_t buffer = 160 << 20; // OpenBLAS takes 128 MiB of addresses, most of them never touched
  void *trial = mmap(nullptr, buffer, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (trial == MAP_FAILED) throw std::bad_alloc();
  munmap(trial, buffer);
  constexpr PetscBLASInt n = 16;
  double a[n * n] = {}, x[n * n] = {}, one = 1, none = 0;
  double product[n * n];
  BLASgemm_("N", "N", &n, &n, &n, &one, a, &n, x, &n, &none, product, &n);
}

} // namespace dovetail

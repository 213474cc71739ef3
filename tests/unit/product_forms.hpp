#pragma once
// The products of a slab with the vectors of each generation of processors, those that run here. The program takes the
// last of them.
#include <vector>

#include "modal/slab_kernels.hpp"

namespace dovetail {

struct ProductForm {
  const char *name;
  void (*multiply)(const SlabRows<float> &, const float *b, int strands, float *out);
  void (*add_transposed)(const SlabRows<float> &, const float *f, int strands, float *out);
  void (*multiply_double)(const SlabRows<double> &, const double *b, int strands, double *out);
};

#define DOVETAIL_FORM(NAME, WIDTH, ...)                                                                                \
  __VA_ARGS__ inline void multiply_##NAME(const SlabRows<float> &rows, const float *b, int strands, float *out) {      \
    times_parts<WIDTH>(rows, b, strands, out);                                                                         \
  }                                                                                                                    \
  __VA_ARGS__ inline void turn_##NAME(const SlabRows<float> &rows, const float *f, int strands, float *out) {          \
    turned_parts<WIDTH>(rows, f, strands, out);                                                                        \
  }                                                                                                                    \
  __VA_ARGS__ inline void multiply_double_##NAME(const SlabRows<double> &rows, const double *b, int strands,           \
                                                 double *out) {                                                        \
    times_parts<WIDTH>(rows, b, strands, out);                                                                         \
  }

DOVETAIL_FORM(portable, 2)
#if defined(__x86_64__) && defined(__OPTIMIZE__) && !defined(__SANITIZE_ADDRESS__) // else nothing is inlined
DOVETAIL_FORM(avx2, 4, __attribute__((target("fma"), flatten)))
DOVETAIL_FORM(avx512, 8, __attribute__((target("avx512f"), flatten)))
#define DOVETAIL_X86_FORMS
#endif

inline std::vector<ProductForm> product_forms() {
  std::vector<ProductForm> forms{{"portable", multiply_portable, turn_portable, multiply_double_portable}};
#ifdef DOVETAIL_X86_FORMS
  if (__builtin_cpu_supports("fma")) forms.push_back({"AVX2", multiply_avx2, turn_avx2, multiply_double_avx2});
  if (__builtin_cpu_supports("avx512f"))
    forms.push_back({"AVX-512", multiply_avx512, turn_avx512, multiply_double_avx512});
#endif
  return forms;
}

} // namespace dovetail

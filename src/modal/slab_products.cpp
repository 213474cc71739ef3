#include "modal/slab_products.hpp"

#include "modal/slab_kernels.hpp"

namespace dovetail {
namespace {

#define DOVETAIL_PRODUCT(NAME, REAL)                                                                                   \
  DOVETAIL_WIDE_PARTS(NAME, (const SlabRows<REAL> &rows, const REAL *from, int strands, REAL *out),                    \
                      (rows, from, strands, out))
DOVETAIL_PRODUCT(times, double)
DOVETAIL_PRODUCT(times, float)
DOVETAIL_PRODUCT(turned, float)

} // namespace

void multiply(const Slab<double> &slab, std::size_t first, std::size_t count, const double *b, int strands,
              double *out) {
  times(rows_of(slab, first, count), b, strands, out);
}
void multiply(const Slab<float> &slab, std::size_t first, std::size_t count, const float *b, int strands, float *out) {
  times(rows_of(slab, first, count), b, strands, out);
}

void add_transposed(const Slab<float> &slab, std::size_t first, std::size_t count, const float *f, int strands,
                    float *out) {
  turned(rows_of(slab, first, count), f, strands, out);
}

} // namespace dovetail

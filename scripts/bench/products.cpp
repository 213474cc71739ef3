// Products of a slab with few columns by one instruction set, beside sgemm, in turn on one thread. Prints JSON; started
// by products.py: FORM SIZE RUNS WIDTH...
#include <ctime>

#include <cstdio>
#include <functional>
#include <string>
#include <vector>

#include "../../tests/unit/product_forms.hpp"

extern "C" void sgemm_(const char *, const char *, const int *, const int *, const int *, const float *, const float *,
                       const int *, const float *, const int *, const float *, float *, const int *);

using namespace dovetail;

namespace {

constexpr std::size_t at_once = 24; // rows, as in ModalOperator

double cpu_seconds() { // of this thread
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

void multiply(const char *ta, const char *tb, int m, int n, int k, const float *A, int lda, const float *B, int ldb,
              float beta, float *C, int ldc) {
  const float one = 1;
  sgemm_(ta, tb, &m, &n, &k, &one, A, &lda, B, &ldb, &beta, C, &ldc);
}

struct Work {
  const char *name;
  double operations;
  std::function<void()> run;
};

void measure(const ProductForm &form, std::size_t size, int runs, int width) {
  constexpr int square = 1000; // large enough: sgemm is within 3 % of its speed at 3000
  Slab<float> slab(size, size);
  for (std::size_t i = 0; i < size; ++i) std::fill_n(slab.row(i), size, 1.0f / static_cast<float>(i + 1));
  const int n = static_cast<int>(size), stride = static_cast<int>(slab.stride());
  Aligned<float> b(width * slab.stride()), out(size * width), turned(width * slab.stride());
  for (int c = 0; c < width; ++c) std::fill_n(&b[c * slab.stride()], size, 1.0f);
  std::vector<float> A(square * square, 1.0f), B(A), C(A);
  const auto each = [&](bool cached, const auto &work) {
    for (std::size_t i = 0; i < size; i += at_once)
      work(rows_of(slab, cached ? 0 : i, std::min(at_once, size - i)), &out[i * width]);
  };
  const auto times = [&](const SlabRows<float> &rows, float *to) { form.multiply(rows, b.data(), width, to); };
  const auto turns = [&](const SlabRows<float> &rows, float *to) {
    form.add_transposed(rows, to, width, turned.data());
  };
  const double one = 2.0 * size * size * width;
  const Work works[] = {
      {"both", 2 * one, [&] { each(false, [&](const auto &rows, float *to) { times(rows, to), turns(rows, to); }); }},
      {"product", one, [&] { each(true, times); }},
      {"transpose", one, [&] { each(true, turns); }},
      {"sgemm", 2 * one,
       [&] {
         multiply("T", "N", width, n, n, b.data(), stride, slab.row(0), stride, 0, out.data(), width);
         multiply("N", "T", n, width, n, slab.row(0), stride, out.data(), width, 0, turned.data(), stride);
       }},
      {"square", 2.0 * square * square * square,
       [&] { multiply("N", "N", square, square, square, A.data(), square, B.data(), square, 0, C.data(), square); }}};
  constexpr std::size_t count = sizeof works / sizeof *works;
  std::vector<double> seconds[count];
  for (int r = -1; r < runs; ++r) // the first is not counted
    for (std::size_t w = 0; w < count; ++w) {
      turned.clear(); // sums stay small
      const double start = cpu_seconds();
      works[w].run();
      if (r >= 0) seconds[w].push_back(cpu_seconds() - start);
    }
  std::printf("{\"form\": \"%s\", \"width\": %d", form.name, width);
  for (std::size_t w = 0; w < count; ++w) {
    std::sort(seconds[w].begin(), seconds[w].end());
    std::printf(", \"%s\": %.4g", works[w].name, 1e-9 * works[w].operations / seconds[w][seconds[w].size() / 2]);
  }
  std::printf("}");
}

} // namespace

int main(int argc, char **argv) {
  if (argc < 5) return 2;
  const char *separator = "[";
  for (const ProductForm &form : product_forms())
    if (std::string(form.name) == argv[1])
      for (int i = 4; i < argc; ++i) {
        std::printf("%s", separator), separator = ", ";
        measure(form, std::stoul(argv[2]), std::stoi(argv[3]), std::stoi(argv[i]));
      }
  std::printf("%s]\n", *separator == '[' ? "[" : "");
}

#include "support/blas_kernel.hpp"

#include <dlfcn.h>
#include <strings.h>
#include <sys/auxv.h>
#include <unistd.h>

#include <cstdint>
#include <cstdlib>
#include <functional>
#include <utility>

namespace dovetail {
namespace {

constexpr const char *choice = "OPENBLAS_CORETYPE";
constexpr const char *mark = "DOVETAIL_REPLACED_KERNEL"; // set from one start of the program to the next only

std::string from_environment(const char *name) {
  const char *value = std::getenv(name);
  return value ? value : "";
}

bool same(const std::string &a, const std::string &b) { return strcasecmp(a.c_str(), b.c_str()) == 0; }

// What a function of OpenBLAS without arguments says. Other libraries have none of this name.
std::string answer(const char *function) {
  using Function = char *(*)();
  const auto ask = reinterpret_cast<Function>(dlsym(RTLD_DEFAULT, function));
  const char *text = ask ? ask() : nullptr;
  return text ? text : "";
}

void forget_choice() { // child processes find the environment as the user left it
  unsetenv(choice);
  unsetenv(mark);
}

BlasKernel find_kernel() {
  BlasKernel kernel;
  kernel.name = answer("openblas_get_corename");
  kernel.asked = from_environment(choice);
  kernel.replaced = from_environment(mark);
  kernel.set_by_user = std::getenv(choice) && kernel.replaced.empty();
  kernel.better = better_kernel(kernel.name, vectors_of_processor());
  if (!kernel.replaced.empty()) forget_choice();
  return kernel;
}

} // namespace

Vectors vectors_of_kernel(const std::string &name) {
  static constexpr std::pair<const char *, Vectors> known[] = {
      {"Katmai", Vectors::sse},        {"Coppermine", Vectors::sse},
      {"Northwood", Vectors::sse},     {"Prescott", Vectors::sse},
      {"Banias", Vectors::sse},        {"Atom", Vectors::sse},
      {"Core2", Vectors::sse},         {"Penryn", Vectors::sse},
      {"Dunnington", Vectors::sse},    {"Nehalem", Vectors::sse},
      {"Athlon", Vectors::sse},        {"Opteron", Vectors::sse},
      {"Opteron_SSE3", Vectors::sse},  {"Barcelona", Vectors::sse},
      {"Nano", Vectors::sse},          {"Bobcat", Vectors::sse},
      {"Sandybridge", Vectors::avx},   {"Bulldozer", Vectors::avx},
      {"Piledriver", Vectors::avx},    {"Steamroller", Vectors::avx},
      {"Excavator", Vectors::avx2},    {"Haswell", Vectors::avx2},
      {"Zen", Vectors::avx2},          {"SkylakeX", Vectors::avx512},
      {"Cooperlake", Vectors::avx512}, {"SapphireRapids", Vectors::avx512}};
  for (const auto &[kernel, vectors] : known)
    if (same(kernel, name)) return vectors;
  return Vectors::unknown;
}

Vectors vectors_of_processor() {
#if defined(__x86_64__)
  __builtin_cpu_init();
  if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") && __builtin_cpu_supports("avx512bw") &&
      __builtin_cpu_supports("avx512vl") && __builtin_cpu_supports("avx512cd"))
    return Vectors::avx512;
  if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma")) return Vectors::avx2;
  return __builtin_cpu_supports("avx") ? Vectors::avx : Vectors::sse;
#else
  return Vectors::unknown;
#endif
}

std::string better_kernel(const std::string &name, Vectors processor) {
  const Vectors present = vectors_of_kernel(name);
  if (present == Vectors::unknown || present >= processor) return "";
  return processor == Vectors::avx512 ? "SkylakeX" : processor == Vectors::avx2 ? "Haswell" : "Sandybridge";
}

std::string in_words(const BlasKernel &kernel) {
  std::string why = "chosen by OpenBLAS";
  if (kernel.set_by_user)
    why = same(kernel.name, kernel.asked) ? std::string("set by ") + choice
                                          : "not \"" + kernel.asked + "\", as " + choice + " asks for";
  else if (!kernel.replaced.empty())
    why = same(kernel.name, kernel.asked)
              ? "chosen by Dovetail instead of " + kernel.replaced
              : "though Dovetail asked for " + kernel.asked + " instead of " + kernel.replaced;
  if (!kernel.better.empty()) why += "; " + kernel.better + " would suit this processor";
  return kernel.name + " (" + why + ")";
}

const BlasKernel &blas_kernel() {
  static const BlasKernel kernel = find_kernel();
  return kernel;
}

std::string kinds_of_arithmetic() {
  static constexpr const char *names[] = {"unknown", "SSE", "AVX", "AVX2", "AVX-512"};
  const auto count = reinterpret_cast<int (*)()>(dlsym(RTLD_DEFAULT, "openblas_get_num_threads"));
  const int threads = count ? count() : 1;
  return blas_library() + (blas_kernel().name.empty() ? "" : " kernel " + blas_kernel().name) + ", " +
         std::to_string(threads) + (threads == 1 ? " thread, " : " threads, ") +
         names[static_cast<int>(vectors_of_processor())];
}

bool compute_alike(MPI_Comm comm) {
  const std::uint64_t kind = std::hash<std::string>()(kinds_of_arithmetic());
  std::uint64_t most[] = {kind, ~kind}; // the largest, and of the smallest what is missing
  MPI_Allreduce(MPI_IN_PLACE, most, 2, MPI_UINT64_T, MPI_MAX, comm);
  return most[0] == ~most[1];
}

void take_better_kernel(char **argv) {
  const BlasKernel &kernel = blas_kernel();
  if (kernel.better.empty() || kernel.set_by_user || !kernel.replaced.empty()) return;
  if (answer("openblas_get_config").find("DYNAMIC_ARCH") == std::string::npos) return; // it has this kernel only
  const auto *program = reinterpret_cast<const char *>(getauxval(AT_EXECFN));          // how the system found it
  if (!program) return;
  setenv(choice, kernel.better.c_str(), 1);
  setenv(mark, kernel.name.c_str(), 1);
  execv(program, argv);
  forget_choice(); // it cannot be started anew, and goes on with the kernel that there is
}

std::string blas_library() {
  const std::string config = answer("openblas_get_config"); // "OpenBLAS 0.3.21 DYNAMIC_ARCH ..."
  if (!config.empty()) return config.substr(0, config.find(' ', config.find(' ') + 1));
  Dl_info file{};
  void *product = dlsym(RTLD_DEFAULT, "dgemm_");
  return product && dladdr(product, &file) && file.dli_fname ? file.dli_fname : "unknown";
}

} // namespace dovetail

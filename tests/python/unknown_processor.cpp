// Preloaded, it makes OpenBLAS take Prescott's kernel, as for a processor that it does not know; nobody else sees this.
// In the file $STARTS it keeps a record of the processes: name, id, and OPENBLAS_CORETYPE at their beginning and end.
#include <dlfcn.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

namespace {

char *value_of(const char *name) {
  const std::size_t length = std::strlen(name);
  for (char **entry = environ; entry && *entry; ++entry)
    if (std::strncmp(*entry, name, length) == 0 && (*entry)[length] == '=') return *entry + length + 1;
  return nullptr;
}

void record() {
  const char *path = value_of("STARTS"), *kernel = value_of("OPENBLAS_CORETYPE");
  std::FILE *file = path ? std::fopen(path, "a") : nullptr;
  if (!file) return;
  std::fprintf(file, "%s %d %s\n", program_invocation_short_name, getpid(), kernel ? kernel : "none");
  std::fclose(file);
}

__attribute__((constructor)) void begins() { record(); }
__attribute__((destructor)) void ends() { record(); }

} // namespace

extern "C" char *getenv(const char *name) noexcept {
  static char prescott[] = "Prescott";
  char *value = value_of(name);
  Dl_info caller{};
  const bool ignored = value_of("DEAF_OPENBLAS"); // it does not heed the variable either
  if (std::strcmp(name, "OPENBLAS_CORETYPE") == 0 && (!value || ignored) &&
      dladdr(__builtin_return_address(0), &caller) && std::strstr(caller.dli_fname, "openblas"))
    return prescott;
  return value;
}

// Stands in for libFuzzer: runs the harness it is linked with on every file named, and on those in every folder named.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <vector>

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t *data, std::size_t size);
extern "C" __attribute__((weak)) int LLVMFuzzerInitialize(int *argc, char ***argv);

int main(int argc, char **argv) {
  namespace fs = std::filesystem;
  std::vector<fs::path> files;
  for (int i = 1; i < argc; ++i)
    if (fs::is_directory(argv[i]))
      std::copy(fs::directory_iterator(argv[i]), {}, std::back_inserter(files));
    else
      files.emplace_back(argv[i]);
  if (files.empty()) return std::fprintf(stderr, "%s: no input\n", argv[0]), 1;
  std::sort(files.begin(), files.end());
  if (LLVMFuzzerInitialize) LLVMFuzzerInitialize(&argc, &argv);
  for (const auto &file : files) {
    std::ifstream stream(file, std::ios::binary);
    if (!stream) return std::perror(file.c_str()), 1;
    const std::vector<char> bytes(std::istreambuf_iterator<char>(stream), {});
    std::fprintf(stderr, "Running: %s\n", file.c_str()); // libFuzzer's words: the last one names what ended the program
    LLVMFuzzerTestOneInput(reinterpret_cast<const std::uint8_t *>(bytes.data()), bytes.size());
  }
  std::fprintf(stderr, "replay: %zu inputs\n", files.size());
}

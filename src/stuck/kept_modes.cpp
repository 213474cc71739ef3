#include "stuck/kept_modes.hpp"

#include <unistd.h>

#include <cinttypes>
#include <cstdio>
#include <cstring>

#include "stuck/own_rows.hpp"
#include "support/error.hpp"
#include "support/hash.hpp"
#include "support/hdf5.hpp"

namespace dovetail {
namespace {

constexpr const char *format = "dovetail-stuck";

bool there(const std::filesystem::path &path) {
  std::error_code unreadable;
  return std::filesystem::exists(path, unreadable);
}

std::string in_hex(std::uint64_t number) {
  char text[17];
  std::snprintf(text, sizeof text, "%016" PRIx64, number);
  return text;
}

// Own rows in two pieces: of modes, of contact dofs. f(first number, rows, place among the own rows).
template <class F> void each_range(const Layout &layout, int rank, F f) {
  const hsize_t modes = share_of(layout.modes, rank, layout.size).size();
  const Range points = share_of(layout.points, rank, layout.size);
  f(hsize_t(share_of(layout.modes, rank, layout.size).begin), modes, hsize_t{0});
  f(hsize_t(layout.modes + 3 * points.begin), hsize_t(3 * points.size()), modes);
}

} // namespace

std::uint64_t fingerprint(const Layout &layout, const std::vector<double> &K, const std::vector<double> &M) {
  const std::size_t n = layout.dofs();
  std::uint64_t made = 0; // a sum, whose terms may come in any order
  std::uint64_t salt = n;
  for (const std::vector<double> *matrix : {&K, &M}) {
    salt = mix(salt);
    for (PetscInt d = 0; d < layout.own_dofs(); ++d)
      for (std::size_t j = 0; j < n; ++j) {
        std::uint64_t bits;
        std::memcpy(&bits, &(*matrix)[d * n + j], sizeof bits);
        made += mix(mix(salt ^ (layout.number(d) * n + j)) ^ bits);
      }
  }
  MPI_Allreduce(MPI_IN_PLACE, &made, 1, MPI_UINT64_T, MPI_SUM, layout.comm);
  return made;
}

bool read_modes(const Layout &layout, const std::filesystem::path &path, std::uint64_t fingerprint,
                std::vector<double> &lambda, std::vector<double> &modes) {
  const hsize_t n = layout.dofs();
  std::vector<double> squares, shapes;
  int good = there(path);
  if (good) try {
      const h5::Reader file(path);
      good = file.text_attribute("format") == format && file.text_attribute("of") == in_hex(fingerprint) &&
             file.extent("/modes") == h5::Extent{n, n} && file.extent("/squares") == h5::Extent{n};
      if (good) squares = file.doubles("/squares");
      each_range(layout, layout.rank, [&](hsize_t first, hsize_t rows, hsize_t) {
        if (!good || rows == 0) return;
        const std::vector<double> own = file.doubles("/modes", {first, 0}, {rows, n});
        shapes.insert(shapes.end(), own.begin(), own.end());
      });
    } catch (const InputError &) {
      good = 0;
    }
  MPI_Allreduce(MPI_IN_PLACE, &good, 1, MPI_INT, MPI_MIN, layout.comm);
  if (good) lambda.swap(squares), modes.swap(shapes);
  return good;
}

void keep_modes(const Layout &layout, const std::filesystem::path &path, std::uint64_t fingerprint,
                const std::vector<double> &lambda, const std::vector<double> &modes) {
  const hsize_t n = layout.dofs();
  const RowMessages messages(layout);
  if (layout.rank > 0) messages.send(modes, 0);
  std::filesystem::path partial = path;
  partial += "." + std::to_string(getpid()) + ".partial"; // several runs of a study may share the folder
  int received = 1;                                       // ranks whose rows came
  std::vector<double> others;
  const auto receive = [&] {
    messages.receive(others, received, received);
    ++received;
  };
  if (layout.rank == 0) try {
      if (!there(path) || h5::Reader(path).text_attribute("format") == format) {
        {
          h5::Writer file(partial);
          file.attribute("format", format);
          file.attribute("of", in_hex(fingerprint));
          file.rows("/squares", {n}, 0, n, lambda.data());
          for (int r = 0; r < layout.size; ++r) {
            if (r > 0) receive();
            const std::vector<double> &rows = r > 0 ? others : modes;
            each_range(layout, r, [&](hsize_t first, hsize_t count, hsize_t at) {
              if (count > 0) file.rows("/modes", {n, n}, first, count, &rows[at * n]);
            });
          }
          file.flush();
          file.close();
        }
        std::filesystem::rename(partial, path);
      }
    } catch (const std::runtime_error &) { // of reading, writing or renaming
      std::error_code ignored;
      std::filesystem::remove(partial, ignored);
    }
  while (layout.rank == 0 && received < layout.size) receive(); // in vain
}

} // namespace dovetail

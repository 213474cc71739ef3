#include <algorithm>
#include <cstring>
#include <exception>

#include "support/error.hpp"
#include "support/hdf5.hpp"
#include "support/ordered_file.hpp"

namespace dovetail::h5 {
namespace {

enum class Manner { plain, ordered };

Id create(const std::filesystem::path &path, Manner manner) {
  silence();
  Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  constexpr auto format = H5F_LIBVER_V18; // attributes above 64 KiB: the text of a long case
  const bool good = H5Pset_file_locking(access, false, true) >= 0 &&
                    H5Pset_libver_bounds(access, format, format) >= 0 &&
                    (manner != Manner::ordered || use_ordered_driver(access));
  const hid_t file = good ? H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access) : -1;
  if (file < 0) throw WriteError(path.string() + ": cannot be created");
  return Id(file, H5Fclose);
}

} // namespace

Writer::Writer(const std::filesystem::path &path, MPI_Comm comm, Id file)
    : path_(path), comm_(comm), file_(std::move(file)) {}
Writer::Writer(const std::filesystem::path &path) : Writer(path, MPI_COMM_NULL, create(path, Manner::plain)) {}
Writer::Writer(MPI_Comm comm, const std::filesystem::path &path) : Writer(path, comm, Id(-1, H5Fclose)) {
  MPI_Comm_rank(comm, &rank_);
  MPI_Comm_size(comm, &ranks_);
  on_all_ranks(comm, [&] {
    if (rank_ == 0) file_ = create(path, Manner::plain);
  });
}
Writer Writer::that_survives(const std::filesystem::path &path) {
  return Writer(path, MPI_COMM_NULL, create(path, Manner::ordered));
}

// On rank 0; if it fails, all ranks throw.
template <class Work> void Writer::on_the_first(Work &&work) {
  if (comm_ == MPI_COMM_NULL) return work();
  on_all_ranks(comm_, [&] {
    if (rank_ == 0) work();
  });
}

void Writer::set_attribute(const std::string &name, const std::string &object, hid_t type, const void *value) {
  Id space(H5Screate(H5S_SCALAR), H5Sclose);
  const bool there = H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) > 0;
  Id attribute(there ? H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT)
                     : H5Acreate_by_name(file_, object.c_str(), name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT,
                                         H5P_DEFAULT),
               H5Aclose);
  if (attribute < 0 || H5Awrite(attribute, type, value) < 0)
    throw WriteError(path_.string() + ": attribute " + name + " cannot be written");
}

void Writer::attribute(const std::string &name, const std::string &text, const std::string &object) {
  on_the_first([&] {
    Id type(H5Tcopy(H5T_C_S1), H5Tclose);
    if (H5Tset_size(type, text.size() + 1) < 0 || H5Tset_cset(type, H5T_CSET_UTF8) < 0)
      throw WriteError(path_.string() + ": attribute " + name + " cannot be written");
    set_attribute(name, object, type, text.c_str());
  });
}

void Writer::attribute(const std::string &name, long number, const std::string &object) {
  on_the_first([&] { set_attribute(name, object, H5T_NATIVE_LONG, &number); });
}

void Writer::attribute(const std::string &name, const std::vector<std::string> &words) {
  std::vector<const char *> texts;
  for (const std::string &word : words) texts.push_back(word.c_str());
  const hsize_t count = texts.size();
  on_the_first([&] {
    Id type(H5Tcopy(H5T_C_S1), H5Tclose), space(H5Screate_simple(1, &count, nullptr), H5Sclose);
    H5Tset_size(type, H5T_VARIABLE);
    H5Tset_cset(type, H5T_CSET_UTF8);
    Id attribute(H5Acreate2(file_, name.c_str(), type, space, H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
    if (attribute < 0 || H5Awrite(attribute, type, texts.data()) < 0)
      throw WriteError(path_.string() + ": attribute " + name + " cannot be written");
  });
}

void Writer::write_own(const std::string &dataset, hid_t type, const Extent &extent, const Extent &offset,
                       const Extent &count, const void *values) {
  Id links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(links, 1);
  Id space(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose);
  const bool begun = written_ == dataset;
  Id set(begun ? H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT)
               : H5Dcreate2(file_, dataset.c_str(), type, space, links, H5P_DEFAULT, H5P_DEFAULT),
         H5Dclose);
  if (set < 0) throw WriteError(path_.string() + ": " + dataset + ": cannot be created (is the disk full?)");
  written_ = dataset;
  hsize_t total = 1;
  for (const hsize_t n : count) total *= n;
  if (total == 0) return;
  Id memory(H5Screate_simple(1, &total, nullptr), H5Sclose);
  if (H5Sselect_hyperslab(space, H5S_SELECT_SET, offset.data(), nullptr, count.data(), nullptr) < 0 ||
      H5Dwrite(set, type, memory, space, H5P_DEFAULT, values) < 0 ||
      !set.close_now()) // only now is a small piece written
    throw WriteError(path_.string() + ": " + dataset + ": cannot be written (is the disk full?)");
}

// Rank 0 writes what it has, then what the others send it, piece by piece. What fails is told when all has come.
void Writer::write(const std::string &dataset, hid_t type, const Extent &extent, const Extent &offset,
                   const Extent &count, const void *values) {
  if (comm_ == MPI_COMM_NULL) return write_own(dataset, type, extent, offset, count, values);
  constexpr hsize_t most = 1 << 26; // bytes of a piece
  constexpr int tag = 1;
  const std::size_t axes = extent.size();
  const auto each_piece = [&](const Extent &from, Extent size, const auto &take) { // of whole rows
    hsize_t row = H5Tget_size(type);
    for (std::size_t i = 1; i < axes; ++i) row *= size[i];
    const hsize_t rows = std::exchange(size[0], std::max<hsize_t>(1, most / std::max<hsize_t>(1, row)));
    Extent at = from;
    for (hsize_t done = 0; row > 0 && done < rows; done += size[0], at[0] += size[0]) {
      size[0] = std::min(size[0], rows - done);
      take(at, size, done * row, static_cast<int>(size[0] * row));
    }
  };
  if (rank_ > 0) {
    Extent place = offset;
    place.insert(place.end(), count.begin(), count.end());
    MPI_Send(place.data(), static_cast<int>(sizeof(hsize_t) * 2 * axes), MPI_BYTE, 0, tag, comm_);
    each_piece(offset, count, [&](const Extent &, const Extent &, hsize_t begin, int bytes) {
      MPI_Send(static_cast<const char *>(values) + begin, bytes, MPI_BYTE, 0, tag, comm_);
    });
  }
  on_the_first([&] {
    std::exception_ptr failed;
    const auto write = [&](const Extent &at, const Extent &size, const void *piece) {
      try {
        if (!failed) write_own(dataset, type, extent, at, size, piece);
      } catch (const WriteError &) {
        failed = std::current_exception();
      }
    };
    write(offset, count, values);
    Extent place(2 * axes);
    std::vector<char> buffer;
    for (int r = 1; r < ranks_; ++r) {
      MPI_Recv(place.data(), static_cast<int>(sizeof(hsize_t) * 2 * axes), MPI_BYTE, r, tag, comm_, MPI_STATUS_IGNORE);
      each_piece({place.begin(), place.begin() + axes}, {place.begin() + axes, place.end()},
                 [&](const Extent &at, const Extent &size, hsize_t, int bytes) {
                   buffer.resize(bytes);
                   MPI_Recv(buffer.data(), bytes, MPI_BYTE, r, tag, comm_, MPI_STATUS_IGNORE);
                   write(at, size, buffer.data());
                 });
    }
    if (failed) std::rethrow_exception(failed);
  });
}

void Writer::slab(const std::string &dataset, const Extent &extent, const Extent &offset, const Extent &count,
                  const double *values) {
  write(dataset, H5T_NATIVE_DOUBLE, extent, offset, count, values);
}

void Writer::slab(const std::string &dataset, const Extent &extent, const Extent &offset, const Extent &count,
                  const long *values) {
  write(dataset, H5T_NATIVE_LONG, extent, offset, count, values);
}

void Writer::flush() {
  on_the_first([&] {
    if (H5Fflush(file_, H5F_SCOPE_LOCAL) < 0)
      throw WriteError(path_.string() + ": cannot be written (is the disk full?)");
  });
}

void Writer::close() {
  on_the_first([&] {
    if (!file_.close_now()) throw WriteError(path_.string() + ": cannot be closed (is the disk full?)");
  });
}

Table::Table(Writer &file, const std::string &name, const Extent &row, hid_t type, hsize_t chunk_rows, bool wider)
    : name_(name), row_(row), chunk_width_(width()), type_(type), dataset_(-1, H5Dclose) {
  Extent extent{0}, largest{H5S_UNLIMITED}, chunk{chunk_rows};
  for (const hsize_t n : row_) extent.push_back(n), largest.push_back(n), chunk.push_back(n);
  if (wider) largest.back() = H5S_UNLIMITED;
  Id space(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), largest.data()), H5Sclose);
  Id properties(H5Pcreate(H5P_DATASET_CREATE), H5Pclose);
  H5Pset_chunk(properties, static_cast<int>(chunk.size()), chunk.data());
  Id links(H5Pcreate(H5P_LINK_CREATE), H5Pclose);
  H5Pset_create_intermediate_group(links, 1);
  Id access(H5Pcreate(H5P_DATASET_ACCESS), H5Pclose);
  H5Pset_chunk_cache(access, 0, 0, 0); // else every flush would write the whole chunk again
  dataset_ = Id(H5Dcreate2(file, name.c_str(), type, space, links, properties, access), H5Dclose);
  if (dataset_ < 0) throw WriteError("results: " + name + " cannot be created");
}

std::size_t Table::bytes_of_row(hsize_t width) const {
  std::size_t bytes = H5Tget_size(type_);
  for (std::size_t i = 0; i < row_.size(); ++i) bytes *= width > 0 && i + 1 == row_.size() ? width : row_[i];
  return bytes;
}

void Table::resize(hsize_t rows) {
  Extent extent{rows};
  extent.insert(extent.end(), row_.begin(), row_.end());
  if (H5Dset_extent(dataset_, extent.data()) < 0)
    throw WriteError("results: " + name_ + " cannot grow (is the disk full?)");
  rows_ = rows;
}

void Table::append(const void *rows, hsize_t count, hsize_t width) {
  if (count == 0) return;
  Extent offset{rows_}, extent{count};
  for (const hsize_t n : row_) offset.push_back(0), extent.push_back(n);
  resize(rows_ + count);
  Id space(H5Dget_space(dataset_), H5Sclose);
  const auto write = [&](const void *values) {
    Id memory(H5Screate_simple(static_cast<int>(extent.size()), extent.data(), nullptr), H5Sclose);
    if (H5Sselect_hyperslab(space, H5S_SELECT_SET, offset.data(), nullptr, extent.data(), nullptr) < 0 ||
        H5Dwrite(dataset_, type_, memory, space, H5P_DEFAULT, values) < 0)
      throw WriteError("results: " + name_ + " cannot be written (is the disk full?)");
  };
  const hsize_t whole = width > 0 ? width : this->width();
  if (row_.empty() || (whole == this->width() && whole <= chunk_width_)) return write(rows);
  // Chunk by chunk, each in one piece and to its end: HDF5 would write a piece for every run of values that both sides
  // have.
  const std::size_t size = H5Tget_size(type_);
  std::size_t runs = 1;
  for (std::size_t i = 0; i + 1 < extent.size(); ++i) runs *= extent[i];
  for (hsize_t &from = offset.back(); from < whole; from += chunk_width_) {
    extent.back() = std::min(chunk_width_, this->width() - from);
    const hsize_t given = std::min(extent.back(), whole - from);
    std::vector<unsigned char> part(runs * extent.back() * size);
    for (std::size_t i = 0; i < runs; ++i)
      std::memcpy(&part[i * extent.back() * size], static_cast<const unsigned char *>(rows) + (i * whole + from) * size,
                  given * size);
    write(part.data());
  }
}

void Table::widen(hsize_t width) {
  row_.back() = width;
  resize(rows_);
}

} // namespace dovetail::h5

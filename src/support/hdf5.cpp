#include "support/hdf5.hpp"

#include <algorithm>
#include <cstring>
#include <exception>

#include "support/error.hpp"
#include "support/ordered_file.hpp"

namespace dovetail::h5 {
namespace {

void silence() { // HDF5 prints its own stack of errors unless told not to; ours name file and dataset instead
  H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
}

std::string shown(const Extent &extent) {
  std::string text = "(";
  for (std::size_t i = 0; i < extent.size(); ++i) text += (i ? ", " : "") + std::to_string(extent[i]);
  return text + ")";
}

Id open_to_read(const std::filesystem::path &path) {
  silence();
  if (!std::filesystem::exists(path)) throw InputError(path.string() + ": no such file");
  if (std::filesystem::is_directory(path)) throw InputError(path.string() + ": is a folder, an HDF5 file is wanted");
  if (H5Fis_hdf5(path.c_str()) <= 0) throw InputError(path.string() + ": not an HDF5 file (or empty, or cut off)");
  Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_file_locking(access, false, true);
  H5Pset_fclose_degree(access, H5F_CLOSE_STRONG); // with what an error left open in it
  const hid_t file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
  if (file < 0) throw InputError(path.string() + ": cannot be opened: truncated, damaged, or still being written");
  return Id(file, H5Fclose);
}

// A damaged header may promise more values than its file can hold. Compression makes up for some (deflate packs 1032 to
// 1 at best), as do values never written; the file is the one the dataset lives in, which a link may lead to.
bool fits_its_file(hid_t set, const Extent &extent) {
  constexpr double densest = 4096;
  Id type(H5Dget_type(set), H5Tclose), file(H5Iget_file_id(set), H5Fclose);
  hsize_t size = 0;
  if (H5Fget_filesize(file, &size) < 0) return false;
  double bytes = static_cast<double>(H5Tget_size(type));
  for (const hsize_t n : extent) bytes *= static_cast<double>(n);
  return bytes <= densest * static_cast<double>(size);
}

// Files that nobody has named would be read, and of any size.
bool lies_elsewhere(hid_t set) {
  Id properties(H5Dget_create_plist(set), H5Pclose);
  return H5Pget_layout(properties) == H5D_VIRTUAL || H5Pget_external_count(properties) > 0;
}

// What HDF5 says of something's being there. It may not know: then nothing is taken to be absent, as a default would
// stand in.
bool is_there(htri_t answer, const std::string &place) {
  if (answer < 0)
    throw InputError(place + ": cannot be looked up: the file is damaged, or a dataset stands where a group is wanted");
  return answer > 0;
}

bool is_single(hid_t attribute) {
  Id space(H5Aget_space(attribute), H5Sclose);
  return H5Sget_simple_extent_npoints(space) == 1;
}

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

Reader::Reader(const std::filesystem::path &path) : path_(path), file_(open_to_read(path)) {}

bool Reader::has(const std::string &name) const {
  for (std::size_t slash = name.find('/', 1);; slash = name.find('/', slash + 1)) { // every group on the way
    if (!is_there(H5Lexists(file_, name.substr(0, slash).c_str(), H5P_DEFAULT), place(name))) return false;
    if (slash == std::string::npos) return true;
  }
}

Extent Reader::extent(const std::string &dataset) const {
  if (!has(dataset)) throw InputError(place(dataset) + ": missing");
  Id set(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  if (set < 0) throw InputError(place(dataset) + ": a group was found where a dataset is wanted");
  Id space(H5Dget_space(set), H5Sclose);
  const int axes = H5Sget_simple_extent_ndims(space);
  if (axes < 0 || H5Sget_simple_extent_type(space) == H5S_NULL) throw InputError(place(dataset) + ": holds nothing");
  Extent extent(axes);
  if (H5Sget_simple_extent_dims(space, extent.data(), nullptr) < 0)
    throw InputError(place(dataset) + ": has no shape: the file is damaged");
  if (lies_elsewhere(set))
    throw InputError(place(dataset) + ": its values are in other files; write them into this one");
  if (!fits_its_file(set, extent))
    throw InputError(place(dataset) + ": has shape " + shown(extent) +
                     ", more than the file can hold: it is damaged, or this was never written");
  return extent;
}

template <class T>
std::vector<T> Reader::read(const std::string &dataset, hid_t type, H5T_class_t wanted, Extent offset,
                            Extent count) const {
  const Extent whole = extent(dataset);
  if (count.empty()) count = whole, offset.assign(whole.size(), 0);
  Id set(H5Dopen2(file_, dataset.c_str(), H5P_DEFAULT), H5Dclose);
  Id stored(H5Dget_type(set), H5Tclose);
  const H5T_class_t found = H5Tget_class(stored);
  if (found != H5T_INTEGER && (found != H5T_FLOAT || wanted == H5T_INTEGER))
    throw InputError(place(dataset) + ": holds values that are not " +
                     (wanted == H5T_INTEGER ? "integers" : "real numbers"));
  hsize_t total = 1;
  for (const hsize_t n : count) total *= n;
  std::vector<T> values(total);
  if (total == 0) return values;
  Id space(H5Dget_space(set), H5Sclose);
  Id memory(H5Screate_simple(1, &total, nullptr), H5Sclose);
  if (!count.empty() && H5Sselect_hyperslab(space, H5S_SELECT_SET, offset.data(), nullptr, count.data(), nullptr) < 0)
    throw InputError(place(dataset) + ": has shape " + shown(whole) + ", too small");
  if (H5Dread(set, type, memory, space, H5P_DEFAULT, values.data()) < 0)
    throw InputError(place(dataset) +
                     ": cannot be read: the file is truncated or damaged, or uses a filter that is not installed");
  return values;
}

std::vector<double> Reader::doubles(const std::string &dataset, Extent offset, Extent count) const {
  return read<double>(dataset, H5T_NATIVE_DOUBLE, H5T_FLOAT, std::move(offset), std::move(count));
}

std::vector<long> Reader::integers(const std::string &dataset, Extent offset, Extent count) const {
  return read<long>(dataset, H5T_NATIVE_LONG, H5T_INTEGER, std::move(offset), std::move(count));
}

std::string Reader::text_attribute(const std::string &name) const {
  if (!is_there(H5Aexists(file_, name.c_str()), place("/") + ": attribute " + name)) return "";
  Id attribute(H5Aopen(file_, name.c_str(), H5P_DEFAULT), H5Aclose);
  Id stored(H5Aget_type(attribute), H5Tclose);
  const std::string unread = place("/") + ": attribute " + name + " cannot be read";
  if (stored < 0) throw InputError(unread);
  if (H5Tget_class(stored) != H5T_STRING || !is_single(attribute)) return "";
  Id type(H5Tcopy(stored), H5Tclose);
  if (H5Tis_variable_str(stored) > 0) {
    char *text = nullptr;
    if (H5Aread(attribute, type, &text) < 0) throw InputError(unread);
    if (!text) return "";
    const std::string copy(text);
    H5free_memory(text);
    return copy;
  }
  std::string text(H5Tget_size(stored), '\0');
  if (H5Aread(attribute, type, text.data()) < 0) throw InputError(unread);
  return text.substr(0, text.find('\0'));
}

std::vector<std::string> Reader::words_attribute(const std::string &name, const std::string &object) const {
  if (!is_there(H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT),
                place(object) + ": attribute " + name))
    return {};
  Id attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  Id type(H5Aget_type(attribute), H5Tclose), space(H5Aget_space(attribute), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  if (H5Tget_class(type) != H5T_STRING || count < 1)
    throw InputError(place(object) + ": attribute " + name + " must be a list of texts");
  std::vector<std::string> words;
  if (H5Tis_variable_str(type) > 0) {
    std::vector<char *> texts(count, nullptr);
    if (H5Aread(attribute, type, texts.data()) < 0)
      throw InputError(place(object) + ": attribute " + name + " cannot be read");
    for (char *text : texts) {
      words.emplace_back(text ? text : "");
      H5free_memory(text);
    }
    return words;
  }
  const std::size_t length = H5Tget_size(type);
  std::string texts(length * count, '\0');
  if (H5Aread(attribute, type, texts.data()) < 0)
    throw InputError(place(object) + ": attribute " + name + " cannot be read");
  for (hssize_t i = 0; i < count; ++i) {
    const std::string text = texts.substr(i * length, length);
    words.push_back(text.substr(0, text.find('\0')));
  }
  return words;
}

std::vector<std::string> Reader::members(const std::string &group) const {
  std::vector<std::string> names;
  Id opened(H5Gopen2(file_, group.c_str(), H5P_DEFAULT), H5Gclose);
  if (opened < 0) throw InputError(place(group) + ": a dataset was found where a group is wanted");
  const auto take = [](hid_t, const char *name, const H5L_info_t *, void *list) -> herr_t {
    static_cast<std::vector<std::string> *>(list)->emplace_back(name);
    return 0;
  };
  if (H5Literate(opened, H5_INDEX_NAME, H5_ITER_INC, nullptr, take, &names) < 0)
    throw InputError(place(group) + ": cannot be read: the file is truncated or damaged");
  return names;
}

std::vector<double> Reader::doubles_attribute(const std::string &name, const std::string &object) const {
  if (H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT) <= 0)
    throw InputError(place(object) + ": attribute " + name + " is missing");
  Id attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  Id space(H5Aget_space(attribute), H5Sclose);
  const hssize_t count = H5Sget_simple_extent_npoints(space);
  std::vector<double> values(count > 0 ? count : 0);
  if (count <= 0 || H5Aread(attribute, H5T_NATIVE_DOUBLE, values.data()) < 0)
    throw InputError(place(object) + ": attribute " + name + " must be a list of numbers");
  return values;
}

long Reader::integer_attribute(const std::string &name, long otherwise, const std::string &object) const {
  if (!is_there(H5Aexists_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT),
                place(object) + ": attribute " + name))
    return otherwise;
  Id attribute(H5Aopen_by_name(file_, object.c_str(), name.c_str(), H5P_DEFAULT, H5P_DEFAULT), H5Aclose);
  long value = otherwise;
  if (attribute < 0 || !is_single(attribute) || H5Aread(attribute, H5T_NATIVE_LONG, &value) < 0)
    throw InputError(place(object) + ": attribute " + name + " must be one whole number");
  return value;
}

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
      H5Dwrite(set, type, memory, space, H5P_DEFAULT, values) < 0)
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

#pragma once
// Thin owners around the HDF5 C interface. Errors are thrown with the name of file and dataset.
#include <hdf5.h>
#include <mpi.h>

#include <exception>
#include <filesystem>
#include <string>
#include <utility>
#include <vector>

namespace dovetail::h5 {

/// Owner of one HDF5 identifier. While an exception unwinds it is left open: closing flushes, which crashes when it is
/// a full disk that ended the run.
class Id {
public:
  Id(hid_t id, herr_t (*close)(hid_t)) : id_(id), close_(close) {}
  Id(Id &&other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
  Id &operator=(Id &&other) noexcept {
    std::swap(id_, other.id_);
    std::swap(close_, other.close_);
    return *this;
  }
  ~Id() {
    if (id_ >= 0 && std::uncaught_exceptions() == 0) close_(id_);
  }
  operator hid_t() const { return id_; }
  /// Now, and says whether that went well. Nothing is left for the destructor.
  bool close_now() {
    const hid_t id = std::exchange(id_, -1);
    return id < 0 || close_(id) >= 0;
  }

private:
  hid_t id_;
  herr_t (*close_)(hid_t);
};

using Extent = std::vector<hsize_t>;

/// HDF5 prints its own stack of errors unless told not to; ours name file and dataset instead.
void silence();

/// A file opened for reading, by each rank on its own. Everything wrong with it is the user's input: InputError.
class Reader {
public:
  explicit Reader(const std::filesystem::path &path);
  Reader(const Reader &) = delete;
  ~Reader() { file_.close_now(); } // also while an exception unwinds: else nobody could write it again in this run

  bool has(const std::string &name) const; ///< group or dataset of this absolute name
  Extent extent(const std::string &dataset) const;
  /// Whole dataset, or the slab of `count` from `offset` along each axis, in row-major order.
  std::vector<double> doubles(const std::string &dataset, Extent offset = {}, Extent count = {}) const;
  std::vector<long> integers(const std::string &dataset, Extent offset = {}, Extent count = {}) const;
  std::vector<std::string> members(const std::string &group) const; ///< names in a group, in order of the alphabet
  std::string text_attribute(const std::string &name) const;        ///< of the root group, "" if absent
  /// A list of texts, or one; empty if absent.
  std::vector<std::string> words_attribute(const std::string &name, const std::string &object = "/") const;
  std::vector<double> doubles_attribute(const std::string &name,
                                        const std::string &object) const; ///< a list of numbers
  /// Of the root group unless another object is named; `otherwise` if absent.
  long integer_attribute(const std::string &name, long otherwise, const std::string &object = "/") const;
  const std::filesystem::path &path() const { return path_; }
  /// The message's beginning: "file.h5: /dataset".
  std::string place(const std::string &dataset) const { return path_.string() + ": " + dataset; }

private:
  template <class T>
  std::vector<T> read(const std::string &dataset, hid_t type, H5T_class_t wanted, Extent offset, Extent count) const;
  std::filesystem::path path_;
  Id file_;
};

/// A file being written. Failures (disk full, no permission) throw WriteError.
class Writer {
public:
  /// Opened by the calling process alone.
  explicit Writer(const std::filesystem::path &path);
  /// Likewise, and opens at any moment from the first flush on, while it is written as well as after a SIGKILL, with
  /// all that was flushed (ordered_file.hpp). No lock is taken.
  static Writer that_survives(const std::filesystem::path &path);
  /// Of all ranks of `comm` together: rank 0 writes, also what the others have. Every call is collective then. Parallel
  /// HDF5 would wait for ever where one rank alone cannot write.
  Writer(MPI_Comm comm, const std::filesystem::path &path);

  /// Of the root group, or of another object; one that is there already gets a new value.
  void attribute(const std::string &name, const std::string &text, const std::string &object = "/");
  void attribute(const std::string &name, long number, const std::string &object = "/");
  void attribute(const std::string &name, const std::vector<std::string> &words); ///< of the root group, a new one
  /// This rank's slab [offset, offset + count) of a dataset of `extent`, row-major; groups on the way are
  /// made. The next call may give another slab of the same dataset. A rank with nothing to write gives a zero in
  /// `count`.
  void slab(const std::string &dataset, const Extent &extent, const Extent &offset, const Extent &count,
            const double *values);
  void slab(const std::string &dataset, const Extent &extent, const Extent &offset, const Extent &count,
            const long *values);
  /// The same for whole rows [first, first + rows) along axis 0.
  template <class T>
  void rows(const std::string &dataset, const Extent &extent, hsize_t first, hsize_t rows, const T *values) {
    Extent offset(extent.size(), 0), count(extent);
    offset[0] = first, count[0] = rows;
    slab(dataset, extent, offset, count, values);
  }
  void flush();
  /// The last call: some file systems only say then that something could not be stored. Collective when the file is.
  void close();
  void was_renamed(const std::filesystem::path &path) { path_ = path; } ///< what messages call it
  operator hid_t() const { return file_; }

private:
  template <class Work> void on_the_first(Work &&work);
  void write_own(const std::string &dataset, hid_t type, const Extent &extent, const Extent &offset,
                 const Extent &count, const void *values);
  Writer(const std::filesystem::path &path, MPI_Comm comm, Id file);
  void set_attribute(const std::string &name, const std::string &object, hid_t type, const void *value);
  void write(const std::string &dataset, hid_t type, const Extent &extent, const Extent &offset, const Extent &count,
             const void *values);
  std::filesystem::path path_;
  MPI_Comm comm_; // of the ranks that write together, or none
  int rank_ = 0, ranks_ = 1;
  Id file_;
  std::string written_; // the last dataset
};

/// A dataset that grows along its first axis, and, where asked for, along its last one.
class Table {
public:
  /// `row`: the other axes; `wider`: the last of them may grow.
  Table(Writer &file, const std::string &name, const Extent &row, hid_t type, hsize_t chunk_rows, bool wider = false);

  /// Appends `count` rows. They may be shorter than the table along the last axis, `width` then says how long: the
  /// rest of them reads as zeros.
  void append(const void *rows, hsize_t count = 1, hsize_t width = 0);
  /// Lets the last axis grow; what was there reads as zeros beyond.
  void widen(hsize_t width);
  const std::string &name() const { return name_; }
  hid_t type() const { return type_; }
  const Extent &row() const { return row_; }
  hsize_t rows() const { return rows_; }
  hsize_t width() const { return row_.empty() ? 1 : row_.back(); }
  std::size_t bytes_of_row(hsize_t width = 0) const; ///< as `append` takes it

private:
  void resize(hsize_t rows);
  std::string name_;
  Extent row_;
  hsize_t chunk_width_;
  hid_t type_;
  hsize_t rows_ = 0;
  Id dataset_;
};

} // namespace dovetail::h5

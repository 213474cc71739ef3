#include "support/hdf5.hpp"

#include "support/error.hpp"

namespace dovetail::h5 {

void silence() { H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr); }

namespace {

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

} // namespace dovetail::h5

#pragma once
// What an object is saved as and restored from: numbers by name. One function that lists an object's fields does both,
// so that neither order nor number of the fields can differ between the two.
#include <algorithm>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "support/error.hpp"

namespace dovetail {

class Archive {
public:
  struct Fields { // saved after every step of a curve: no allocation for each of them
    std::vector<std::pair<std::string, std::size_t>> names; ///< with how many numbers belong to each
    std::vector<double> numbers;
  };

  Archive() = default; ///< to save into
  explicit Archive(Fields fields) : fields_(std::move(fields)), restores_(true) {}

  bool restores() const { return restores_; }
  const Fields &fields() const { return fields_; }

  /// Saves a number (flag, enumerator) under that name, or restores it.
  /// ComputeError: there is none of that name, or not one number.
  template <class T> void field(const char *name, T &value) {
    if (!restores_) return add(name, 1, static_cast<double>(value));
    const auto [first, size] = find(name);
    if (size != 1) throw ComputeError(prefix_ + name + " is not one number in the saved state");
    value = static_cast<T>(*first);
  }
  /// The same for a list of any length.
  void field(const char *name, std::vector<double> &values) {
    if (!restores_) return add(name, values);
    const auto [first, size] = find(name);
    values.assign(first, first + size);
  }
  /// The fields of a part of the object, under names that begin with the part's: `list` calls field().
  template <class List> void part(const char *name, List &&list) {
    const std::string before = std::exchange(prefix_, prefix_ + name + ".");
    list();
    prefix_ = before;
  }

private:
  void add(const char *name, std::size_t size, double value) {
    fields_.names.emplace_back(prefix_ + name, size);
    fields_.numbers.push_back(value);
  }
  void add(const char *name, const std::vector<double> &values) {
    fields_.names.emplace_back(prefix_ + name, values.size());
    fields_.numbers.insert(fields_.numbers.end(), values.begin(), values.end());
  }
  std::pair<const double *, std::size_t> find(const char *name) const {
    const std::string wanted = prefix_ + name;
    std::size_t first = 0;
    for (const auto &[given, size] : fields_.names) {
      if (given == wanted) return {fields_.numbers.data() + first, size};
      first += size;
    }
    throw ComputeError(wanted + " is missing in the saved state");
  }

  Fields fields_;
  std::string prefix_;
  bool restores_ = false;
};

} // namespace dovetail

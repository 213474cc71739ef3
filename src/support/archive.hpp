#pragma once
// What an object is saved as and restored from: numbers by name. One function that lists an object's fields does both,
// so that neither order nor number of the fields can differ between the two.
#include <map>
#include <string>
#include <type_traits>
#include <utility>
#include <vector>

#include "support/error.hpp"

namespace dovetail {

class Archive {
public:
  using Fields = std::map<std::string, std::vector<double>>;

  Archive() = default; ///< to save into
  explicit Archive(Fields fields) : fields_(std::move(fields)), restores_(true) {}

  bool restores() const { return restores_; }
  const Fields &fields() const { return fields_; }

  /// Saves a number (flag, enumerator) under that name, or restores it.
  /// ComputeError: there is none of that name, or not one number.
  template <class T> void field(const std::string &name, T &value) {
    std::vector<double> values{static_cast<double>(value)};
    field(name, values);
    if (values.size() != 1) throw ComputeError(prefix_ + name + " is not one number in the saved state");
    if (restores_) value = static_cast<T>(values[0]);
  }
  /// The same for a list of any length.
  void field(const std::string &name, std::vector<double> &values) {
    const std::string full = prefix_ + name;
    if (!restores_) {
      fields_[full] = values;
      return;
    }
    const auto found = fields_.find(full);
    if (found == fields_.end()) throw ComputeError(full + " is missing in the saved state");
    values = found->second;
  }
  /// Saves what is restored in another way than it is saved.
  template <class T> void note(const std::string &name, T value) {
    if (!restores_) field(name, value);
  }
  /// The fields of a part of the object, under names that begin with the part's: `list` calls field().
  template <class List> void part(const std::string &name, List &&list) {
    const std::string before = std::exchange(prefix_, prefix_ + name + ".");
    list();
    prefix_ = before;
  }

private:
  Fields fields_;
  std::string prefix_;
  bool restores_ = false;
};

} // namespace dovetail

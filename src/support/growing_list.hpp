#pragma once
// Numbers that are only ever appended to, of which a copy costs nothing: it keeps its length while the original grows.
#include <cstddef>
#include <memory>
#include <utility>
#include <vector>

namespace dovetail {

class GrowingList {
public:
  GrowingList() : GrowingList(std::vector<double>()) {}
  explicit GrowingList(std::vector<double> values)
      : all_(std::make_shared<std::vector<double>>(std::move(values))), size_(all_->size()) {}

  template <class Values> void append(const Values &values) {
    if (size_ != all_->size()) // a copy went on by itself
      all_ = std::make_shared<std::vector<double>>(all_->begin(), all_->begin() + static_cast<std::ptrdiff_t>(size_));
    all_->insert(all_->end(), values.begin(), values.end());
    size_ = all_->size();
  }
  std::size_t size() const { return size_; }
  const double *begin() const { return all_->data(); }
  const double *end() const { return begin() + size_; }

private:
  std::shared_ptr<std::vector<double>> all_; // of all copies
  std::size_t size_;
};

} // namespace dovetail

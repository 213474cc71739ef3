#include "problems/wider_matrix.hpp"

#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr const char *doing = "widening the Jacobian";

} // namespace

WiderMatrix::WiderMatrix(const Layout &layout, Mat inner, int more) : layout_(layout), more_(more) {
  const PetscInt last = layout.unknowns();
  std::vector<PetscInt> rows, columns;
  const auto add = [&](PetscInt i, PetscInt j) { rows.push_back(i), columns.push_back(j); };
  for_each_row(inner, [&](PetscInt i, PetscInt count, const PetscInt *where, const double *) {
    for (PetscInt j = 0; j < count; ++j) add(i, where[j]);
    for (int b = 0; b < more; ++b) add(i, last + b), add(last + b, i);
  });
  for (int a = 0; a < more && layout.owns_omega(); ++a)
    for (int b = 0; b < more; ++b) add(last + a, last + b);
  const PetscInt own = layout.own_unknowns() + (layout.owns_omega() ? more : 0);
  check(MatCreate(layout.comm, matrix_.out()), doing);
  check(MatSetSizes(matrix_, own, own, last + more, last + more), doing);
  check(MatSetType(matrix_, MATAIJ), doing);
  check(MatSetPreallocationCOO(matrix_, rows.size(), rows.data(), columns.data()), doing);
}

void WiderMatrix::fill(Mat inner, const std::vector<const double *> &columns, const std::vector<const double *> &rows,
                       const double *corner, double swing) {
  const PetscInt motion = layout_.omega_row();
  const auto unit = [&](PetscInt i) { return i % layout_.width ? swing : 1; };
  values_.clear();
  PetscInt own = 0;
  for_each_row(inner, [&](PetscInt i, PetscInt count, const PetscInt *where, const double *entries) {
    for (PetscInt j = 0; j < count; ++j)
      values_.push_back(i < motion && where[j] < motion ? entries[j] * unit(where[j]) / unit(i) : entries[j]);
    for (int b = 0; b < more_; ++b) values_.push_back(columns[b][own]), values_.push_back(rows[b][own]);
    ++own;
  });
  if (layout_.owns_omega()) values_.insert(values_.end(), corner, corner + more_ * more_);
  check(MatSetValuesCOO(matrix_, values_.data(), INSERT_VALUES), doing);
}

template <class Act> void WiderMatrix::for_each_row(Mat inner, Act &&act) const {
  PetscInt begin, end, count;
  const PetscInt *where;
  const double *entries;
  check(MatGetOwnershipRange(inner, &begin, &end), doing);
  for (PetscInt i = begin; i < end; ++i) {
    check(MatGetRow(inner, i, &count, &where, &entries), doing);
    act(i, count, where, entries);
    check(MatRestoreRow(inner, i, &count, &where, &entries), doing);
  }
}

} // namespace dovetail

#pragma once
// Numbers of all ranks on rank 0, however many kinds of them, by one message.
#include <vector>

#include "stuck/layout.hpp"
#include "support/handle.hpp"

namespace dovetail {

class Gathering {
public:
  explicit Gathering(const Layout &layout) : layout_(layout) {}

  // What is added has a number, counted from 0.
  void add(Vec y);                               ///< coefficients (n, 2H+1), then what the last rank has besides
  void add_dofs(const std::vector<double> &own); ///< one number of each dof
  void add_points(const std::vector<double> &own, int each); ///< `each` numbers of a contact point
  /// Collective.
  void bring();
  /// What was added, of modes first, then of contact points in order. Empty on other ranks than 0.
  std::vector<double> take(std::size_t number) const;

private:
  struct Kind { // numbers of a mode, of a contact point, and of the last rank alone
    PetscInt mode, point, last;
  };
  const Layout &layout_;
  std::vector<Kind> kinds_;
  std::vector<double> own_, all_;
};

} // namespace dovetail

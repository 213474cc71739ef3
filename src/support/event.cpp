#include "support/event.hpp"

#include <array>

#include "support/error.hpp"

namespace dovetail {
namespace {

// In the order of Work: contact laws; K q and M q; products with Phi; modal unknowns between ranks; moving contacts
// factored and solved with.
constexpr std::array<const char *, 5> names{"HbContact", "HbMatrices", "HbModes", "HbExchange", "HbFactors"};

std::array<PetscLogEvent, names.size()> registered() {
  PetscClassId id;
  std::array<PetscLogEvent, names.size()> events{};
  check(PetscClassIdRegister("Harmonic balance", &id), "naming kinds of work");
  for (std::size_t i = 0; i < names.size(); ++i)
    check(PetscLogEventRegister(names[i], id, &events[i]), "naming kinds of work");
  return events;
}

} // namespace

Timed::Timed(Work work) {
  static const auto events = registered();
  event_ = events[static_cast<std::size_t>(work)];
  PetscLogEventBegin(event_, 0, 0, 0, 0);
}

} // namespace dovetail

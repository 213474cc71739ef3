// What a case may ask of a sector of a cyclic structure, once it is known whether the model is one.
#include "case/case.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

void refuse(const Case &study, const std::string &key, const std::string &why) {
  if (const auto given = study.given.find(key); given != study.given.end())
    throw InputError(given->second + ": " + key + ": " + why);
}

// Keys that have a meaning for a sector alone.
void refuse_keys_of_sectors(const Case &study, const std::string &file) {
  const std::string none = file + " is no sector of a cyclic structure, it has no /cyclic; delete this key";
  for (const char *key : {"reduction.interior_modes", "reduction.exact_modes"}) refuse(study, key, none);
  refuse(study, "excitation.engine_order", none + ", or give the model of a sector");
}

} // namespace

void settle_cyclic(Case &study, int sectors, bool has_structural, bool is_excited) {
  const std::string file = (study.reduced.empty() ? study.model : study.reduced).string();
  if (sectors == 0) return refuse_keys_of_sectors(study, file);
  if (is_excited && !study.engine_order)
    throw InputError(study.file.string() + ": excitation.engine_order is missing: " + file + " is one of " +
                     std::to_string(sectors) +
                     " equal sectors; write engine_order = 4 where harmonic 1 of the load has 4 waves round them, 0 "
                     "where it is alike on all");
  const std::string sector = "on a sector of a cyclic structure ";
  if (study.exact_modes && study.check_modes)
    refuse(study, "reduction.exact_modes",
           "reduction.check_modes counts interior modes, on which exact ones do not depend; keep one of the two keys");
  if (study.stability.value_or(false))
    refuse(study, "stability.enabled",
           sector + "stability is not judged: the travelling wave may lose it to motions of any number of nodal "
                    "diameters; delete this key, and ask python3 -m dovetail wheel of the results");
  study.stability = false;
  if (study.strategies.has("integration"))
    refuse(study, "recovery.strategies",
           sector +
               "nothing is integrated in time: what moves the joint to the next sector is that sector's past; take "
               "\"integration\" out of the list");
  study.strategies.remove("integration");
  refuse(study, "damping.ratios",
         sector + "modes differ with the nodal diameter, and ratios are not given by it; write damping.stiffness");
  if (study.damping.matrix)
    refuse(study, "damping.matrix", sector + "a viscous matrix is not taken yet; write damping.stiffness");
  if (study.damping.structural != 0 && has_structural)
    refuse(study, "damping.structural",
           sector + "a structural matrix of its own is not taken yet; take it out of " + file +
               " for hysteretic damping by K");
}

} // namespace dovetail

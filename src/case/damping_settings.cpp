#include "case/damping_settings.hpp"

#include "case/number_text.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

void read_ratios(const Document &document, Case &study) {
  const Entry ratios = document["damping.ratios"], of = document["damping.of"];
  study.damping.of_fixed = of && of.word(": ratios of modes with all contacts closed and stuck, or of the reduction's "
                                         "modes, with all contact dofs held") == "fixed";
  if (of && !ratios) of.refuse("says whose ratios damping.ratios are, which is not given");
  if (!ratios) return;
  study.ratios_where = ratios.where();
  if (!ratios.is_list() || ratios.items().empty())
    ratios.refuse("must be a list as [[1, 0.002], [2, 0.003]]: mode, ratio");
  for (const Entry &item : ratios.items()) {
    if (!item.is_list() || item.items().size() != 2) item.refuse("must be [mode, ratio], as [1, 0.002]");
    const Entry mode = item.items()[0], ratio = item.items()[1];
    const ModeRatio read{mode.whole(whole(1)), ratio.number("; 2 % are 0.02")};
    for (const ModeRatio &before : study.damping.ratios)
      if (before.mode == read.mode) mode.refuse("is there already");
    study.damping.ratios.push_back(read);
  }
}

} // namespace

void read_damping(const Document &document, Case &study) {
  for (const auto &[key, value] :
       {std::pair("damping.stiffness", &study.damping.stiffness), std::pair("damping.mass", &study.damping.mass),
        std::pair("damping.structural", &study.damping.structural)})
    if (const Entry entry = document[key]) *value = entry.number();
  read_ratios(document, study);
  if (const Entry matrix = document["damping.matrix"]) study.damping.matrix = matrix.truth();
  const Entry contact = document["damping.contact"];
  if (!contact) return;
  study.damping.contact = contact.truth();
  if (study.damping.contact && study.damping.stiffness == 0)
    contact.refuse("says that damping.stiffness takes the springs of contacts too, which is 0 or not given");
}

// Hysteretic damping is an equation of each harmonic, with none of a motion in time behind it.
void leave_out_motions_in_time(const Document &document, Case &study) {
  if (study.damping.acts_in_time()) return;
  if (study.stability.value_or(false))
    document["stability.enabled"].refuse(
        "stability is judged by motions in time, which damping.structural = " + number_text(study.damping.structural) +
        " (" + document["damping.structural"].place() +
        ") does not have; write false, or damping.stiffness = structural / omega at the resonance in its place");
  study.stability = false;
}

} // namespace dovetail

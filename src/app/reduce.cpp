#include "app/reduce.hpp"
#include "app/idle_loads.hpp"
#include "app/tell_sectors.hpp"

#include <dlfcn.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "case/travelling_wave.hpp"
#include "reduction/craig_bampton.hpp"
#include "reduction/sector_change.hpp"
#include "reduction/sector_coordinates.hpp"
#include "reduction/sector_levels.hpp"
#include "stuck/resonances.hpp"
#include "support/error.hpp"
#include "support/hash.hpp"
#include "support/hdf5.hpp"

namespace dovetail {
namespace {

void warn_of_slow_blas(const Voice &voice) {
  for (const char *known : {"openblas_get_config", "MKL_Get_Version", "bli_info_get_version_str", "armpl_get_version"})
    if (dlsym(RTLD_DEFAULT, known)) return;
  voice.say("note: this looks like reference BLAS, with which factorisations take about 8 times longer; on Debian "
            "install libopenblas0-serial");
}

// Which rows of Phi and Psi are kept: those the case asks for; all, if it does not say, while they are few.
struct Motion {
  bool all = false;
  std::vector<PetscInt> dofs; // ascending, if not all
  std::string in_words;       // for the reduced file
};

Motion wanted_motion(const Case &study, PetscInt elastic, PetscInt columns) {
  constexpr double few = 8e6; // numbers, 64 MB
  Motion motion;
  const MotionWish &wish = study.motion;
  motion.all = wish.given ? wish.all : static_cast<double>(elastic) * columns <= few;
  if (!motion.all) motion.dofs = motion_dofs(study.model, wish);
  if (!motion.all && !study.watch.node.empty()) {
    const NodeMotion watched = node_motion(study.model, study.watch);
    motion.dofs.insert(motion.dofs.end(), watched.dofs.begin(), watched.dofs.end());
    std::sort(motion.dofs.begin(), motion.dofs.end());
    motion.dofs.erase(std::unique(motion.dofs.begin(), motion.dofs.end()), motion.dofs.end());
  }
  std::uint64_t hash = 0;
  for (const PetscInt dof : motion.dofs) hash = mix(hash + static_cast<std::uint64_t>(dof) + 1);
  motion.in_words = motion.all ? "all" : std::to_string(motion.dofs.size()) + " dofs " + std::to_string(hash);
  return motion;
}

ModeKind kind_of(const Case &study) { return study.residuals ? ModeKind::residual : ModeKind::eigen; }

struct Prepared { // for the reduction: parts, what is kept of the fields, and what it will take
  ClampedStructure parts;
  ReductionSettings settings;
  MemoryPlan plan;
  SecondLevel second; // of a cyclic sector
};

bool is_sector(const FullModel &model) { return model.cyclic.sectors > 0; }

PetscInt points_of(const FullModel &model) {
  return static_cast<PetscInt>(is_sector(model) ? model.cyclic.contacts.size() : model.contact_dofs.size());
}

// That of the lowest harmonic of the load: four real solves for every mode of a nodal diameter are dear.
int judged_index(const Case &study, int sectors) {
  const std::vector<int> driving = driving_harmonics(study.loads);
  return std::abs(TravellingWave{sectors, study.engine_order.value_or(1)}.index(driving.empty() ? 1 : driving.front()));
}

// Dofs that the real modes hold, and those that they move.
PetscInt held_by_modes(const FullModel &model) {
  return static_cast<PetscInt>(
      3 * (is_sector(model) ? held_dofs(changed(model.cyclic), model.dofs).size() : model.contact_dofs.size()));
}

// Real modes: N_a, or of a cyclic sector those that its indices share.
PetscInt real_modes(const Case &study, const FullModel &model) {
  constexpr PetscInt times = 5; // for frequencies to 1e-3 at least (reduction.interior_modes in case-file.md)
  if (!is_sector(model)) return study.modes;
  return study.interior_modes > 0 ? study.interior_modes
                                  : std::min(times * study.modes, model.dofs - held_by_modes(model));
}

Prepared prepare(const Case &study, FullModel &&model, const Motion &motion) {
  Prepared prepared;
  auto &[parts, settings, plan, second] = prepared;
  settings.modes = real_modes(study, model);
  if (is_sector(model)) {
    model.C = UniqueMat(), model.K_structural = UniqueMat();
    change_within_sector(model, motion.all, motion.dofs);
    model.contact_dofs = held_dofs(model.cyclic, model.dofs);
    second.exact = study.exact_modes, second.residuals = study.residuals && !study.exact_modes;
    second.judged = judged_index(study, model.cyclic.sectors);
    second.modes = study.modes, second.model_file = study.model;
  }
  parts = clamp(std::move(model));
  settings.check_modes = study.check_modes;
  settings.kind = kind_of(study);
  settings.wanted.assign(parts.elastic_dofs.size(), motion.all);
  for (std::size_t i = 0; i < parts.elastic_dofs.size(); ++i)
    if (std::binary_search(motion.dofs.begin(), motion.dofs.end(), parts.elastic_dofs[i])) settings.wanted[i] = 1;
  const auto kept = is_sector(parts.full) ? static_cast<PetscInt>(parts.moved.dofs.size())
                                          : std::count(settings.wanted.begin(), settings.wanted.end(), 1);
  plan = plan_memory(parts, settings.modes, static_cast<PetscInt>(kept), study.memory * 1024 * 1024 * 1024,
                     study.check_modes);
  if (is_sector(parts.full)) plan_sector(parts, settings.modes, second, plan);
  return prepared;
}

void refuse_too_many_modes(const Case &study, const FullModel &model) {
  const PetscInt elastic = model.dofs - held_by_modes(model);
  if (is_sector(model)) {
    const PetscInt shared = real_modes(study, model),
                   own = SectorCoordinates(changed(model.cyclic), held_by_modes(model), 0).own();
    if (shared > elastic)
      throw InputError(model.file.string() + ": reduction.interior_modes = " + std::to_string(shared) +
                       ", but with its faces, its contact points and the nodes of joints to the next one held, the "
                       "sector has only " +
                       std::to_string(elastic) + " dofs: at most so many modes exist");
    if (study.modes > shared + own)
      throw InputError(model.file.string() + ": reduction.modes = " + std::to_string(study.modes) + ", but " +
                       std::to_string(shared) + " interior modes and the faces make only " +
                       std::to_string(shared + own) + " in each nodal diameter");
    return;
  }
  if (study.modes > elastic)
    throw InputError(model.file.string() + ": reduction.modes = " + std::to_string(study.modes) +
                     ", but the model has only " + std::to_string(elastic) +
                     " elastic dofs (those not in /contact/dofs): at most so many modes exist");
}

Motion agreed_motion(MPI_Comm comm, const Case &study, const FullModel &model) {
  const PetscInt held = held_by_modes(model), rows = is_sector(model) ? model.dofs : model.dofs - held;
  PetscInt columns = real_modes(study, model) + held;
  if (is_sector(model)) columns += (1 + model.cyclic.sectors) * (study.modes + 3 * points_of(model));
  Motion motion;
  on_all_ranks(comm, [&] { motion = wanted_motion(study, rows, columns); });
  return motion;
}

Source source_of(const Case &study, const FullModel &model, const Motion &motion) {
  auto contact_dofs = model.contact_dofs;
  if (is_sector(model)) contact_dofs.assign(points_of(model), {-1, -1, -1}); // relative ones, made for each index
  return {model.file,
          model.hash,
          model.units,
          study.modes,
          kind_of(study),
          study.check_modes,
          motion.in_words,
          "none",
          contact_dofs,
          model.contact.area,
          is_sector(model) ? real_modes(study, model) : 0,
          study.exact_modes};
}

// Results in the folder need the reduced file they were computed from, until others take their place.
void keep_for_results(MPI_Comm comm, const std::filesystem::path &file) {
  on_all_ranks(comm, [&] {
    int rank;
    MPI_Comm_rank(comm, &rank);
    const std::filesystem::path results = file.parent_path() / "results.h5";
    if (rank != 0 || !std::filesystem::exists(results) || !std::filesystem::exists(file)) return;
    std::string wanted, found;
    try {
      wanted = h5::Reader(results).text_attribute("reduced_fingerprint");
      found = h5::Reader(file).text_attribute("fingerprint");
    } catch (const InputError &) { // cut short: of no use to anybody
      return;
    }
    if (!wanted.empty() && wanted == found) std::filesystem::rename(file, old_reduced(file));
  });
}

std::string cost_in_words(const SectorModel &made, const Case &study, PetscInt interior_modes) {
  if (made.left_out < 0) return "";
  char text[160];
  std::snprintf(text, sizeof text, "  the %ld interior modes leave up to %.1e of a frequency, contact points held",
                static_cast<long>(interior_modes), made.left_out);
  const std::string where =
      study.exact_modes ? std::string()
                        : " (nodal diameter " + std::to_string(judged_index(study, made.reduction.model.sectors)) + ")";
  return text + where +
         (made.steps > 1 ? "; taken away by " + std::to_string(made.steps) + " steps to the exact modes" : "");
}

FullModel full_model(MPI_Comm comm, const Case &study, bool need_force = true) {
  FullModel model = read_full_model(comm, study.model);
  if (need_force) refuse_idle_loads(study, model);
  return model;
}

} // namespace

std::filesystem::path old_reduced(const std::filesystem::path &file) { return file.parent_path() / "reduced.old.h5"; }

PetscInt most_modes(const Case &study, const ModelHeader &header) {
  if (header.sectors == 0) return header.dofs - 3 * header.points;
  const CyclicSector sector = changed(read_cyclic_sector(h5::Reader(study.model), header.dofs));
  const PetscInt held = 3 * static_cast<PetscInt>(held_dofs(sector, header.dofs).size()), inside = header.dofs - held;
  return (study.interior_modes > 0 ? std::min<PetscInt>(study.interior_modes, inside) : inside) +
         SectorCoordinates(sector, held, 0).own();
}

ReducedModel given_reduced_model(MPI_Comm comm, const Case &study) {
  ReducedModel model = read_reduced(comm, study.reduced);
  refuse_idle_loads(study, model);
  return model;
}

namespace {

// As reduced_model(), without what is watched.
ReducedModel reduced_from(MPI_Comm comm, const Case &study, const std::filesystem::path &file, Stages &stages,
                          const Voice &voice, std::optional<ReductionFigures> &figures, bool need_force) {
  if (!study.reduced.empty()) {
    ReducedModel given = stages.run("1 model", [&] { return given_reduced_model(comm, study); });
    if (!given.as_written)
      voice.say("note: " + study.reduced.string() + ": its numbers are not those that dovetail wrote (fingerprint)");
    return given;
  }
  FullModel model = stages.run("1 model", [&] { return full_model(comm, study, need_force); });
  refuse_too_many_modes(study, model);
  const Motion motion = agreed_motion(comm, study, model);
  Source source = source_of(study, model, motion);
  if (matches(comm, file, source)) {
    ReducedModel kept = stages.run("2 reduction", [&] { return read_reduced(comm, file); });
    if (kept.as_written) {
      voice.say("reduction: " + file.string() + " still fits the model, reused");
      return kept;
    }
    voice.say("reduction: " + file.string() + " is not as it was written (fingerprint), and is made anew");
  }
  warn_of_slow_blas(voice);
  voice.say("reduction: " + std::to_string(model.dofs) + " dofs, " + std::to_string(points_of(model)) +
            " contact points, " + std::to_string(study.modes) + " modes");
  const CyclicSector sector = model.cyclic;
  if (sector.sectors > 0)
    voice.say("  a sector of " + std::to_string(sector.sectors) + ": " + std::to_string(held_by_modes(model)) +
              " dofs of contact points and faces held, " + std::to_string(source.interior_modes) +
              " interior modes for nodal diameters 0 to " + std::to_string(sector.sectors / 2));
  return stages.run("2 reduction", [&] {
    Prepared prepared = stages.run("2a analysis", [&] { return prepare(study, std::move(model), motion); });
    char work[64] = "";
    double flops = 0;
    if (prepared.parts.solver) {
      source.ordering = prepared.parts.solver->ordering();
      flops = prepared.parts.solver->forecast_flops();
      std::snprintf(work, sizeof work, ", %.3g operations to factor", flops);
    }
    voice.say("  ordering " + source.ordering + work);
    if (prepared.parts.solver && prepared.parts.solver->shared())
      voice.say(
          "  the ranks share one factor: last bits differ from run to run (-kee_whole true: not, with a factor on "
          "each rank)");
    refuse_if_too_large(prepared.parts, prepared.plan);
    voice.say("  memory " + in_words(prepared.plan));
    Tall shapes;
    Reduction reduction = craig_bampton(prepared.parts, prepared.settings, prepared.plan, stages, shapes);
    if (sector.sectors > 0) {
      SectorModel made = stages.run("2g nodal diameters", [&] {
        return sector_model(prepared.parts, shapes, std::move(reduction), prepared.second);
      });
      reduction = std::move(made.reduction);
      voice.say(cost_in_words(made, study, source.interior_modes));
    }
    prepared.parts = ClampedStructure(), shapes = Tall();
    reduction.model.fingerprint = fingerprint_of(reduction.model);
    stages.run("2h writing", [&] {
      keep_for_results(comm, file);
      write_reduced(file, source, reduction);
    });
    char line[160];
    if (study.modes > 0) {
      const auto &squares = reduction.model.kaa;
      const Units units = units_of(reduction.model.units);
      std::snprintf(line, sizeof line, "  fixed-interface frequencies %.6g .. %.6g Hz%s",
                    units.hertz(std::sqrt(squares[0])),
                    units.hertz(std::sqrt(*std::max_element(squares.begin(), squares.end()))),
                    study.residuals     ? ", residuals of the others among them"
                    : study.check_modes ? ", none missed"
                                        : " (reduction.check_modes = true counts them)");
      voice.say(line);
    }
    if (sector.sectors > 0 && study.modes > 0)
      voice.say(
          in_table("  contact points held [Hz]", held_frequencies(reduction.model), units_of(reduction.model.units)));
    if (!motion.all && !study.motion.given)
      voice.say("  the fields are large: only contact points and modes are kept; output.motion names more");
    figures = ReductionFigures{source.ordering, flops, prepared.plan.bytes / (1 << 20), reduction.backward_error,
                               prepared.plan.keep_psi};
    return std::move(reduction.model);
  });
}

} // namespace

ReducedModel reduced_model(MPI_Comm comm, const Case &study, const std::filesystem::path &file, Stages &stages,
                           const Voice &voice, std::optional<ReductionFigures> &figures, bool need_force) {
  ReducedModel model = reduced_from(comm, study, file, stages, voice, figures, need_force);
  if (!study.watch.node.empty())
    on_all_ranks(comm, [&] {
      const NodeMotion motion = node_motion(study.model, study.watch);
      if (model.sectors > 0)
        model.watched_by_index = recovered_rows(file, model.sectors, motion.dofs, motion.factors);
      else
        model.watched = recovered_row(file, motion.dofs, motion.factors);
    });
  return model;
}

std::string forecast_reduction(MPI_Comm comm, const Case &study, const std::filesystem::path &file,
                               std::optional<ReducedModel> &kept, const std::function<void(const FullModel &)> &look) {
  FullModel model = full_model(comm, study);
  refuse_too_many_modes(study, model);
  look(model);
  const Motion motion = agreed_motion(comm, study, model);
  if (matches(comm, file, source_of(study, model, motion))) {
    kept = read_reduced(comm, file);
    if (!kept->as_written) kept.reset();
  }
  const Prepared prepared = prepare(study, std::move(model), motion);
  refuse_if_too_large(prepared.parts, prepared.plan);
  return in_words(prepared.plan);
}

} // namespace dovetail

#include "harmonic/modal.hpp"

#include "harmonic/dampers.hpp"
#include "harmonic/modal_solver.hpp"
#include "harmonic/own_rows.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr PetscInt most_open = 300; // dofs of a model whose modes without contacts are wanted
constexpr double least_held = 1e-6; // lowest of these, squared, by that of the stuck structure; less is a loose body

void unpad(const double *from, int padded, int width, PetscInt rows, double *to) {
  for (PetscInt i = 0; i < rows; ++i) std::copy_n(from + i * padded, width, to + i * width);
}

ModalSolver &solver_of(Mat J) {
  void *solver;
  check(MatShellGetContext(J, &solver), "reaching the modal solver");
  return *static_cast<ModalSolver *>(solver);
}

} // namespace

Modal::Modal(const ReducedModel &model, const std::vector<ContactPoint> &contact,
             const std::vector<Standstill> &standstill, const Damping &damping, const Layout &layout)
    : Modal(
          [&] {
            auto made = std::make_shared<Model>();
            const std::size_t na = model.modes, nc = model.contact_dofs(), own = model.own_contact_dofs();
            made->kaa = model.kaa;
            made->max = rows_of_modes(model.mxa, layout);
            made->mass = Slab<double>(own, na + nc), made->stiffness = Slab<double>(own, nc);
            for (std::size_t i = 0; i < own; ++i) {
              std::copy_n(&model.mxa[i * na], na, made->mass.row(i));
              std::copy_n(&model.mxx[i * nc], nc, made->mass.row(i) + na);
              std::copy_n(&model.kxx[i * nc], nc, made->stiffness.row(i));
            }
            std::vector<double> springs = stuck_springs(contact);
            if (layout.dofs() <= most_open && !damping.has_dampers()) // in its modes these are not diagonal
              made->open = stuck_basis(model, std::vector<double>(springs.size()), layout);
            made->basis = stuck_basis(model, std::move(springs), layout);
            for (const ModeRatio &ratio : damping.has_stuck_ratios() ? damping.ratios : std::vector<ModeRatio>())
              made->basis.rates[ratio.mode - 1] = rate_of(made->basis, ratio);
            if (damping.has_dampers()) {
              made->dampers = std::make_shared<Dampers>(model, contact, standstill, damping, layout);
              made->dampers->project(made->basis);
            }
            if (!made->open.lambda.empty() && made->open.lambda.front() < least_held * made->basis.lambda.front())
              made->open = {};
            return made;
          }(),
          layout) {
  if (damping.has_stuck_ratios()) model_->dampers->take_ratios(*this, model_->basis, damping.ratios);
  dampers_ = model_->dampers;
}

Modal::Modal(std::shared_ptr<const Model> model, const Layout &layout)
    : model_(std::move(model)), layout_(layout), padded_(padded<double>(layout.width)), counts_(layout.size),
      starts_(layout.size), received_(static_cast<std::size_t>(layout.dofs()) * layout.width),
      all_(static_cast<std::size_t>(layout.dofs()) * padded_),
      product_(static_cast<std::size_t>(layout.own_dofs()) * padded_) {
  for (int r = 0; r < layout.size; ++r) {
    const Range modes = share_of(layout.modes, r, layout.size), points = share_of(layout.points, r, layout.size);
    counts_[r] = (modes.size() + 3 * points.size()) * layout.width;
    starts_[r] = (modes.begin + 3 * points.begin) * layout.width;
  }
}

std::unique_ptr<LinearPart> Modal::like(const Layout &layout) const {
  auto other = std::unique_ptr<Modal>(new Modal(model_, layout));
  other->dampers_ = dampers_;
  return other;
}

// all_ = coefficients of all dofs.
void Modal::gather(const double *q) {
  const double *from = q;
  if (layout_.size > 1) {
    MPI_Allgatherv(q, counts_[layout_.rank], MPI_DOUBLE, received_.data(), counts_.data(), starts_.data(), MPI_DOUBLE,
                   layout_.comm);
    from = received_.data();
  }
  const int w = layout_.width;
  for (int r = 0; r < layout_.size; ++r) {
    const Range modes = share_of(layout_.modes, r, layout_.size), points = share_of(layout_.points, r, layout_.size);
    for (const auto &[begin, end] : {std::pair(modes.begin, modes.end),
                                     std::pair(layout_.modes + 3 * points.begin, layout_.modes + 3 * points.end)})
      for (PetscInt dof = begin; dof < end; ++dof, from += w)
        std::copy_n(from, w, &all_[static_cast<std::size_t>(dof) * padded_]);
  }
}

void Modal::multiply(const double *q, double *stiffness_force, double *inertia_force) {
  const int w = layout_.width;
  const PetscInt own_modes = layout_.own_modes.size(), own = 3 * layout_.own_points.size();
  gather(q);
  const double *contact = &all_[static_cast<std::size_t>(layout_.modes) * padded_];
  dovetail::multiply(model_->max, 0, own_modes, contact, padded_, product_.data());
  unpad(product_.data(), padded_, w, own_modes, inertia_force);
  for (PetscInt j = 0; j < own_modes; ++j)
    for (int i = 0; i < w; ++i) {
      inertia_force[j * w + i] += q[j * w + i];
      stiffness_force[j * w + i] = model_->kaa[layout_.own_modes.begin + j] * q[j * w + i];
    }
  dovetail::multiply(model_->mass, 0, own, all_.data(), padded_, product_.data());
  unpad(product_.data(), padded_, w, own, inertia_force + own_modes * w);
  dovetail::multiply(model_->stiffness, 0, own, contact, padded_, product_.data());
  unpad(product_.data(), padded_, w, own, stiffness_force + own_modes * w);
}

std::vector<Coupling> Modal::couplings() const {
  return list_couplings<double>(layout_, model_->kaa, [&](PetscInt i) {
    return ContactRow<double>{model_->mass.row(i), model_->mass.row(i) + layout_.modes, model_->stiffness.row(i)};
  });
}

UniqueMat Modal::matrix(const ContactForces &) const {
  UniqueMat J;
  auto solver = std::make_unique<ModalSolver>(
      std::shared_ptr<const StuckBasis>(model_, &model_->basis),
      model_->open.lambda.empty() ? nullptr : std::shared_ptr<const StuckBasis>(model_, &model_->open), layout_);
  check(MatCreateShell(layout_.comm, layout_.own_unknowns(), layout_.own_unknowns(), layout_.unknowns(),
                       layout_.unknowns(), solver.release(), J.out()),
        "laying out the Jacobian");
  const auto multiply_by =
      +[](Mat A, Vec x, Vec y) -> PetscErrorCode { return solver_of(A).run([&] { solver_of(A).multiply(x, y); }); };
  const auto destroy = +[](Mat A) -> PetscErrorCode {
    delete &solver_of(A);
    return 0;
  };
  check(MatShellSetOperation(J, MATOP_MULT, reinterpret_cast<void (*)()>(multiply_by)), "laying out the Jacobian");
  check(MatShellSetOperation(J, MATOP_DESTROY, reinterpret_cast<void (*)()>(destroy)), "laying out the Jacobian");
  return J;
}

void Modal::fill(Mat J, const JacobianParts &parts) { solver_of(J).fill(parts, *this); }

void Modal::set_up(KSP ksp, Mat J) const { solver_of(J).set_up(ksp, J); }

std::string Modal::recover(KSP, Mat) const { return "the Jacobian is singular, or no number"; }

int Modal::determinant_sign(KSP ksp) const {
  Mat J;
  check(KSPGetOperators(ksp, &J, nullptr), "asking for a determinant");
  return solver_of(J).determinant_sign();
}

double Modal::take_work(Mat J) const { return solver_of(J).take_work(); }

double Modal::memory(Mat J) const { return solver_of(J).memory(); }

void Modal::begin(Mat J, double memory, bool for_one) const { solver_of(J).begin(memory, for_one); }

LinearEffort Modal::take_effort(Mat J, int) const { return solver_of(J).take_effort(); }

} // namespace dovetail

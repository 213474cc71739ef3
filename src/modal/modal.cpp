#include "modal/modal.hpp"

#include "modal/dampers.hpp"
#include "modal/modal_solver.hpp"
#include "stuck/own_rows.hpp"
#include "support/error.hpp"

namespace dovetail {
namespace {

constexpr PetscInt most_open = 300; // dofs of a model whose modes without contacts are wanted
constexpr double least_held = 1e-6; // lowest of these, squared, by that of the stuck structure; less is a loose body

// (columns) of them, as two blocks of real numbers side by side.
void split(const std::complex<double> *from, std::size_t columns, double *to) {
  for (std::size_t j = 0; j < columns; ++j) to[j] = from[j].real(), to[columns + j] = from[j].imag();
}

ModalSolver &solver_of(Mat J) {
  void *solver;
  check(MatShellGetContext(J, &solver), "reaching the modal solver");
  return *static_cast<ModalSolver *>(solver);
}

} // namespace

// One after the other, so that no two are there twice at a time.
Modal::Matrices Modal::taken_from(ReducedModel &model, const Layout &layout) {
  const std::size_t na = model.modes, nc = model.contact_dofs(), own = model.own_contact_dofs();
  Matrices made{model.kaa, rows_of_modes(model.mxa, layout), {}, Slab<double>(own, nc)};
  for (std::size_t i = 0; i < own; ++i) std::copy_n(&model.kxx[i * nc], nc, made.stiffness.row(i));
  std::vector<double>().swap(model.kxx);
  made.mass = Slab<double>(own, na + nc);
  for (std::size_t i = 0; i < own; ++i) {
    std::copy_n(model.mxa.data() + i * na, na, made.mass.row(i));
    std::copy_n(&model.mxx[i * nc], nc, made.mass.row(i) + na);
  }
  std::vector<double>().swap(model.mxx), std::vector<double>().swap(model.mxa);
  return made;
}

Modal::Matrices Modal::matrices_of(const SectorIndex &index, const Layout &layout) {
  const std::size_t na = layout.modes, nc = 3 * layout.points, own = 3 * layout.own_points.size();
  std::vector<double> real, imaginary; // M_ax is their adjoint
  for (const std::complex<double> value : index.mxa) real.push_back(value.real()), imaginary.push_back(-value.imag());
  const Slab<double> real_rows = rows_of_modes(real, layout), imaginary_rows = rows_of_modes(imaginary, layout);
  Matrices made{index.kaa, Slab<double>(real_rows.rows(), 2 * nc), Slab<double>(own, 2 * (na + nc)),
                Slab<double>(own, 2 * nc)};
  for (std::size_t i = 0; i < real_rows.rows(); ++i) {
    std::copy_n(real_rows.row(i), nc, made.max.row(i));
    std::copy_n(imaginary_rows.row(i), nc, made.max.row(i) + nc);
  }
  for (std::size_t i = 0; i < own; ++i) {
    split(&index.mxa[i * na], na, made.mass.row(i));
    split(&index.mxx[i * nc], nc, made.mass.row(i) + 2 * na);
    split(&index.kxx[i * nc], nc, made.stiffness.row(i));
  }
  return made;
}

Modal::Modal(ReducedModel &model, std::vector<SectorIndex> indices, const TravellingWave &wave,
             const std::vector<ContactPoint> &contact, const std::vector<Standstill> &standstill,
             const Damping &damping, const Layout &layout, double reach)
    : Modal(
          [&] {
            auto made = std::make_shared<Model>();
            made->wave = made->bases.wave = wave, made->indices = std::move(indices);
            made->whole.comm = model.comm, made->whole.file = model.file;
            made->whole.modes = model.modes, made->whole.points = model.points;
            made->whole.own_modes = model.own_modes, made->whole.own_points = model.own_points;
            made->matrices.resize(made->indices.size() + 1), made->bases.of_index.resize(made->matrices.size());
            const Matrices &taken = made->matrices[0] = taken_from(model, layout);
            const auto from = [](const Slab<double> &slab, std::size_t column) {
              return PencilRows::Rows{slab.rows() > 0 ? slab.row(0) + column : nullptr, slab.stride()};
            };
            const PencilRows rows(model, from(taken.stiffness, 0), from(taken.mass, layout.modes), from(taken.mass, 0));
            std::vector<double> springs = stuck_springs(contact);
            // in the modes of `open` dampers and sectors are not diagonal
            if (layout.dofs() <= most_open && !damping.has_dampers() && wave.sectors == 0)
              made->open.of_index = {
                  std::make_shared<StuckBasis>(stuck_basis(rows, std::vector<double>(springs.size()), layout))};
            auto basis = std::make_shared<StuckBasis>(modal_basis(
                rows, std::move(springs), layout, damping.has_dampers() || damping.has_stuck_ratios(), reach));
            for (const ModeRatio &ratio : damping.has_stuck_ratios() ? damping.ratios : std::vector<ModeRatio>())
              basis->rates[ratio.mode - 1] = rate_of(*basis, ratio);
            if (damping.has_dampers()) {
              made->dampers = std::make_shared<Dampers>(model, contact, standstill, damping, layout);
              made->dampers->project(*basis);
            }
            if (!made->open.of_index.empty() && made->open.mean().lambda.front() < least_held * basis->lambda.front())
              made->open = {};
            made->bases.of_index[0] = std::move(basis);
            return made;
          }(),
          layout) {
  if (damping.has_stuck_ratios()) model_->dampers->take_ratios(*this, model_->bases.mean(), damping.ratios);
  dampers_ = model_->dampers;
}

Modal::Modal(std::shared_ptr<Model> model, const Layout &layout)
    : model_(std::move(model)), layout_(layout), counts_(layout.size), starts_(layout.size),
      received_(static_cast<std::size_t>(layout.dofs()) * layout.width) {
  const std::vector<IndexGroup> groups = groups_of(model_->wave, layout.width);
  model_->make(groups, layout);
  for (const IndexGroup &group : groups) {
    const Matrices &of = model_->matrices[group.index];
    Bundle<double> all(of.mass, group.columns()), contact(of.stiffness, group.columns());
    const std::size_t product = static_cast<std::size_t>(layout.own_dofs()) * all.strands();
    sheaves_.push_back({group, std::move(all), std::move(contact), Aligned<double>(product)});
  }
  for (int r = 0; r < layout.size; ++r) {
    const Range modes = share_of(layout.modes, r, layout.size), points = share_of(layout.points, r, layout.size);
    counts_[r] = (modes.size() + 3 * points.size()) * layout.width;
    starts_[r] = (modes.begin + 3 * points.begin) * layout.width;
    const std::vector<PetscInt> numbers = numbers_of(layout, r);
    order_.insert(order_.end(), numbers.begin(), numbers.end());
  }
}

// Matrices and modes of the indices that are new.
void Modal::Model::make(const std::vector<IndexGroup> &groups, const Layout &layout) {
  std::vector<const SectorIndex *> wanted;
  std::vector<int> which;
  for (const IndexGroup &group : groups)
    if (!bases.of_index[group.index]) wanted.push_back(&indices[group.index - 1]), which.push_back(group.index);
  std::vector<StuckBasis> made = stuck_bases(whole, wanted, bases.mean().springs, layout);
  for (std::size_t i = 0; i < made.size(); ++i) {
    bases.of_index[which[i]] = std::make_shared<StuckBasis>(std::move(made[i]));
    matrices[which[i]] = matrices_of(indices[which[i] - 1], layout);
    indices[which[i] - 1] = {};
  }
}

std::unique_ptr<LinearPart> Modal::like(const Layout &layout) const {
  auto other = std::unique_ptr<Modal>(new Modal(model_, layout));
  other->dampers_ = dampers_;
  return other;
}

// Coefficients of all dofs. What complex matrices are applied to has two parts: of modes both, then of contact dofs.
// Behind its coefficients each rank sends its part of the sums.
void Modal::gather(const double *q, std::vector<double> &sums) {
  const int more = static_cast<int>(sums.size());
  const double *from = q;
  if (layout_.size > 1) {
    std::vector<double> own(q, q + counts_[layout_.rank]);
    std::vector<int> counts(counts_), starts(starts_);
    own.insert(own.end(), sums.begin(), sums.end());
    for (int r = 0; r < layout_.size; ++r) counts[r] += more, starts[r] += r * more;
    received_.resize(static_cast<std::size_t>(starts.back()) + counts.back());
    MPI_Allgatherv(own.data(), counts[layout_.rank], MPI_DOUBLE, received_.data(), counts.data(), starts.data(),
                   MPI_DOUBLE, layout_.comm);
    std::fill(sums.begin(), sums.end(), 0.0);
    for (int r = 0; r < layout_.size; ++r) {
      const auto behind = received_.begin() + starts[r] + counts_[r];
      for (int i = 0; i < more; ++i) sums[i] += behind[i];
      std::copy_n(received_.begin() + starts[r], counts_[r], received_.begin() + starts_[r]); // closed up
    }
    from = received_.data();
  }
  const PetscInt na = layout_.modes, nc = 3 * layout_.points;
  for (const PetscInt number : order_) {
    for (Sheaf &sheaf : sheaves_) {
      const bool mode = number < na, complex = sheaf.of.complex;
      const PetscInt row = mode || !complex ? number : na + number, block = mode ? na : nc;
      for (int c = 0; c < sheaf.of.columns(); ++c) {
        const double real = sheaf.of.real(c, from), imaginary = complex ? sheaf.of.imaginary(c, from) : 0;
        sheaf.all.at(row, c) = real;
        if (complex) sheaf.all.at(row + block, c) = imaginary;
        if (mode) continue;
        sheaf.contact.at(number - na, c) = real;
        if (complex) sheaf.contact.at(number - na + nc, c) = imaginary;
      }
    }
    from += layout_.width;
  }
}

void Modal::multiply(const double *q, double *stiffness_force, double *inertia_force) {
  std::vector<double> none;
  multiply_and_share(q, stiffness_force, inertia_force, none, layout_.comm);
}

void Modal::multiply_and_share(const double *q, double *stiffness_force, double *inertia_force,
                               std::vector<double> &sums, MPI_Comm) {
  const int w = layout_.width;
  const PetscInt own_modes = layout_.own_modes.size(), own = 3 * layout_.own_points.size();
  gather(q, sums);
  for (Sheaf &sheaf : sheaves_) {
    const Matrices &of = model_->matrices[sheaf.of.index];
    const auto put = [&](const Bundle<double> &columns, const Slab<double> &matrix, PetscInt rows, double *to) {
      columns.multiplied(matrix, 0, rows, sheaf.product.data());
      for (PetscInt i = 0; i < rows; ++i)
        for (int c = 0; c < sheaf.of.columns(); ++c)
          to[i * w + sheaf.of.coefficients[c]] = sheaf.product[i * columns.strands() + c];
    };
    put(sheaf.contact, of.max, own_modes, inertia_force);
    for (PetscInt j = 0; j < own_modes; ++j)
      for (const int i : sheaf.of.coefficients) {
        inertia_force[j * w + i] += q[j * w + i];
        stiffness_force[j * w + i] = of.kaa[layout_.own_modes.begin + j] * q[j * w + i];
      }
    put(sheaf.all, of.mass, own, inertia_force + own_modes * w);
    put(sheaf.contact, of.stiffness, own, stiffness_force + own_modes * w);
  }
}

std::vector<Coupling> Modal::couplings() const {
  if (model_->wave.sectors > 0) throw ComputeError(other_in_every_harmonic);
  const Matrices &of = model_->matrices[0];
  return list_couplings<double>(layout_, of.kaa, [&](PetscInt i) {
    return ContactRow<double>{of.mass.row(i), of.mass.row(i) + layout_.modes, of.stiffness.row(i)};
  });
}

UniqueMat Modal::matrix(const ContactDerivative &) const {
  UniqueMat J;
  auto solver = std::make_unique<ModalSolver>(
      std::shared_ptr<const StuckBases>(model_, &model_->bases),
      model_->open.of_index.empty() ? nullptr : std::shared_ptr<const StuckBases>(model_, &model_->open), layout_);
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

std::vector<double> Modal::own_sums(Mat J, const ContactDerivative &contact) const {
  return {solver_of(J).own_moving(contact)};
}

void Modal::take_sums(Mat J, const double *sums) const { solver_of(J).take_moving(sums[0]); }

LinearEffort Modal::take_effort(Mat J, int) const { return solver_of(J).take_effort(); }

} // namespace dovetail

// Cost and accuracy of the contact forces of random motions, exact and sampled, on one thread. Prints JSON; started and
// read by contact_kernel.py.
#include <sched.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <map>
#include <sstream>
#include <string>

#include "contact/contact_forces.hpp"
#include "contact/wide.hpp"
#include "contact_motions.hpp"
#include "contact_naive.hpp"

using namespace dovetail;

namespace {

// --- Time ------------------------------------------------------------------------------------------------------------

double cpu_seconds() { // of this thread: what others do in the meantime does not count
  timespec now;
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  return now.tv_sec + 1e-9 * now.tv_nsec;
}

double median(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : (values[half - 1] + values[half]) / 2;
}

// CPU seconds of one call of `work`, median of several measurements of at least `shortest` seconds each.
template <class Work> double time_of(int repetitions, double shortest, Work work) {
  double start = cpu_seconds();
  work(); // not counted, but says how often to call
  const int calls = 1 + static_cast<int>(shortest / std::max(cpu_seconds() - start, 1e-9));
  std::vector<double> seconds;
  for (int r = 0; r < repetitions; ++r) {
    start = cpu_seconds();
    for (int c = 0; c < calls; ++c) work();
    seconds.push_back((cpu_seconds() - start) / calls);
  }
  return median(seconds);
}

// Independent multiply-adds, as many as `chains` vectors at a time; result kept so that they are not left out.
template <int chains> inline double multiply_add(long rounds, double factor, double term) {
  Lanes sum[chains];
  for (int i = 0; i < chains; ++i) sum[i] = Lanes{} + i;
  const Lanes a = Lanes{} + factor, b = Lanes{} + term;
  for (long r = 0; r < rounds; ++r)
    for (int i = 0; i < chains; ++i) sum[i] = sum[i] * a + b;
  for (int i = 1; i < chains; ++i) sum[0] += sum[i];
  return sum[0][0];
}
DOVETAIL_WIDE double ten_chains(long rounds, double factor, double term) {
  return multiply_add<10>(rounds, factor, term);
}
DOVETAIL_WIDE double five_chains(long rounds, double factor, double term) { // where vectors are halves of these
  return multiply_add<5>(rounds, factor, term);
}

double peak_flops() {
  volatile double factor = 0.999, sink = 0; // read and written every time, so that no call is left out
  const long rounds = 200000;
  const double ten = time_of(9, 0, [&] { sink = ten_chains(rounds, factor, 1e-3); });
  const double five = time_of(9, 0, [&] { sink = five_chains(rounds, factor, 1e-3); });
  return 2.0 * lane_count * rounds * std::max(10 / ten, 5 / five);
}

// --- Error -----------------------------------------------------------------------------------------------------------

double relative_difference(const double *a, const double *b, int size) { // of b from a, Euclidean norm
  double difference = 0, norm = 0;
  for (int i = 0; i < size; ++i) difference += (a[i] - b[i]) * (a[i] - b[i]), norm += a[i] * a[i];
  return std::sqrt(difference / norm);
}

struct Error { // relative, over the motions
  double median = 0, worst = 0;
  explicit Error(const std::vector<double> &each)
      : median(::median(each)), worst(*std::max_element(each.begin(), each.end())) {}
};

// --- One evaluation of the motions of one kind -----------------------------------------------------------------------

struct Evaluated {
  std::vector<double> G, J;           // of all points; J in blocks, one point after the other
  double residual, jacobian, product; // CPU seconds of all points: forces; forces and blocks; derivative times vector
};

std::size_t block_size(int n) { return block_places(Law::coulomb).size() * n * n; }

Evaluated evaluate(const Motions &motions, int harmonics, int samples, int repetitions, double shortest) {
  ContactForces forces(motions.points, motions.standstill, harmonics, samples);
  const std::size_t blocks = block_size(coefficient_count(harmonics));
  Evaluated out{std::vector<double>(motions.X.size()), std::vector<double>(motions.size() * blocks), 0, 0, 0};
  std::vector<double> product(motions.X.size());
  out.residual = time_of(repetitions, shortest, [&] { forces.evaluate(motions.X.data(), out.G.data(), false); });
  out.jacobian = time_of(repetitions, shortest, [&] {
    forces.evaluate(motions.X.data(), out.G.data());
    for (int p = 0; p < motions.size(); ++p) forces.write(p, &out.J[p * blocks]);
  });
  out.product = time_of(repetitions, shortest, [&] { forces.multiply(motions.X.data(), product.data()); });
  return out;
}

struct Naive {
  double residual, jacobian; // CPU seconds per point
  double difference;         // largest relative deviation of its forces and Jacobians from the lanes'
};

Naive naive(const Motions &motions, const Evaluated &lanes, int harmonics, int samples, int count, int repetitions) {
  const int n = coefficient_count(harmonics), width = 3 * n;
  const std::size_t blocks = block_size(n);
  count = std::min(count, motions.size());
  NaiveLaw law(harmonics, samples);
  std::vector<double> G(width), J(width * width), same(blocks);
  Naive out{0, 0, 0};
  const auto go = [&](int p, bool derivative) {
    law.evaluate(motions.points[p], motions.standstill[p], &motions.X[p * width], G.data(),
                 derivative ? J.data() : nullptr);
  };
  for (const bool derivative : {false, true})
    (derivative ? out.jacobian : out.residual) = time_of(repetitions, 0,
                                                         [&] {
                                                           for (int p = 0; p < count; ++p) go(p, derivative);
                                                         }) /
                                                 count;
  for (int p = 0; p < count; ++p) {
    go(p, true);
    double *next = same.data();
    for (const BlockPlace place : block_places(Law::coulomb))
      for (int i = 0; i < n; ++i, next += n) std::copy_n(&J[(place.row * n + i) * width + place.column * n], n, next);
    out.difference = std::max({out.difference, relative_difference(&lanes.G[p * width], G.data(), width),
                               relative_difference(&lanes.J[p * blocks], same.data(), static_cast<int>(blocks))});
  }
  return out;
}

// --- Everything ------------------------------------------------------------------------------------------------------

using Options = std::map<std::string, std::vector<int>>; // --harmonics 5,10 and so on

Options read(int argc, char **argv) {
  Options options;
  for (int i = 1; i + 1 < argc; i += 2) {
    std::stringstream list(argv[i + 1]);
    for (std::string word; std::getline(list, word, ',');) options[argv[i]].push_back(std::stoi(word));
  }
  return options;
}

int pin() { // to the last processor that this program may use
  cpu_set_t may, one;
  sched_getaffinity(0, sizeof may, &may);
  for (int cpu = CPU_SETSIZE - 1; cpu >= 0; --cpu)
    if (CPU_ISSET(cpu, &may)) {
      CPU_ZERO(&one);
      CPU_SET(cpu, &one);
      return sched_setaffinity(0, sizeof one, &one) == 0 ? cpu : -1;
    }
  return -1;
}

void print(const char *name, const Error &error) {
  std::printf(", \"%s\": {\"median\": %.4g, \"worst\": %.4g}", name, error.median, error.worst);
}

// One line of the measurements; `samples` 0 is the exact evaluation, which all others are compared with.
void print_row(const Kind &kind, int harmonics, const Motions &motions, int samples, const Evaluated &now,
               const Evaluated &exact, const Evaluated &exact_later, const Naive *naive) {
  const int count = motions.size(), width = 3 * coefficient_count(harmonics);
  const int blocks = static_cast<int>(block_size(coefficient_count(harmonics)));
  const std::vector<double> back = samples == exactly ? later(exact_later.G, harmonics, -1) : std::vector<double>{};
  const std::vector<double> &G = samples == exactly ? back : now.G;
  std::vector<double> of_force, of_jacobian;
  for (int p = 0; p < count; ++p) {
    of_force.push_back(relative_difference(&exact.G[p * width], &G[p * width], width));
    of_jacobian.push_back(relative_difference(&exact.J[p * blocks], &now.J[p * blocks], blocks));
  }
  std::printf("\n  {\"kind\": \"%s\", \"harmonics\": %d, \"samples\": %d, \"events\": %.4g, \"runs\": %.4g, \"open\": "
              "%.4g, \"slip\": %.4g, \"residual\": %.6g, \"jacobian\": %.6g, \"product\": %.6g",
              kind.name, harmonics, samples, motions.events, motions.runs, motions.open, motions.slip,
              now.residual / count, now.jacobian / count, now.product / count);
  print("force_error", Error(of_force));
  if (samples != exactly) print("jacobian_error", Error(of_jacobian));
  if (naive)
    std::printf(", \"naive\": {\"residual\": %.6g, \"jacobian\": %.6g, \"difference\": %.3g}", naive->residual,
                naive->jacobian, naive->difference);
  std::printf("}");
}

} // namespace

int main(int argc, char **argv) {
  Options options = read(argc, argv);
  const int count = options["--motions"].at(0), repetitions = options["--repetitions"].at(0);
  const int seed = options["--seed"].at(0), naive_count = options["--naive"].at(0);
  const double shortest = 1e-3 * options["--milliseconds"].at(0);
  const int cpu = pin();
  const double peak = peak_flops();
  std::printf("{\"cpu\": %d, \"measured\": [", cpu);
  const char *comma = "";
  for (const int harmonics : options["--harmonics"])
    for (const Kind &kind : kinds) {
      const Motions motions = random_motions(kind, harmonics, count, seed);
      Motions shifted = motions;
      shifted.X = later(motions.X, harmonics, 1);
      const Evaluated exact = evaluate(motions, harmonics, exactly, repetitions, shortest);
      const Evaluated exact_later = evaluate(shifted, harmonics, exactly, 1, 0);
      std::printf("%s", comma);
      comma = ",";
      print_row(kind, harmonics, motions, exactly, exact, exact, exact_later, nullptr);
      for (const int samples : options["--samples"]) {
        if (samples < coefficient_count(harmonics)) continue;
        const Evaluated now = evaluate(motions, harmonics, samples, repetitions, shortest);
        const Naive plain = naive(motions, now, harmonics, samples, naive_count, std::min(repetitions, 3));
        std::printf(",");
        print_row(kind, harmonics, motions, samples, now, exact, exact_later, &plain);
      }
    }
  std::printf("\n], \"peak_flops\": {\"before\": %.4g, \"after\": %.4g}}\n", peak, peak_flops());
}

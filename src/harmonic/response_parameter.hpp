#pragma once
// What the last unknown of the harmonic-balance equations stands for. One class for each parameter.
#include <memory>
#include <string>
#include <vector>

namespace dovetail {

class HarmonicSystem;

/// What a parameter may change in the equations.
struct Setting {
  double omega; ///< frequency, scaled
  double load;  ///< factor on the load
};

class ResponseParameter {
public:
  virtual ~ResponseParameter() = default;
  virtual std::unique_ptr<ResponseParameter> clone() const = 0;
  virtual std::string name() const = 0;
  virtual std::string unit() const = 0;
  /// The equations at that value.
  virtual Setting at(double value) const = 0;
  /// column: (own coefficients) derivative of the residual at the motion evaluated last.
  virtual void derivative(const HarmonicSystem &system, const Setting &now, std::vector<double> &column) const = 0;
};

/// Omega: the response curve.
class FrequencyParameter : public ResponseParameter {
public:
  std::unique_ptr<ResponseParameter> clone() const override { return std::make_unique<FrequencyParameter>(*this); }
  std::string name() const override { return "frequency"; }
  std::string unit() const override { return "rad/s"; }
  Setting at(double value) const override { return {value, 1}; }
  void derivative(const HarmonicSystem &, const Setting &, std::vector<double> &column) const override;
};

/// A factor on the load, at a fixed frequency.
class LoadParameter : public ResponseParameter {
public:
  explicit LoadParameter(double omega) : omega_(omega) {}
  std::unique_ptr<ResponseParameter> clone() const override { return std::make_unique<LoadParameter>(*this); }
  std::string name() const override { return "force"; }
  std::string unit() const override { return "-"; }
  Setting at(double value) const override { return {omega_, value}; }
  void derivative(const HarmonicSystem &, const Setting &, std::vector<double> &column) const override;

private:
  double omega_;
};

} // namespace dovetail

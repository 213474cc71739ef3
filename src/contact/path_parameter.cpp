#include "contact/path_parameter.hpp"

namespace dovetail {
namespace {

using Scale = PathParameter::Scale;
using P = Setting;

} // namespace

const std::vector<PathParameter> all_parameters{
    {"frequency", "rad/s", Scale::frequency, false, [](P &s, double v) { s.omega = v; }},
    {"force", "-", Scale::none, false, [](P &s, double v) { s.load = v; }},
    {"preload", "-", Scale::none, true, [](P &s, double v) { s.preload = v; }},
    {"damping", "-", Scale::none, false, [](P &s, double v) { s.damping = v; }, true},
    {"normal_stiffness", "-", Scale::none, true, [](P &s, double v) { s.contact.normal_stiffness = v; }},
    {"tangential_stiffness", "-", Scale::none, true,
     [](P &s, double v) {
       s.contact.tangential_stiffness = {v, v};
     }},
    {"tangential_stiffness_1", "-", Scale::none, true, [](P &s, double v) { s.contact.tangential_stiffness[0] = v; }},
    {"tangential_stiffness_2", "-", Scale::none, true, [](P &s, double v) { s.contact.tangential_stiffness[1] = v; }},
    {"friction", "-", Scale::none, true,
     [](P &s, double v) {
       s.contact.friction = {v, v};
     }},
    {"friction_1", "-", Scale::none, true, [](P &s, double v) { s.contact.friction[0] = v; }},
    {"friction_2", "-", Scale::none, true, [](P &s, double v) { s.contact.friction[1] = v; }},
    {"gap", "m", Scale::displacement, true, [](P &s, double v) { s.contact.gap = v; }},
};

const PathParameter *parameter_named(const std::string &name) {
  for (const PathParameter &parameter : all_parameters)
    if (name == parameter.name) return &parameter;
  return nullptr;
}

} // namespace dovetail

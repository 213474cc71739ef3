#pragma once
#include "case/case.hpp"
#include "case/document.hpp"

namespace dovetail {

/// The [contact] section as written, signs checked; the number of contact points is not known yet.
ContactSettings read_contact_settings(const Document &document);

const char *word_of(Law law);
std::vector<std::string> law_words();

} // namespace dovetail

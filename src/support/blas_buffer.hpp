#pragma once

namespace dovetail {

/// Lets OpenBLAS take its working memory now: at its first call it asks for that again and again for ever where there
/// is none. Throws std::bad_alloc instead.
void take_blas_buffer();

} // namespace dovetail

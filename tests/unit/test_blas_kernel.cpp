// Which kernel of OpenBLAS is asked for, and what is said of it. That the program starts anew:
// tests/python/test_kernels.py.
#include <gtest/gtest.h>

#include "support/blas_kernel.hpp"

using namespace dovetail;

TEST(BlasKernel, a_kernel_of_a_lower_class_gives_way) {
  EXPECT_EQ(better_kernel("Prescott", Vectors::avx512), "SkylakeX");
  EXPECT_EQ(better_kernel("Haswell", Vectors::avx512), "SkylakeX");
  EXPECT_EQ(better_kernel("Nehalem", Vectors::avx2), "Haswell");
  EXPECT_EQ(better_kernel("Sandybridge", Vectors::avx2), "Haswell");
  EXPECT_EQ(better_kernel("Core2", Vectors::avx), "Sandybridge");
  EXPECT_EQ(better_kernel("PRESCOTT", Vectors::avx2), "Haswell"); // as libraries for one processor spell it
}

TEST(BlasKernel, a_kernel_of_the_same_or_a_higher_class_stays) {
  for (const char *kernel : {"SkylakeX", "Cooperlake", "SapphireRapids"})
    EXPECT_EQ(better_kernel(kernel, Vectors::avx512), "") << kernel;
  for (const char *kernel : {"Haswell", "Zen", "Excavator", "SkylakeX"})
    EXPECT_EQ(better_kernel(kernel, Vectors::avx2), "") << kernel;
  EXPECT_EQ(better_kernel("Piledriver", Vectors::avx), "");
  EXPECT_EQ(better_kernel("Prescott", Vectors::sse), "");
}

TEST(BlasKernel, what_is_not_known_is_left_alone) {
  for (const char *kernel : {"", "Unknown", "NEOVERSEN1", "GraniteRapids"})
    EXPECT_EQ(better_kernel(kernel, Vectors::avx512), "") << kernel;
  EXPECT_EQ(better_kernel("Prescott", Vectors::unknown), "");
}

TEST(BlasKernel, what_is_asked_for_suits_the_processor) {
  for (const Vectors processor : {Vectors::avx, Vectors::avx2, Vectors::avx512})
    EXPECT_EQ(vectors_of_kernel(better_kernel("Prescott", processor)), processor);
}

TEST(BlasKernel, words_name_whose_choice_it_is) {
  BlasKernel kernel;
  kernel.name = "Zen";
  EXPECT_EQ(in_words(kernel), "Zen (chosen by OpenBLAS)");
  EXPECT_FALSE(kernel.worth_saying());
  kernel.set_by_user = true;
  kernel.asked = "zen";
  EXPECT_EQ(in_words(kernel), "Zen (set by OPENBLAS_CORETYPE)");
  EXPECT_FALSE(kernel.worth_saying());
  kernel.asked = "Zen9";
  kernel.better = "SkylakeX";
  EXPECT_EQ(in_words(kernel), "Zen (not \"Zen9\", as OPENBLAS_CORETYPE asks for; SkylakeX would suit this processor)");
  EXPECT_TRUE(kernel.worth_saying());
}

TEST(BlasKernel, words_tell_what_dovetail_asked_for) {
  BlasKernel kernel;
  kernel.name = kernel.asked = "SkylakeX";
  kernel.replaced = "Prescott";
  EXPECT_EQ(in_words(kernel), "SkylakeX (chosen by Dovetail instead of Prescott)");
  EXPECT_TRUE(kernel.worth_saying());
  kernel.name = "Haswell"; // of a library built without the other
  EXPECT_EQ(in_words(kernel), "Haswell (though Dovetail asked for SkylakeX instead of Prescott)");
}

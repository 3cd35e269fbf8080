// Every kernel that is declared has a test file that bears its name.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace pliant::test {
namespace {

TEST(Coverage, EveryKernelHasATest) {
  const char* const kernels[] = {
#define PLIANT_KERNEL(name) #name,
#include "kernels/all.inc"
#undef PLIANT_KERNEL
  };
  std::size_t count = 0;
  for (const std::string kernel : kernels) {
    bool found = false;
    for (const char* folder : {"kernels", "contact", "device"})
      for (const char* end : {"_test.cpp", ".cpp"})
        found = found || std::filesystem::exists(std::filesystem::path(PLIANT_SOURCE_DIR) / "tests" / folder /
                                                 (kernel + end));
    EXPECT_TRUE(found) << "kernel '" << kernel << "' has no tests/kernels/" << kernel << "_test.cpp";
    ++count;
  }
  EXPECT_GT(count, 30u);
}

} // namespace
} // namespace pliant::test

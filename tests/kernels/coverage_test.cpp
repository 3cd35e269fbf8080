// Every kernel that is declared has a test file that bears its name.
#include <gtest/gtest.h>

#include <filesystem>
#include <string>

namespace pliant::test {
namespace {

// Kernels that are steps of one search or one force are tested as a chain, in a file of the chain's name.
std::string chain_of(const std::string& kernel) {
  if (kernel == "boundary_contact") return "boundary";
  for (const char* part :
       {"cell", "sort", "gather", "warm", "lambda", "shift", "project", "speed", "finish", "sum"})
    if (kernel == std::string("fluid_") + part || kernel == "near_find") return "fluid";
  if (kernel == "residual" || kernel.rfind("line_", 0) == 0) return "line_search";
  if (kernel.rfind("conjugate_", 0) == 0) return "conjugate";
  if (kernel.rfind("fluid_viscosity_", 0) == 0) return "fluid_viscosity";
  if (kernel.rfind("fluid_bond_", 0) == 0) return "fluid_bond";
  if (kernel.rfind("fluid_ghost_", 0) == 0) return "fluid_ghost";
  for (const char* part : {"fluid_gradient", "fluid_newton", "fluid_redistribute"})
    if (kernel.rfind(part, 0) == 0) return "fluid_redistribute";
  if (kernel.rfind("history_", 0) == 0) return "history";
  if (kernel.rfind("factor_", 0) == 0) return "factor";
  for (const char* part : {"coarse_", "_tangent", "_product", "precondition"})
    if (kernel.find(part) != std::string::npos) return "derivative";
  return kernel.rfind("grid_", 0) == 0 || kernel.rfind("contact_", 0) == 0 ? "pairs" : kernel;
}

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
        for (const std::string& name : {kernel, chain_of(kernel)})
          found = found || std::filesystem::exists(std::filesystem::path(PLIANT_SOURCE_DIR) / "tests" /
                                                   folder / (name + end));
    EXPECT_TRUE(found) << "kernel '" << kernel << "' has no tests/kernels/" << kernel << "_test.cpp";
    ++count;
  }
  EXPECT_GT(count, 30u);
}

} // namespace
} // namespace pliant::test

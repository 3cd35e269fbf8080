// A second compiler's opinion: every variant of every kernel through glslangValidator, and the renderer's
// shaders.
#include "backends/gl/shader_text.h"
#include "backends/gl/source.h"
#include "kernels/all.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <unistd.h>

namespace pliant::test {
namespace {

class Validator {
public:
  Validator()
      : folder_(std::filesystem::temp_directory_path() / ("pliant_glsl_" + std::to_string(getpid()))) {
    std::filesystem::create_directories(folder_);
  }
  ~Validator() { std::filesystem::remove_all(folder_); }
  static bool present() { return std::system("glslangValidator --version > /dev/null 2>&1") == 0; }

  void add(const std::string& name, const std::string& stage, const std::string& text) {
    const std::filesystem::path file = folder_ / (std::to_string(count_++) + "." + stage);
    std::ofstream(file) << text;
    names_.push_back(name);
    command_ += " " + file.string();
  }

  /// One process for all: it takes the stage from each file's ending.
  void expect_valid() const {
    ASSERT_GT(count_, 0u);
    FILE* pipe = popen(("glslangValidator" + command_ + " 2>&1").c_str(), "r");
    ASSERT_NE(pipe, nullptr);
    std::string log;
    std::array<char, 4096> part{};
    while (std::fgets(part.data(), part.size(), pipe)) log += part.data();
    EXPECT_EQ(pclose(pipe), 0) << log << legend();
    EXPECT_EQ(log.find("ERROR"), std::string::npos) << log << legend();
    std::printf("%zu shaders, glslangValidator agrees\n", count_);
  }

private:
  std::string legend() const {
    std::string text;
    for (std::size_t i = 0; i < names_.size(); ++i) text += std::to_string(i) + ": " + names_[i] + "\n";
    return text;
  }
  std::filesystem::path folder_;
  std::string command_;
  std::vector<std::string> names_;
  std::size_t count_ = 0;
};

// Values that an option takes in a plan: 0 and 1, but for the field of frame_particles.
std::uint32_t values_of(const KernelInfo& kernel, const Field& option) {
  return std::strcmp(kernel.name, "frame_particles") == 0 && std::strcmp(option.name, "field") == 0 ? 5 : 2;
}

template <class Args> void add_variants(Validator& validator, std::size_t& count) {
  const KernelInfo& kernel = Args::info();
  std::size_t combinations = 1;
  for (const Field& field : kernel.fields)
    if (field.role == Role::option) combinations *= values_of(kernel, field);
  for (std::size_t c = 0; c < combinations; ++c) {
    Args args;
    std::size_t rest = c;
    for (const Field& field : kernel.fields) {
      if (field.role != Role::option) continue;
      const auto value = static_cast<std::uint32_t>(rest % values_of(kernel, field));
      rest /= values_of(kernel, field);
      std::memcpy(reinterpret_cast<char*>(&args) + field.offset, &value, sizeof value);
    }
    validator.add(gl::variant_name(kernel, &args), "comp", gl::expanded_source(kernel, &args));
    ++count;
  }
}

TEST(Glslang, EveryVariantOfEveryKernel) {
  if (!Validator::present()) GTEST_SKIP() << "glslangValidator is missing: apt install glslang-tools";
  Validator validator;
  std::size_t count = 0, kernels = 0;
#define PLIANT_KERNEL(name)                                                                                  \
  add_variants<kernels::name::Args>(validator, count);                                                       \
  ++kernels;
#include "kernels/all.inc"
#undef PLIANT_KERNEL
  EXPECT_GT(count, kernels);
  validator.expect_valid();
}

TEST(Glslang, TheRenderersShaders) {
  if (!Validator::present()) GTEST_SKIP() << "glslangValidator is missing: apt install glslang-tools";
  Validator validator;
  bool any = false;
  for (const auto& [name, text] : gl::shader_texts()) {
    const std::string stage = std::filesystem::path(name).extension().string();
    if (name.rfind("render/", 0) != 0 || (stage != ".vert" && stage != ".frag" && stage != ".comp")) continue;
    gl::Source source;
    gl::append_file(source, name, gl::shader_texts());
    if (source.text.find("#version") == std::string::npos) source.text.insert(0, "#version 430 core\n");
    validator.add(name, stage.substr(1), source.text);
    any = true;
  }
  if (!any) GTEST_SKIP() << "this build has no shaders of a renderer";
  validator.expect_valid();
}

// The check itself can fail.
TEST(Glslang, ABrokenShaderIsRefused) {
  if (!Validator::present()) GTEST_SKIP() << "glslangValidator is missing: apt install glslang-tools";
  const std::filesystem::path file =
      std::filesystem::temp_directory_path() / ("pliant_broken_" + std::to_string(getpid()) + ".comp");
  std::ofstream(file) << "#version 430 core\nvoid main() { nothing = 1; }\n";
  EXPECT_NE(std::system(("glslangValidator " + file.string() + " > /dev/null 2>&1").c_str()), 0);
  std::filesystem::remove(file);
}

} // namespace
} // namespace pliant::test

// What the GL device makes of declarations and shader texts.
#include "backends/gl/names_used.h"
#include "backends/gl/program.h"
#include "kernels/all.h"
#include "tests/device/stamp.h"
#include "tests/support/devices.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <unistd.h>

namespace pliant::test {
namespace {

namespace fs = std::filesystem;
using testing::ElementsAre;
using testing::HasSubstr;
using testing::Not;

bool gl_present() {
  for (const DeviceChoice& choice : device_choices())
    if (choice.gl()) return true;
  return false;
}

class GlPrograms : public testing::Test {
protected:
  void SetUp() override {
    if (!gl_present()) GTEST_SKIP() << "no usable GL device";
    folder_ = fs::temp_directory_path() / ("pliant-cache-" + std::to_string(getpid()));
    setenv("XDG_CACHE_HOME", folder_.c_str(), 1);
  }
  void TearDown() override {
    unsetenv("XDG_CACHE_HOME");
    if (!folder_.empty()) fs::remove_all(folder_);
  }

  std::unique_ptr<Device> open() { return gl::make_device(gl::Context::open(0), &texts); }
  std::vector<fs::path> cached() const {
    std::vector<fs::path> files;
    if (fs::exists(folder_))
      for (const auto& entry : fs::recursive_directory_iterator(folder_))
        if (entry.is_regular_file()) files.push_back(entry.path());
    return files;
  }
  // Runs the plain variant: target += addend.
  void expect_stamp(Device& device, std::uint32_t count) {
    const Buffer target = device.allocate("target", Type::uint, count + 20);
    kernels::stamp::Args args;
    args.threads = count;
    args.addend = 7;
    args.target = target;
    device.run(args);
    args.addend = 10;
    device.run(args);
    const auto values = device.download_uint(target);
    std::size_t wrong = 0;
    for (std::uint32_t i = 0; i < values.size(); ++i) wrong += values[i] != (i < count ? 17u : 0u);
    EXPECT_EQ(wrong, 0u) << "of " << count;
  }
  std::string fault(const std::function<void()>& action) {
    try {
      action();
    } catch (const Error& error) {
      EXPECT_EQ(error.code(), ExitCode::internal);
      return error.what();
    }
    ADD_FAILURE() << "nothing was thrown";
    return {};
  }

  gl::Texts texts = stamp_texts();
  fs::path folder_;
};

TEST_F(GlPrograms, RunEveryThreadOnceAtAwkwardSizes) {
  const auto device = open();
  for (const std::uint32_t count : {1u, 15u, 16u, 17u, 127u, 1000u}) expect_stamp(*device, count);
}

// 70,001 groups of 16 need a second row of groups.
TEST_F(GlPrograms, RunMoreGroupsThanOneDimensionHolds) {
  expect_stamp(*open(), 70000 * 16 + 3);
}

TEST_F(GlPrograms, GetParametersTablesAndOptions) {
  const auto device = open();
  const Buffer source = device->allocate("source", Type::uint, 5),
               target = device->allocate("target", Type::uint, 5);
  const Buffer offsets = device->allocate("offsets", Type::uint4, 3);
  device->upload(source, std::vector<std::uint32_t>{1, 2, 3, 4, 5});
  device->upload(offsets, std::vector<std::uint32_t>{0, 100, 0, 0, 0, 200, 0, 0, 0, 300, 0, 0});
  kernels::stamp::Args args;
  args.threads = 5;
  args.doubled = 1;
  args.addend = 77;
  args.factor = 1000;
  args.source = source;
  args.target = target;
  args.offsets = offsets;
  device->run(args);
  EXPECT_THAT(device->download_uint(target), ElementsAre(1102, 1204, 1306, 1108, 1210));
  EXPECT_THAT(device->kernels_prepared(), ElementsAre("stamp[doubled=1]"));
  args.source = nullptr;
  EXPECT_THAT(fault([&] { device->run(args); }), testing::AllOf(HasSubstr("'stamp'"), HasSubstr("'source'")));
  args.source = target;
  EXPECT_THAT(fault([&] { device->run(args); }), HasSubstr("bound twice"));
  args.source = source;
  args.offsets = source;
  EXPECT_THAT(fault([&] { device->run(args); }), HasSubstr("smaller than its table"));
  args.doubled = 0; // uses neither
  args.source = args.offsets = nullptr;
  device->run(args);
  EXPECT_EQ(device->download_uint(target)[0], 1179u);
}

TEST_F(GlPrograms, ParametersOfManyDispatchesDoNotMix) {
  const auto device = open();
  const Buffer target = device->allocate("target", Type::uint, 1);
  kernels::stamp::Args args;
  args.threads = 1;
  args.target = target;
  std::uint32_t sum = 0;
  for (args.addend = 1; args.addend <= 5000; ++args.addend) { // several times round the ring
    device->run(args);
    sum += args.addend;
  }
  EXPECT_EQ(device->download_uint(target)[0], sum);
}

TEST_F(GlPrograms, FaultsNameFileAndLine) {
  kernels::stamp::Args args;
  texts["stamp.comp"] = "#include \"common/twice.glsl\"\nvoid main() {\n  target[0] = missing;\n}\n";
  EXPECT_THAT(fault([&] { open()->prepare(args.info(), &args); }),
              testing::AllOf(HasSubstr("stamp.comp:3"), HasSubstr("missing"), HasSubstr("stamp[doubled=0]")));
  texts["common/twice.glsl"] = "uint twice(uint value) {\n  return wrong;\n}\n";
  EXPECT_THAT(fault([&] { open()->prepare(args.info(), &args); }), HasSubstr("common/twice.glsl:2"));
  texts["stamp.comp"] = "\n#include \"common/nowhere.glsl\"\nvoid main() {}\n";
  EXPECT_THAT(fault([&] { open()->prepare(args.info(), &args); }),
              testing::AllOf(HasSubstr("stamp.comp:2"), HasSubstr("common/nowhere.glsl")));
  texts["stamp.comp"] = "void helper() {}\n";
  EXPECT_THAT(fault([&] { open()->prepare(args.info(), &args); }), HasSubstr("stamp"));
  EXPECT_TRUE(cached().empty()) << "a fault was cached";
}

TEST(GlLogs, AreReadableFromEveryCompiler) {
  gl::Source source;
  source.files = {"interface of k", "common/a.glsl", "k.comp"};
  EXPECT_EQ(gl::readable_log("2:12(5): error: x\n", source), "k.comp:12: error: x\n");
  EXPECT_EQ(gl::readable_log("1(7) : error C0000: x\n", source), "common/a.glsl:7 : error C0000: x\n");
  EXPECT_EQ(gl::readable_log("ERROR: 2:3: 'x' : undeclared\n", source),
            "ERROR: k.comp:3: 'x' : undeclared\n");
  EXPECT_EQ(gl::readable_log("9:1: x\nlinker 2:3\n", source), "9:1: x\nlinker 2:3\n");
}

TEST_F(GlPrograms, ComeFromTheCacheTheSecondTime) {
  {
    const auto device = open();
    expect_stamp(*device, 17);
    EXPECT_EQ(gl::programs_from_cache(*device), 0u);
  }
  if (cached().empty()) GTEST_SKIP() << "this driver gives no program binaries";
  ASSERT_EQ(cached().size(), 1u);
  {
    const auto device = open();
    expect_stamp(*device, 17);
    EXPECT_EQ(gl::programs_from_cache(*device), 1u);
  }
  texts["stamp.comp"] += "// another text\n";
  const auto device = open();
  expect_stamp(*device, 17);
  EXPECT_EQ(gl::programs_from_cache(*device), 0u);
  EXPECT_EQ(cached().size(), 2u);
}

TEST_F(GlPrograms, RebuildWhatIsDamagedInTheCache) {
  expect_stamp(*open(), 17);
  if (cached().empty()) GTEST_SKIP() << "this driver gives no program binaries";
  const fs::path file = cached()[0];
  const auto size = fs::file_size(file);
  const auto damage = [&](const char* how) {
    const auto device = open();
    expect_stamp(*device, 17);
    EXPECT_EQ(gl::programs_from_cache(*device), 0u) << how;
    EXPECT_EQ(fs::file_size(file), size) << how << ": not written anew";
  };
  fs::resize_file(file, size / 2);
  damage("cut short");
  fs::resize_file(file, 0);
  damage("emptied");
  {
    std::fstream bytes(file, std::ios::in | std::ios::out | std::ios::binary);
    bytes.seekp(static_cast<std::streamoff>(size - 9));
    bytes.put('\x5a').put('\x5b');
  }
  damage("a byte changed");
}

TEST_F(GlPrograms, LeaveTheCacheAloneWhenItIsOff) {
  setenv("PLIANT_PROGRAM_CACHE", "off", 1);
  expect_stamp(*open(), 17);
  unsetenv("PLIANT_PROGRAM_CACHE");
  EXPECT_TRUE(cached().empty());
}

TEST_F(GlPrograms, RunWhereTheCacheCannotBeWritten) {
  std::ofstream(folder_) << "a file where a folder should be";
  expect_stamp(*open(), 17);
}

TEST_F(GlPrograms, AreTimedByComponent) {
  const auto device = open();
  expect_stamp(*device, 16);
  EXPECT_TRUE(device->take_timings().empty()) << "timing is off";
  device->measure(true);
  device->enter("elasticity");
  expect_stamp(*device, 100000);
  device->enter("contact");
  expect_stamp(*device, 16);
  device->enter("");
  device->finish();
  const auto timings = device->take_timings();
  ASSERT_EQ(timings.size(), 2u);
  EXPECT_EQ(timings[0].component, "contact");
  EXPECT_EQ(timings[1].component, "elasticity");
  EXPECT_GT(timings[1].milliseconds, 0);
  EXPECT_LT(timings[1].milliseconds, 10000);
  EXPECT_TRUE(device->take_timings().empty());
}

TEST(NamesUsed, FollowsConditions) {
  const char* text = R"(#define LOCAL 2
#if mode == 1 && !(LOCAL < 2)
a // b
#elif mode == 0
/* c
d */ e[i].f
#ifdef mode
g
#else
h
#endif
#else
j
#endif
#if unknown > 3
k
#else
l
#endif
#define later m)";
  const auto zero = gl::names_used(text, {{"mode", "0"}});
  for (const char* name : {"e", "f", "g", "k", "l", "m"}) EXPECT_EQ(zero.count(name), 1u) << name;
  for (const char* name : {"a", "b", "c", "d", "h", "j"}) EXPECT_EQ(zero.count(name), 0u) << name;
  EXPECT_EQ(gl::names_used(text, {{"mode", "1"}}).count("a"), 1u);
  const auto two = gl::names_used(text, {{"mode", "2"}});
  EXPECT_EQ(two.count("j"), 1u);
  EXPECT_EQ(two.count("a") + two.count("e"), 0u);
}

// Every kernel, with each option off and on, before a compiler that is no driver's.
TEST(Shaders, PassGlslang) {
  if (std::system("glslangValidator --version > /dev/null 2>&1") != 0)
    GTEST_SKIP() << "glslangValidator is missing (apt install glslang-tools)";
  const fs::path file = fs::temp_directory_path() / ("pliant-" + std::to_string(getpid()) + ".comp");
  const auto check = [&](const KernelInfo& kernel, void* args) {
    for (const std::uint32_t value : {0u, 1u}) {
      bool options = false;
      for (const Field& field : kernel.fields)
        if (field.role == Role::option) {
          std::memcpy(static_cast<char*>(args) + field.offset, &value, sizeof value);
          options = true;
        }
      if (value && !options) continue;
      std::ofstream(file) << gl::expanded_source(kernel, args);
      EXPECT_EQ(std::system(("glslangValidator -S comp " + file.string()).c_str()), 0)
          << gl::variant_name(kernel, args);
    }
  };
#define PLIANT_KERNEL(kernel)                                                                                \
  {                                                                                                          \
    kernels::kernel::Args args;                                                                              \
    check(args.info(), &args);                                                                               \
  }
#include "kernels/all.inc"
#undef PLIANT_KERNEL
  fs::remove(file);
}

} // namespace
} // namespace pliant::test

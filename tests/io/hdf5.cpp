// The owning types over HDF5: what is written is read back, and what fails says where and why.
#include "engine/io/hdf5.h"

#include "engine/core/error.h"
#include "tests/io/support.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fstream>
#include <sys/resource.h>
#include <sys/wait.h>

using namespace pliant;
using pliant::test::ScratchFolder;
using testing::AllOf;
using testing::HasSubstr;

namespace {

template <class F> std::string message_of(F&& work) {
  try {
    work();
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::input_output);
    return error.what();
  }
  return "nothing was thrown";
}

} // namespace

TEST(Hdf5, ReadsBackWhatItWrote) {
  ScratchFolder folder;
  const std::vector<double> table = {1, 2, 3, 4, 5, 6};
  const std::vector<std::uint64_t> large = {0, std::uint64_t(1) << 63};
  {
    h5::File file = h5::File::create(folder.path / "a.h5");
    h5::Group group = file.root().create_group("deep/er", true);
    group.write<double>("table", table, 3);
    group.write<std::uint64_t>("large", large);
    h5::Dataset growing = group.create_dataset("growing", h5::Type::float32, 2, 3);
    for (int i = 0; i < 10; ++i) {
      const std::vector<float> rows = {float(i), 0.5f, float(i), 0.25f};
      growing.append<float>(rows);
    }
    group.create_view("view", h5::Type::float32, growing, 3, 2);
    group.soft_link("link", "/deep/er/table");
    group.set_text_attribute("text", "abc");
    group.set_text_attribute("text", "longer");
    group.set_attribute<std::int64_t>("number", 41);
    group.set_attribute<std::int64_t>("number", 42);
    file.flush();
  }
  const h5::File file = h5::File::open(folder.path / "a.h5");
  const h5::Group group = file.root().group("deep/er");
  EXPECT_EQ(group.dataset("table").columns(), 3u);
  EXPECT_EQ(group.read<double>("link"), table);
  EXPECT_EQ(group.read<std::uint64_t>("large"), large);
  EXPECT_EQ(group.dataset("growing").rows(), 20u);
  EXPECT_EQ(group.read<float>("view"), (std::vector<float>{1, 0.25f, 2, 0.5f}));
  EXPECT_EQ(group.text_attribute("text"), "longer");
  EXPECT_EQ(group.attribute<std::int64_t>("number"), std::vector<std::int64_t>{42});
  EXPECT_TRUE(file.root().has("deep/er/table"));
  EXPECT_FALSE(file.root().has("deep/no/table"));
  EXPECT_EQ(group.names(), (std::vector<std::string>{"table", "large", "growing", "view", "link"}));
}

TEST(Hdf5, FailuresNameFileObjectAndReason) {
  ScratchFolder folder;
  const auto path = folder.path / "a.h5";
  EXPECT_THAT(message_of([&] { h5::File::open(path); }),
              AllOf(HasSubstr(path.string()), HasSubstr("No such file")));
  std::ofstream(path) << "this is not HDF5";
  EXPECT_THAT(message_of([&] { h5::File::open(path); }),
              AllOf(HasSubstr(path.string()), HasSubstr("signature")));
  h5::File file = h5::File::create(path);
  EXPECT_THAT(message_of([&] { file.root().dataset("missing"); }),
              AllOf(HasSubstr("cannot open /missing of " + path.string()), HasSubstr("doesn't exist")));
  h5::Dataset small = file.root().create_dataset("small", h5::Type::int32, 1, 4);
  small.append<std::int32_t>(7);
  EXPECT_THAT(message_of([&] { small.read<std::int32_t>(0, 2); }), HasSubstr("/small"));
}

// Without reserve() the failure comes from HDF5 itself, in the middle of a write; the process must live on
// and end well.
TEST(Hdf5, AFullDiskInsideAWriteIsAnError) {
  ScratchFolder folder;
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {1 << 18, 1 << 18};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    std::string said;
    {
      h5::File file = h5::File::create(folder.path / "a.h5");
      said = message_of([&] {
        h5::Dataset data = file.root().create_dataset("data", h5::Type::float32, 1, 1 << 16);
        for (int i = 0; i < 8; ++i) data.append<float>(std::vector<float>(1 << 16, 1.0f));
        file.flush();
      });
    }
    // Another, small file is still possible.
    h5::File::create(folder.path / "b.h5").root().set_attribute("number", 1.5);
    const bool alive = h5::File::open(folder.path / "b.h5").root().attribute<double>("number").at(0) == 1.5;
    std::exit(alive && said.find("File too large; free some space") != std::string::npos ? 0 : 1);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 0);
}

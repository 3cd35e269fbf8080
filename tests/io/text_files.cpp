// statistics.csv, the run's folder, and text files that are never half there.
#include "engine/core/error.h"
#include "engine/io/folder.h"
#include "engine/io/statistics_writer.h"
#include "tests/io/support.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <fcntl.h>
#include <fstream>
#include <sstream>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

using namespace pliant;
using pliant::test::ScratchFolder;
using testing::HasSubstr;

namespace {

std::vector<std::string> split(const std::string& text, char mark) {
  std::vector<std::string> parts;
  std::stringstream stream(text);
  for (std::string part; std::getline(stream, part, mark);) parts.push_back(part);
  return parts;
}

std::string refusal(const std::filesystem::path& folder) {
  try {
    prepare_output_folder(folder);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::input_output);
    return error.what();
  }
  return "accepted";
}

} // namespace

TEST(Statistics, RowsReadBackAsTheSameDoubles) {
  ScratchFolder folder;
  const auto path = folder.path / "statistics.csv";
  StatisticsWriter writer(path, {"elasticity", "contacts"}, false);
  const StatisticsRow row = {7,    1.0 / 30,      12, 1e-3 / 3, "floor", 0.1, 2e-300, {-0.0, 1.0 / 3, 1e22},
                             3.25, {0.1 + 0.2, 5}};
  writer.append(row);
  // The file is read while the writer still lives: a row is there as soon as it is appended.
  const auto lines = split(read_text_file(path), '\n');
  ASSERT_EQ(lines.size(), 2u);
  EXPECT_EQ(
      lines[0],
      "step,time,iterations,residual,stopped,kinetic_energy,elastic_energy,momentum_x,momentum_y,momentum_z,"
      "ms_total,ms_elasticity,ms_contacts");
  auto cells = split(lines[1], ',');
  ASSERT_GT(cells.size(), 4u);
  EXPECT_EQ(cells[4], "floor");
  cells.erase(cells.begin() + 4);
  const std::vector<double> wanted = {7,    1.0 / 30, 12,   1e-3 / 3, 0.1,       2e-300,
                                      -0.0, 1.0 / 3,  1e22, 3.25,     0.1 + 0.2, 5};
  ASSERT_EQ(cells.size(), wanted.size());
  for (std::size_t i = 0; i < cells.size(); ++i) EXPECT_EQ(std::stod(cells[i]), wanted[i]) << cells[i];
  EXPECT_THROW(writer.append({}), Error); // no components
}

// Columns that only some scenes have stand last, and are read back where they are.
TEST(Statistics, ColumnsOfBreakingBondsAndOfEnergies) {
  for (const bool breaks : {false, true})
    for (const bool energies : {false, true}) {
      ScratchFolder folder;
      const auto path = folder.path / "statistics.csv";
      const std::vector<std::string> components{breaks ? "failure" : "motion"};
      StatisticsRow row = {7, 0.5, 12, 1e-3, "tolerance", 0.1, 0.2, {1, 2, 3}, 3.25, {5}};
      if (breaks) row.fracture = {41, 0.25};
      if (energies) row.energy = {1.0 / 3e5, 0};
      StatisticsWriter(path, components, energies).append(row);
      const auto lines = split(read_text_file(path), '\n');
      EXPECT_EQ(lines[0].find(",broken_bonds,fracture_energy") != std::string::npos, breaks);
      EXPECT_EQ(lines[0].find(",energy_error,energy_rises") != std::string::npos, energies);
      const std::vector<StatisticsRow> read = read_statistics(path);
      ASSERT_EQ(read.size(), 1u);
      EXPECT_EQ(read[0].fracture, row.fracture);
      EXPECT_EQ(read[0].energy, row.energy);
      EXPECT_EQ(read[0].ms_components, row.ms_components);
    }
}

TEST(Statistics, AFullDiskTakesBackTheHalfRow) {
  ScratchFolder folder;
  const auto path = folder.path / "statistics.csv";
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {400, 400};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    int status = 0;
    try {
      StatisticsWriter writer(path, {}, false);
      for (std::uint64_t k = 0; k < 100; ++k)
        writer.append({k, 0.125, 3, 0.5, "cap", 1, 2, {3, 4, 5}, 6, {}});
    } catch (const Error& error) {
      status = static_cast<int>(error.code());
    }
    ::_exit(status);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 5);
  const std::string text = read_text_file(path);
  EXPECT_EQ(text.back(), '\n');
  const auto lines = split(text, '\n');
  EXPECT_GT(lines.size(), 5u);
  for (std::size_t i = 1; i < lines.size(); ++i)
    EXPECT_EQ(lines[i], std::to_string(i - 1) + ",0.125,3,0.5,cap,1,2,3,4,5,6");
}

TEST(Folder, IsMadeOrAcceptedWhereEmpty) {
  ScratchFolder folder;
  EXPECT_EQ(refusal(folder.path / "a" / "b"), "accepted");
  EXPECT_TRUE(std::filesystem::is_directory(folder.path / "a" / "b"));
  EXPECT_EQ(refusal(folder.path / "a" / "b"), "accepted");
}

TEST(Folder, RefusesAnOccupiedOneAndSaysWhatToDo) {
  ScratchFolder folder;
  std::ofstream(folder.path / "run.json") << "{}";
  const std::string said = refusal(folder.path);
  EXPECT_THAT(said, HasSubstr("not empty (it holds run.json)"));
  EXPECT_THAT(said, HasSubstr("remove the folder"));
  EXPECT_THAT(refusal(folder.path / "run.json"), HasSubstr("it is a file"));
  EXPECT_EQ(read_text_file(folder.path / "run.json"), "{}");
}

TEST(Folder, SaysWhyItCannotBeMade) {
  ScratchFolder folder;
  std::ofstream(folder.path / "file") << "";
  EXPECT_THAT(refusal(folder.path / "file" / "under"), HasSubstr("Not a directory"));
  EXPECT_THAT(refusal("/proc/pliant-cannot-be-here"),
              HasSubstr("/proc/pliant-cannot-be-here: No such file or directory"));
  if (::geteuid() == 0) GTEST_SKIP() << "root may write everywhere: permissions are not tried";
  ::chmod(folder.path.c_str(), 0500);
  EXPECT_THAT(refusal(folder.path / "new"), HasSubstr("Permission denied"));
  ::chmod(folder.path.c_str(), 0700);
}

TEST(TextFile, IsReplacedWholeAndLeavesNoDraft) {
  ScratchFolder folder;
  const auto path = folder.path / "run.json";
  write_text_file(path, "first");
  write_text_file(path, "");
  EXPECT_EQ(read_text_file(path), "");
  const std::string large(300000, 'x');
  write_text_file(path, large);
  EXPECT_EQ(read_text_file(path), large);
  std::size_t files = 0;
  for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder.path)) ++files;
  EXPECT_EQ(files, 1u);
  EXPECT_THROW(write_text_file(folder.path / "no" / "where", "x"), Error);
  EXPECT_THROW(read_text_file(folder.path / "missing"), Error);
}

// `--json /dev/null` as root must not put a file in the device's place.
TEST(TextFile, APipeIsWrittenIntoAndStays) {
  ScratchFolder folder;
  const auto path = folder.path / "pipe";
  ASSERT_EQ(::mkfifo(path.c_str(), 0600), 0);
  const int reader = ::open(path.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  write_text_file(path, "through");
  char text[16] = {};
  EXPECT_EQ(::read(reader, text, sizeof text), 7);
  EXPECT_STREQ(text, "through");
  ::close(reader);
  EXPECT_TRUE(std::filesystem::is_fifo(path));
  EXPECT_FALSE(std::filesystem::exists(path.string() + ".tmp"));
}

TEST(TextFile, AFullDeviceIsSaidAndStays) {
  const std::filesystem::path full = "/dev/full";
  if (!std::filesystem::is_character_file(full)) GTEST_SKIP() << "no /dev/full here";
  try {
    write_text_file(full, "x");
    ADD_FAILURE() << "it was written";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::input_output);
    EXPECT_THAT(error.what(), HasSubstr("No space left on device"));
  }
  EXPECT_TRUE(std::filesystem::is_character_file(full));
}

TEST(TextFile, AFullDiskLeavesTheOldText) {
  ScratchFolder folder;
  const auto path = folder.path / "run.json";
  write_text_file(path, "old");
  const pid_t child = ::fork();
  if (child == 0) {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit = {1000, 1000};
    ::setrlimit(RLIMIT_FSIZE, &limit);
    int status = 0;
    try {
      write_text_file(path, std::string(5000, 'n'));
    } catch (const Error& error) {
      status = std::string(error.what()).find("File too large") != std::string::npos
                   ? static_cast<int>(error.code())
                   : 1;
    }
    ::_exit(status);
  }
  int status = 0;
  ::waitpid(child, &status, 0);
  EXPECT_EQ(WEXITSTATUS(status), 5);
  EXPECT_EQ(read_text_file(path), "old");
  EXPECT_FALSE(std::filesystem::exists(folder.path / "run.json.tmp"));
}

// Contacts that find no room are said once and counted in run.json.
#include "tests/program/program.h"

#include <nlohmann/json.hpp>

namespace pliant::test {
namespace {

// Four boxes at one place: each particle has 3 x 7 particles of others within reach, more than the 16 of its
// list.
std::string stacked(const Folder& folder, int boxes) {
  std::string text = small_scene;
  text.insert(0, "allow = [\"overlap\"]\n");
  for (int b = 1; b < boxes; ++b)
    text += "[[body]]\nname = \"twin-" + std::to_string(b) +
            "\"\nmaterial = \"rubber\"\nshape = { box = [0.3, 0.2, 0.2], at = [0, 0.12, 0] }\n";
  return folder.write("stacked.toml", text);
}

TEST(ContactsDropped, AreSaidOnceAndCounted) {
  const Folder folder;
  const Outcome run = pliant(folder, {"run", stacked(folder, 4), "--out", "out", "--no-render", "--backend",
                                      "openmp", "--frames", "2", "--progress", "plain"});
  ASSERT_EQ(run.code, 0) << run.err;
  const std::string warning = "contacts found no room";
  const auto first = run.err.find(warning);
  ASSERT_NE(first, std::string::npos) << run.err;
  EXPECT_EQ(run.err.find(warning, first + 1), std::string::npos) << run.err;
  const auto record = nlohmann::json::parse(text_of(folder / "out/run.json"));
  EXPECT_GT(record.at("contacts_dropped").get<int>(), 0); // how many depends on how far they have parted
}

TEST(ContactsDropped, NoneWhereThereIsRoom) {
  const Folder folder;
  const Outcome run = pliant(folder, {"run", stacked(folder, 2), "--out", "out", "--no-render", "--backend",
                                      "openmp", "--frames", "2"});
  ASSERT_EQ(run.code, 0) << run.err;
  EXPECT_EQ(run.err.find("no room"), std::string::npos) << run.err;
  EXPECT_EQ(nlohmann::json::parse(text_of(folder / "out/run.json")).at("contacts_dropped"), 0);
}

} // namespace
} // namespace pliant::test

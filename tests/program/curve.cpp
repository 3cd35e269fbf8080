// `pliant curve` as a user calls it.
#include "tests/program/program.h"

#include <cmath>
#include <nlohmann/json.hpp>

namespace pliant::test {
namespace {

using nlohmann::json;
using testing::HasSubstr;

std::string two_materials() {
  return std::string(small_scene) +
         "[materials.\"neo\"]\nlaw = \"neo-hookean\"\ndensity = 1000\nyoung = 2e5\npoisson = 0.25\n";
}

TEST(Curve, TableFilesAndJson) {
  const Folder folder;
  folder.write("two.toml", two_materials());
  const Outcome ran = pliant(folder, {"curve", "two.toml", "--out", "out", "--json", "all.json"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("rubber: law corotated"));
  EXPECT_THAT(ran.out, HasSubstr("neo: law neo-hookean"));
  EXPECT_THAT(ran.out, HasSubstr("equibiaxial"));
  EXPECT_THAT(ran.out, HasSubstr("pure shear"));
  EXPECT_THAT(ran.out, HasSubstr("largest deviation of the lattice from the continuum"));
  const json report = json::parse(text_of(folder / "all.json"));
  EXPECT_EQ(json::parse(text_of(folder / "out" / "curve.json")), report);
  for (const char* name : {"rubber.svg", "rubber.png", "neo.svg", "neo.png"})
    EXPECT_GT(std::filesystem::file_size(folder / "out" / name), 1000u) << name;
  const std::string csv = text_of(folder / "out" / "curve.csv");
  EXPECT_THAT(csv, HasSubstr("material,test,stretch,lattice_stress_Pa"));
  EXPECT_THAT(csv, HasSubstr("neo,pure shear,2,"));
  // The corotated law in tension is Hooke's: P = E (s - 1), t = 1 - nu (s - 1).
  const json &stretch = report.at("stretch"), &test = report.at("materials").at(0).at("tests").at(0);
  EXPECT_EQ(test.at("test"), "uniaxial");
  for (std::size_t k = 0; k < stretch.size(); ++k) {
    const double s = stretch[k];
    EXPECT_NEAR(test.at("lattice").at("stress")[k].get<double>(), 1e5 * (s - 1), 1e-3);
    EXPECT_NEAR(test.at("continuum").at("lateral")[k].get<double>(), 1 - 0.3 * (s - 1), 1e-8);
  }
}

TEST(Curve, OneMaterialAndItsRange) {
  const Folder folder;
  folder.write("two.toml", two_materials());
  const Outcome ran =
      pliant(folder, {"curve", "two.toml", "--material", "neo", "--from", "0.9", "--to", "1.1", "--json"});
  ASSERT_EQ(ran.code, 0) << ran.err;
  const json report = json::parse(ran.out);
  EXPECT_EQ(report.at("materials").size(), 1u);
  EXPECT_DOUBLE_EQ(report.at("stretch").front(), 0.9);
  EXPECT_DOUBLE_EQ(report.at("stretch").back(), 1.1);
  EXPECT_FALSE(std::filesystem::exists(folder / "out"));
}

TEST(Curve, WhatIsWrongIsSaid) {
  const Folder folder;
  folder.write("two.toml", two_materials());
  Outcome ran = pliant(folder, {"curve", "two.toml", "--material", "steel"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("no material 'steel'; it has rubber, neo"));
  ran = pliant(folder, {"curve", "two.toml", "--from", "1.5", "--to", "1.2"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("--from is above 0 and below --to"));
  ran = pliant(folder, {"curve", "two.toml", "--from", "0"});
  EXPECT_EQ(ran.code, 2);
  ran = pliant(folder, {"curve"});
  EXPECT_EQ(ran.code, 2);
  EXPECT_THAT(ran.err, HasSubstr("no scene is named"));
  ran = pliant(folder, {"curve", "--help"});
  EXPECT_EQ(ran.code, 0);
  EXPECT_THAT(ran.out, HasSubstr("pliant curve examples/stress-strain.toml"));
}

} // namespace
} // namespace pliant::test

// Verification of a fluid: what floats make of a stretch, and where a stretch ends that magnifies it.
#include "engine/report/verify.h"
#include "engine/scene/scene_parse.h"

#include <gtest/gtest.h>

#include <cstdio>
#include <limits>

namespace pliant::test {
namespace {

VerifyReport verified_clay(unsigned steps) {
  const Scene clay = read_scene(PLIANT_SOURCE_DIR "/examples/clay.toml", {"simulation.spacing=0.04"});
  VerifyOptions options;
  options.steps = steps;
  options.kernels = false;
  VerifyReport report = verify_scene(clay, options);
  std::fputs(verify_text(report).c_str(), stdout);
  return report;
}

// Of matter that is bonded anew in each step floats keep most digits: 7e-6 in the first two stretches. Places
// that counted from a corner a hundred spacings away made it 1.0e-4.
TEST(Verify, BondedFluidsAgreeToAFewRoundings) {
  const VerifyReport report = verified_clay(10);
  EXPECT_TRUE(report.good());
  EXPECT_EQ(report.stretches.count, 2u);
  EXPECT_EQ(report.stretches.shortened, 0u);
  ASSERT_GE(report.pairs.size(), 1u);
  for (const VerifyReport::Pair& pair : report.pairs)
    EXPECT_LE(pair.fields.at(1).max_relative, 3e-5) << pair.b;
}

// The scene is its own mirror image; where it slumps fastest, files of particles on the planes between buckle
// to either side, five times as far in each step.
TEST(Verify, StretchesEndWhereTheMatterMagnifiesRounding) {
  const VerifyReport report = verified_clay(40);
  EXPECT_TRUE(report.good());
  EXPECT_EQ(report.stretches.count, 8u);
  EXPECT_GE(report.stretches.shortened, 1u);
  EXPECT_LE(report.stretches.shortened, 6u); // most of the motion is judged
  EXPECT_GE(report.stretches.shortest, 2u);
  EXPECT_GT(report.stretches.growth, verify_growth);
  EXPECT_NE(verify_text(report).find("judged before their end"), std::string::npos);
}

TEST(Verify, AStretchIsJudgedAtItsLastStepThatCanBeTold) {
  constexpr double little = verify_growth / 2, much = verify_growth * 2;
  EXPECT_EQ(judged_steps({little, little, verify_growth}), 3u);
  EXPECT_EQ(judged_steps({little, little, much}), 2u);
  EXPECT_EQ(judged_steps({much, little, much, much}), 2u);
  EXPECT_EQ(judged_steps({much, much}), 1u); // never not at all
  EXPECT_EQ(judged_steps({little, std::numeric_limits<double>::quiet_NaN()}), 1u);
}

} // namespace
} // namespace pliant::test

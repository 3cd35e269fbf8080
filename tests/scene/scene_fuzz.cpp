// Damaged scene files end in a scene or in Error(usage), never otherwise.
#include "parse.h"

#include <fstream>
#include <iterator>
#include <random>

namespace pliant {
namespace {

TEST(SceneFuzz, TwoThousandMutationsOfTheMainJob) {
  std::ifstream stream(PLIANT_SOURCE_DIR "/examples/main-job.toml");
  const std::string original((std::istreambuf_iterator<char>(stream)), {});
  ASSERT_GT(original.size(), 500u);
  const std::vector<std::string> pieces = {"[",          "]",
                                           "{",          "}",
                                           "=",          "\"",
                                           "'",          ",",
                                           ".",          "\n",
                                           "-",          "1e999",
                                           "nan",        "inf",
                                           "0",          "99999999999999999999",
                                           "[[body]]\n", "\"\"\"",
                                           "\\u0000",    "\xff",
                                           "\xe2\x82",   std::string(1, '\0'),
                                           "true",       "1979-05-27",
                                           "[body]\n",   "#",
                                           "material",   "shape = { plane = [0,1,0] }\n",
                                           "\"1/0\"",    "1e308"};
  std::mt19937 random(20181);
  const auto below = [&](std::size_t n) { return static_cast<std::size_t>(random() % n); };
  int scenes = 0, errors = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string text = original;
    for (std::size_t change = 1 + below(4); change-- > 0 && !text.empty();) {
      const std::size_t at = below(text.size());
      switch (below(6)) {
      case 0:
        text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text.erase(at, 1 + below(20));
        break;
      case 2:
        text.insert(at, pieces[below(pieces.size())]);
        break;
      case 3:
        text.resize(at);
        break;
      case 4:
        text.insert(at, text.substr(below(text.size()), below(60)));
        break;
      default: { // a digit or letter for another: stays TOML more often
        const auto found = text.find_first_of("0123456789", at);
        if (found != std::string::npos) text[found] = "0123456789-.e"[below(13)];
      }
      }
    }
    try {
      parsed(text);
      ++scenes;
    } catch (const Error& error) {
      ASSERT_EQ(error.code(), ExitCode::usage) << text;
      ASSERT_EQ(std::string(error.what()).rfind("s.toml:", 0), 0u) << error.what();
      ++errors;
    } catch (const std::exception& error) {
      FAIL() << "mutation " << i << ": " << error.what() << "\n" << text;
    }
  }
  // Both ends of the parser were reached.
  EXPECT_GT(scenes, 100);
  EXPECT_GT(errors, 500);
}

TEST(SceneFuzz, Overrides) {
  const std::vector<std::string> pieces = {"body",  "0",      ".",      "=",         "ball",
                                           "shape", "sphere", "[",      "]",         "{",
                                           "}",     "\"",     "1",      "materials", "rubber",
                                           "young", "-",      "solver", ",",         "'",
                                           "\n",    "nan",    "fixed",  "region",    "99999999999999999999"};
  std::mt19937 random(7);
  int errors = 0;
  for (int i = 0; i < 2000; ++i) {
    std::string text;
    for (std::size_t n = 1 + random() % 8; n-- > 0;) text += pieces[random() % pieces.size()];
    try {
      parsed(small_scene, {text});
    } catch (const Error& error) {
      ASSERT_EQ(error.code(), ExitCode::usage);
      ++errors;
    } catch (const std::exception& error) {
      FAIL() << text << ": " << error.what();
    }
  }
  EXPECT_GT(errors, 1000);
}

TEST(SceneFuzz, DeepNestingIsAnError) {
  EXPECT_NE(complaint("a = " + std::string(100000, '[')), "");
  EXPECT_NE(complaint(small_scene, {"body.0.velocity=" + std::string(100000, '[')}), "");
}

} // namespace
} // namespace pliant

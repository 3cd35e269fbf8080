// Shared by the tests of scene files: a small scene, and what parsing says about it.
#pragma once

#include "engine/core/error.h"
#include "engine/scene/scene_parse.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace pliant {

// Lines: 1 simulation, 3 materials.rubber, 5 body.
inline const std::string small_scene = "[simulation]\n"
                                       "spacing = 0.1\n"
                                       "[materials.rubber]\n"
                                       "young = 1e5\n"
                                       "[[body]]\n"
                                       "name = \"ball\"\n"
                                       "material = \"rubber\"\n"
                                       "shape = { sphere = 0.5 }\n";

inline Scene parsed(const std::string& text, const std::vector<std::string>& overrides = {}) {
  return parse_scene(text, "s.toml", overrides);
}

/// The message of the error that parsing ends with; empty where it succeeds.
inline std::string complaint(const std::string& text, const std::vector<std::string>& overrides = {}) {
  try {
    parsed(text, overrides);
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::usage);
    return error.what();
  }
  return "";
}

/// small_scene with `line` (from 1) replaced.
inline std::string with_line(int line, const std::string& text) {
  std::string result;
  int number = 0;
  std::size_t start = 0;
  while (start < small_scene.size()) {
    const auto end = small_scene.find('\n', start);
    result += ++number == line ? text : small_scene.substr(start, end - start);
    result += '\n';
    start = end + 1;
  }
  return result;
}

} // namespace pliant

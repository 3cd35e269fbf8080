// The tests' own kernel, declared like any other, and its shader.
#pragma once

#define PLIANT_DECL "tests/device/stamp.decl"
#include "kernels/expand.h"
#undef PLIANT_DECL

#include "backends/gl/shader_text.h"
#include "backends/gl/source.h"

namespace pliant::test {

/// The shaders of this build and stamp.comp, which with the option also reads `source` and the table.
inline gl::Texts stamp_texts() {
  gl::Texts texts = gl::shader_texts();
  texts["common/twice.glsl"] = "// included\nuint twice(uint value) { return 2u * value; }\n";
  texts["stamp.comp"] = R"(#include "common/twice.glsl"
#include "common/twice.glsl"
void main() {
  uint i = thread_index();
  if (i >= threads) return;
#if doubled == 1 && !defined(nothing)
  target[i] += twice(source[i]) + offsets[i % 3u].y + uint(factor);
#else
  target[i] += addend; // source and offsets are not used here
#endif
}
)";
  return texts;
}

} // namespace pliant::test

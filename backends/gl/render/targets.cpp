// Allocates textures and ties them to framebuffers.
#include "backends/gl/render/targets.h"

#include "engine/core/error.h"

#include <algorithm>
#include <initializer_list>
#include <string>

namespace pliant::gl {

namespace {

unsigned limit(const GladGLContext& gl, GLenum name) {
  GLint value[2] = {0, 0};
  gl.GetIntegerv(name, value);
  return static_cast<unsigned>(std::max(value[0], 0));
}

unsigned device_samples(const GladGLContext& gl, unsigned wanted) {
  unsigned most =
      std::min({limit(gl, GL_MAX_COLOR_TEXTURE_SAMPLES), limit(gl, GL_MAX_DEPTH_TEXTURE_SAMPLES), 8u});
  most = std::min(most, limit(gl, GL_MAX_SAMPLES));
  return std::max(1u, std::min(wanted, most));
}

std::string size_text(unsigned width, unsigned height) {
  return "a picture of " + std::to_string(width) + " x " + std::to_string(height) + " pixels";
}

void allocate(const GladGLContext& gl, const Texture& texture, GLenum format, unsigned width,
              unsigned height) {
  gl.BindTexture(GL_TEXTURE_2D, texture.name());
  gl.TexStorage2D(GL_TEXTURE_2D, 1, format, static_cast<GLsizei>(width), static_cast<GLsizei>(height));
  gl.BindTexture(GL_TEXTURE_2D, 0);
}

} // namespace

Targets::Targets(const Context& context, unsigned w, unsigned h, unsigned wanted)
    : width(w), height(h), samples(device_samples(context.gl(), wanted)),
      passes((std::max(wanted, 1u) + samples - 1) / samples), colour(context.gl()), normal(context.gl()),
      depth(context.gl()), shadow(context.gl()), rough(context.gl()), between(context.gl()),
      sum(context.gl()), seen(context.gl()), sun(context.gl()), roughly(context.gl()), halfway(context.gl()),
      summed(context.gl()) {
  const GladGLContext& gl = context.gl();
  GLint viewport[2] = {0, 0};
  gl.GetIntegerv(GL_MAX_VIEWPORT_DIMS, viewport);
  const unsigned texture = limit(gl, GL_MAX_TEXTURE_SIZE);
  const unsigned widest = std::min(texture, static_cast<unsigned>(viewport[0]));
  const unsigned highest = std::min(texture, static_cast<unsigned>(viewport[1]));
  if (width == 0 || height == 0 || width > widest || height > highest)
    throw Error(ExitCode::usage, size_text(width, height) + " cannot be drawn: " + context.renderer() +
                                     " draws from 1 x 1 to " + std::to_string(widest) + " x " +
                                     std::to_string(highest) + "; change render.size");
  while (gl.GetError() != GL_NO_ERROR) {
  }
  const auto multisampled = [&](const Texture& t, GLenum format) {
    gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE, t.name());
    gl.TexImage2DMultisample(GL_TEXTURE_2D_MULTISAMPLE, static_cast<GLsizei>(samples), format,
                             static_cast<GLsizei>(width), static_cast<GLsizei>(height), GL_TRUE);
    gl.BindTexture(GL_TEXTURE_2D_MULTISAMPLE, 0);
  };
  gl.ActiveTexture(GL_TEXTURE0);
  multisampled(colour, GL_RGBA8);
  multisampled(normal, GL_RGBA16F);
  multisampled(depth, GL_DEPTH_COMPONENT32F);
  allocate(gl, shadow, GL_DEPTH_COMPONENT32F, map, map);
  allocate(gl, rough, GL_RGBA16F, width, height);
  allocate(gl, between, GL_RGBA16F, width, height);
  allocate(gl, sum, GL_RGBA16F, width, height);
  if (gl.GetError() != GL_NO_ERROR)
    throw Error(ExitCode::usage, size_text(width, height) + " with " + std::to_string(samples) +
                                     " samples does not fit the memory of " + context.renderer() +
                                     "; make render.size or render.samples smaller");

  struct Tie {
    GLenum place;
    const Texture* texture;
    GLenum target;
  };
  const auto tie = [&](const Framebuffer& framebuffer, std::initializer_list<Tie> ties) {
    gl.BindFramebuffer(GL_FRAMEBUFFER, framebuffer.name());
    GLenum drawn[2] = {GL_NONE, GL_NONE};
    for (const Tie& one : ties) {
      gl.FramebufferTexture2D(GL_FRAMEBUFFER, one.place, one.target, one.texture->name(), 0);
      if (one.place != GL_DEPTH_ATTACHMENT) drawn[one.place - GL_COLOR_ATTACHMENT0] = one.place;
    }
    gl.DrawBuffers(2, drawn);
    gl.ReadBuffer(drawn[0]);
    const GLenum status = gl.CheckFramebufferStatus(GL_FRAMEBUFFER);
    if (status != GL_FRAMEBUFFER_COMPLETE)
      throw Error(ExitCode::internal, context.renderer() + " refuses a framebuffer of the renderer (status " +
                                          std::to_string(status) + ")");
  };
  tie(seen, {{GL_COLOR_ATTACHMENT0, &colour, GL_TEXTURE_2D_MULTISAMPLE},
             {GL_COLOR_ATTACHMENT1, &normal, GL_TEXTURE_2D_MULTISAMPLE},
             {GL_DEPTH_ATTACHMENT, &depth, GL_TEXTURE_2D_MULTISAMPLE}});
  gl.BindFramebuffer(GL_FRAMEBUFFER, seen.name());
  gl.GetMultisamplefv(GL_SAMPLE_POSITION, 0, first_sample);
  for (float& place : first_sample) place -= 0.5f;
  if (gl.GetError() != GL_NO_ERROR) first_sample[0] = first_sample[1] = 0; // one sample a pixel: the middle
  tie(sun, {{GL_DEPTH_ATTACHMENT, &shadow, GL_TEXTURE_2D}});
  tie(roughly, {{GL_COLOR_ATTACHMENT0, &rough, GL_TEXTURE_2D}});
  tie(halfway, {{GL_COLOR_ATTACHMENT0, &between, GL_TEXTURE_2D}});
  tie(summed, {{GL_COLOR_ATTACHMENT0, &sum, GL_TEXTURE_2D}});
  gl.BindFramebuffer(GL_FRAMEBUFFER, 0);
}

} // namespace pliant::gl
